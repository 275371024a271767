//! A body without any symmetry, as voxels in every order and direction of the axes.

use glam::{DMat3, DVec3};

/// Voxels of a body, and their places in a patient's world, RAS, in mm.
#[derive(Clone, Debug)]
pub struct Phantom {
    /// Voxels along x, y and z.
    pub dims: [usize; 3],
    /// Position of the first voxel.
    pub origin: DVec3,
    /// Steps from voxel to voxel. Each is a sum of few powers of two, which 32 bits and decimals hold exactly.
    pub axes: DMat3,
    /// Values, x fastest: from 0 to 1000.
    pub values: Vec<i16>,
}

/// Order and direction of the axes of a file: its axis `i` runs along axis `from[i]` of the phantom, backwards if `flipped[i]`.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    pub from: [usize; 3],
    pub flipped: [bool; 3],
}

impl Turn {
    pub const NONE: Self = Self { from: [0, 1, 2], flipped: [false; 3] };

    pub fn flipped(flipped: [bool; 3]) -> Self {
        Self { flipped, ..Self::NONE }
    }

    pub fn along(from: [usize; 3], flipped: [bool; 3]) -> Self {
        Self { from, flipped }
    }
}

impl Phantom {
    /// Turned about two axes of the patient; a spacing of 25/32, 75/64 and 25/16 mm.
    pub fn oblique() -> Self {
        let axes = DMat3::from_cols(
            DVec3::new(15.0, 12.0, 16.0) / 32.0,
            DVec3::new(-60.0, 27.0, 36.0) / 64.0,
            DVec3::new(0.0, -20.0, 15.0) / 16.0,
        );
        Self::of([27, 22, 15], axes)
    }

    /// Along the axes of the patient; a spacing of 25/32, 75/64 and 25/16 mm.
    pub fn upright() -> Self {
        Self::of([27, 22, 15], DMat3::from_diagonal(DVec3::new(25.0 / 32.0, 75.0 / 64.0, 25.0 / 16.0)))
    }

    fn of(dims: [usize; 3], axes: DMat3) -> Self {
        let middle = DVec3::from_array(dims.map(|n| (n - 1) as f64 / 2.0));
        let origin = CENTER - axes * middle;
        let mut values = Vec::with_capacity(dims.iter().product());
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                for x in 0..dims[0] {
                    values.push(value(origin + axes * DVec3::new(x as f64, y as f64, z as f64)));
                }
            }
        }
        Self { dims, origin, axes, values }
    }

    /// The same voxels at the same places, in another order.
    pub fn turned(&self, Turn { from, flipped }: Turn) -> Self {
        let dims = from.map(|axis| self.dims[axis]);
        // Index in the phantom of the first voxel, and the steps from it.
        let mut first = [0; 3];
        let mut axes = DMat3::ZERO;
        for i in 0..3 {
            let step = self.axes.col(from[i]);
            *axes.col_mut(i) = if flipped[i] { -step } else { step };
            if flipped[i] {
                first[from[i]] = dims[i] - 1;
            }
        }
        let origin = self.origin + self.axes * DVec3::from_array(first.map(|n| n as f64));
        let mut values = Vec::with_capacity(self.values.len());
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                for x in 0..dims[0] {
                    let mut at = [0; 3];
                    for (i, n) in [x, y, z].into_iter().enumerate() {
                        at[from[i]] = if flipped[i] { dims[i] - 1 - n } else { n };
                    }
                    values.push(self.values[(at[2] * self.dims[1] + at[1]) * self.dims[0] + at[0]]);
                }
            }
        }
        Self { dims, origin, axes, values }
    }

    /// Distances from voxel to voxel along each axis.
    pub fn spacing(&self) -> DVec3 {
        DVec3::new(self.axes.x_axis.length(), self.axes.y_axis.length(), self.axes.z_axis.length())
    }

    /// Directions of the axes, of length 1.
    pub fn directions(&self) -> DMat3 {
        self.axes * DMat3::from_diagonal(self.spacing().recip())
    }

    /// Values as little-endian bytes.
    pub fn bytes(&self) -> Vec<u8> {
        self.values.iter().flat_map(|v| v.to_le_bytes()).collect()
    }
}

/// Middle of the body: nothing is as it should be by chance if an origin is lost, or its sign.
const CENTER: DVec3 = DVec3::new(-12.5, 31.25, 140.625);

/// A trunk, a nose in front, and an apple in the raised left hand: the brightest thing is left, in front and above.
fn value(world: DVec3) -> i16 {
    let p = world - CENTER;
    // A ball that fades over a millimetre at its surface.
    let ball = |center: [f64; 3], radius: f64| {
        let inside = radius - (p - DVec3::from_array(center)).length();
        (inside + 0.5).clamp(0.0, 1.0)
    };
    let trunk = (4.5 - (p * DVec3::new(1.0, 1.2, 0.8)).length() + 0.5).clamp(0.0, 1.0);
    let body = (350.0 * trunk).max(450.0 * ball([0.5, 4.0, 1.0], 2.0)).max(280.0 * ball([3.5, -1.0, -4.0], 2.5));
    body.max(1000.0 * ball([-5.0, 3.0, 4.0], 2.0)).round() as i16
}
