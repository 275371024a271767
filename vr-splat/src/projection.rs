//! From the world to what a view sees of kernels: lateral places, depths, and footprints' extents.

use glam::{DMat3, DVec3};
use vr_core::{ParameterError, Projection, Rays, View};

/// A view, measured in units of about a voxel.
///
/// A place is (x, y, z): x to the right, y up, z the depth behind `base` along the view. A ray passes (X·z̃ , Y·z̃) at depth z, where z̃ is the distance
/// from the eye's plane in perspective and 1 in parallel projection.
pub(crate) struct SplatView {
    pub(crate) rays: Rays,
    pub(crate) size: [u32; 2],
    eye: DVec3,
    /// To the right, up, and along the view, in the world.
    pub(crate) frame: DMat3,
    pub(crate) perspective: bool,
    /// World length of a unit.
    pub(crate) unit: f64,
    /// Depth of the eye's plane is 0, in units; what is drawn begins here.
    pub(crate) base: f64,
    /// X from one subpixel to the next, and one over that.
    pixel: f64,
    per_pixel: f64,
    /// Subpixels along the edge of a pixel.
    samples: f64,
    pub(crate) kernel: KernelSpace,
}

/// Kernel space, in which a kernel of scale 1 reaches to 1, relative to the view.
pub(crate) struct KernelSpace {
    /// The view's axes, mapped to kernel space.
    pub(crate) axes: DMat3,
    /// Half the extent of the unit ball or cube along x, y, z.
    pub(crate) half: DVec3,
}

impl KernelSpace {
    /// From the axes' images, for balls or for cubes.
    pub(crate) fn new(axes: DMat3, cube: bool) -> Self {
        let inverse = axes.inverse().transpose();
        let rows = [inverse.x_axis, inverse.y_axis, inverse.z_axis];
        let extent = |row: DVec3| if cube { row.abs().element_sum() } else { row.length() };
        Self { axes, half: DVec3::new(extent(rows[0]), extent(rows[1]), extent(rows[2])) }
    }
}

/// Tells that a rectangle of pixels is all of the picture.
const EVERYWHERE: f64 = 1e9;

impl SplatView {
    /// Projection of a view with its subpixels as pixels. `of_world` takes world vectors to kernel space; `bounds` hold all that is drawn, but
    /// for the margin that a low-pass of so many pixels adds.
    pub(crate) fn new(
        view: &View,
        unit: f64,
        of_world: Option<DMat3>,
        cube: bool,
        bounds: (DVec3, DVec3),
        low_pass: f64,
    ) -> Result<Self, ParameterError> {
        view.validate()?;
        let fine =
            View { size: view.size.map(|n| n.saturating_mul(view.supersampling)), supersampling: 1, ..view.clone() };
        let rays = Rays::new(&fine)?;
        let frame = view.camera.frame()?;
        let (perspective, height) = match view.camera.projection {
            Projection::Orthographic { height } => (false, height / unit),
            Projection::Perspective { fov } => (true, 2.0 * libm::tan(0.5 * fov.to_radians())),
        };
        let pixel = height / f64::from(fine.size[1]);
        let axes = of_world.map_or(DMat3::IDENTITY, |m| m * frame * unit);
        let mut made = Self {
            rays,
            size: fine.size,
            eye: view.camera.eye,
            frame,
            perspective,
            unit,
            base: 0.0,
            pixel,
            per_pixel: 1.0 / pixel,
            samples: f64::from(view.supersampling),
            kernel: KernelSpace::new(axes, cube),
        };
        let corner = |i: usize| {
            let pick = |a: usize| if i >> a & 1 == 0 { bounds.0[a] } else { bounds.1[a] };
            made.place(DVec3::new(pick(0), pick(1), pick(2))).z
        };
        let corners: [f64; 8] = std::array::from_fn(corner);
        let [nearest, farthest] =
            [corners.into_iter().fold(f64::INFINITY, f64::min), corners.into_iter().fold(0.0, f64::max)];
        // Widened kernels begin before what they are of.
        made.base = (nearest - low_pass * made.pixel_at(farthest)).max(0.0);
        Ok(made)
    }

    /// The place of a world position.
    #[inline]
    pub(crate) fn place(&self, world: DVec3) -> DVec3 {
        self.place_of_vector(world - self.eye) - DVec3::new(0.0, 0.0, self.base)
    }

    /// The change of place of a world vector.
    pub(crate) fn place_of_vector(&self, vector: DVec3) -> DVec3 {
        let v = vector / self.unit;
        DVec3::new(self.frame.x_axis.dot(v), self.frame.y_axis.dot(v), self.frame.z_axis.dot(v))
    }

    /// X and Y of a point of the image, in pixels.
    pub(crate) fn lateral(&self, x: f64, y: f64) -> [f64; 2] {
        let [w, h] = self.size.map(f64::from);
        [(x - 0.5 * w) * self.pixel, (0.5 * h - y) * self.pixel]
    }

    /// World length per unit of depth along the ray through X and Y.
    pub(crate) fn stretch(&self, [x, y]: [f64; 2]) -> f64 {
        if self.perspective { self.unit * (1.0 + x * x + y * y).sqrt() } else { self.unit }
    }

    /// Distance from the eye's plane by which X and Y are multiplied at a depth behind `base`.
    pub(crate) fn lever(&self, z: f64) -> f64 {
        if self.perspective { z + self.base } else { 1.0 }
    }

    /// Length of a pixel of the picture at a depth behind `base`.
    pub(crate) fn pixel_at(&self, z: f64) -> f64 {
        self.pixel * self.samples * self.lever(z).abs()
    }

    /// First and last pixel, column and row, whose centres a kernel may reach; `None` if there is none.
    #[inline]
    pub(crate) fn rectangle(&self, place: [f32; 3], scale: f32) -> Option<[u32; 4]> {
        let [x, y, z] = place.map(f64::from);
        let half = self.kernel.half * (1.0 / f64::from(scale));
        let [left, right, low, high] = if self.perspective {
            let (near, far) = (z + self.base - half.z, z + self.base + half.z);
            if far <= 0.0 {
                return None;
            }
            if near <= 1e-6 * far {
                [-EVERYWHERE, EVERYWHERE, -EVERYWHERE, EVERYWHERE]
            } else {
                let (a, b) = (1.0 / near, 1.0 / far);
                let min = |v: f64| if v < 0.0 { v * a } else { v * b };
                let max = |v: f64| if v > 0.0 { v * a } else { v * b };
                [min(x - half.x), max(x + half.x), min(y - half.y), max(y + half.y)]
            }
        } else {
            [x - half.x, x + half.x, y - half.y, y + half.y]
        };
        let [w, h] = self.size.map(f64::from);
        // Pixel i has its centre at i + ½; a hair more for rounding.
        let slack = 1e-3;
        let [left, right, low, high] = [left, right, low, high].map(|x| x * self.per_pixel);
        let columns = [left + 0.5 * w - 0.5 - slack, right + 0.5 * w - 0.5 + slack];
        let rows = [0.5 * h - high - 0.5 - slack, 0.5 * h - low - 0.5 + slack];
        if columns[1] < 0.0 || rows[1] < 0.0 || columns[0] > w - 1.0 || rows[0] > h - 1.0 {
            return None;
        }
        // `as` saturates, and rounds down what is not negative: no call for either, where the instruction is not there.
        let first = |v: f64| {
            let whole = v.max(0.0) as u32;
            whole + u32::from(f64::from(whole) < v)
        };
        let last = |v: f64, n: u32| (v as u32).min(n - 1);
        let found = [first(columns[0]), last(columns[1], self.size[0]), first(rows[0]), last(rows[1], self.size[1])];
        (found[0] <= found[1] && found[2] <= found[3]).then_some(found)
    }

    /// Depth extent of a kernel of scale 1, either way.
    pub(crate) fn half_depth(&self) -> f64 {
        self.kernel.half.z
    }
}
