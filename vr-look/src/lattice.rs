//! Samples of a volume on a lattice of at most a million places.

use glam::{DMat3, DVec3};
use vr_core::parallel::collect;
use vr_core::{Field, GridVolume, UniformGrid, Volume, Voxel, with_grid};

/// Largest number of voxels that are looked at.
const MAX_SAMPLES: usize = 1 << 20;
/// Places along each axis of a volume that is no grid: its values are computed.
const FIELD_SIDE: usize = 48;

/// Samples of a volume, x fastest.
pub(crate) struct Lattice {
    pub dims: [usize; 3],
    /// Calibrated values; NaN in vacuum.
    pub values: Vec<f64>,
    /// Value of the next voxel along x; NaN where there is none. Empty for volumes that are no grids of integers.
    pub next: Vec<f64>,
    /// Magnitude of the gradient, per voxel; 0 where it is unknown.
    pub changes: Vec<f64>,
    /// World position of the first place.
    pub origin: DVec3,
    /// World vectors from one place to the next.
    pub axes: DMat3,
}

/// Samples of one slice, in the order of the lattice's own.
#[derive(Default)]
struct Slice {
    values: Vec<f64>,
    next: Vec<f64>,
    changes: Vec<f64>,
}

impl Lattice {
    pub fn new(volume: &Volume) -> Self {
        match volume {
            Volume::Grid(grid) => of_grid(grid),
            Volume::Color(colors) => of_grid(colors.values()),
            Volume::Points(points) => of_field(&**points),
            Volume::Cells(mesh) => of_field(&**mesh),
            Volume::Rectilinear(grid) => of_field(&**grid),
            Volume::Amr(grid) => of_field(&**grid),
            Volume::Field(field) => of_field(&**field),
        }
    }

    /// World position of a place.
    pub fn position(&self, [x, y, z]: [usize; 3]) -> DVec3 {
        self.origin + self.axes * DVec3::new(x as f64, y as f64, z as f64)
    }

    /// World positions of the outermost places, half a step further out.
    pub fn corners(&self) -> [DVec3; 8] {
        let last = DVec3::from_array(self.dims.map(|n| n as f64 - 0.5));
        [0, 1, 2, 3, 4, 5, 6, 7].map(|i| {
            let end = |bit: usize, last: f64| if i >> bit & 1 == 1 { last } else { -0.5 };
            self.origin + self.axes * DVec3::new(end(0, last.x), end(1, last.y), end(2, last.z))
        })
    }

    /// The place that is next to a world position, if there is one within half a step.
    pub fn nearest(&self, inverse_axes: DMat3, at: DVec3) -> Option<usize> {
        let index = inverse_axes * (at - self.origin) + 0.5;
        let [nx, ny, nz] = self.dims;
        let end = DVec3::new(nx as f64, ny as f64, nz as f64);
        if !(index.cmpge(DVec3::ZERO).all() && index.cmplt(end).all()) {
            return None;
        }
        Some((index.z as usize * ny + index.y as usize) * nx + index.x as usize)
    }
}

fn of_grid(grid: &GridVolume) -> Lattice {
    let (full, placement) = (grid.dims(), grid.placement());
    let strides = strides(full);
    let dims = [0, 1, 2].map(|a| full[a].div_ceil(strides[a]));
    let slices = with_grid!(grid.values(), g => collect(dims[2], |z| slice(g, strides, dims, z * strides[2])));
    let steps = DVec3::from_array(strides.map(|s| s as f64));
    Lattice {
        dims,
        values: together(&slices, |s| &s.values),
        next: together(&slices, |s| &s.next),
        changes: together(&slices, |s| &s.changes),
        origin: placement.origin(),
        axes: placement.axes() * DMat3::from_diagonal(steps),
    }
}

fn together(slices: &[Slice], part: impl Fn(&Slice) -> &Vec<f64>) -> Vec<f64> {
    slices.iter().map(|s| part(s).as_slice()).collect::<Vec<_>>().concat()
}

/// Voxels from one sample to the next, so that there are no more than [`MAX_SAMPLES`].
fn strides(full: [usize; 3]) -> [usize; 3] {
    let at = |side: usize| full.map(|n| n.div_ceil(side).max(1));
    let count = |strides: [usize; 3]| (0..3).map(|a| full[a].div_ceil(strides[a])).product::<usize>();
    // Halved until few enough: thin volumes keep every slice.
    let mut side = full.into_iter().max().unwrap_or(1);
    while side > 1 && count(at(side)) > MAX_SAMPLES {
        side -= side.div_ceil(8);
    }
    at(side.max(1))
}

fn slice<T: Voxel>(grid: &UniformGrid<T>, strides: [usize; 3], dims: [usize; 3], z: usize) -> Slice {
    let [nx, ny, nz] = grid.dims();
    let calibration = grid.calibration();
    let is_integer = T::TYPE.is_integer();
    let value = |sample: T| {
        let value = calibration.value(f64::from(sample.to_f32()));
        if is_integer || value.is_finite() { value } else { f64::NAN }
    };
    // Squared change per voxel between two neighbours that are one voxel apart, or two.
    let square = |low: T, high: T, per_voxel: f64| {
        let change = (value(high) - value(low)) * per_voxel;
        if change.is_nan() { 0.0 } else { change * change }
    };
    let row = |y: usize, z: usize| &grid.samples()[(z * ny + y) * nx..][..nx];
    let around = |i: usize, n: usize| {
        let (low, high) = (i.saturating_sub(1), (i + 1).min(n - 1));
        (low, high, if high - low == 2 { 0.5 } else { 1.0 })
    };

    let count = dims[0] * dims[1];
    let [mut values, mut next, mut changes] = [(); 3].map(|()| Vec::with_capacity(count));
    let (z_low, z_high, per_z) = around(z, nz);
    for y in (0..dims[1]).map(|y| y * strides[1]) {
        let (y_low, y_high, per_y) = around(y, ny);
        let (here, below, above) = (row(y, z), row(y_low, z), row(y_high, z));
        let (before, behind) = (row(y, z_low), row(y, z_high));
        for x in (0..nx).step_by(strides[0]) {
            let (x_low, x_high, per_x) = around(x, nx);
            let squares = square(here[x_low], here[x_high], per_x)
                + square(below[x], above[x], per_y)
                + square(before[x], behind[x], per_z);
            values.push(value(here[x]));
            if is_integer {
                next.push(if x + 1 < nx { value(here[x + 1]) } else { f64::NAN });
            }
            changes.push(squares.sqrt());
        }
    }
    Slice { values, next, changes }
}

fn of_field(field: &dyn Field) -> Lattice {
    let (low, high) = field.bounds();
    let dims = [FIELD_SIDE; 3];
    // Places in the middles of cells: faces may be vacuum.
    let step = (high - low) / FIELD_SIDE as f64;
    let origin = low + 0.5 * step;
    let value = |[x, y, z]: [usize; 3]| {
        let at = origin + step * DVec3::new(x as f64, y as f64, z as f64);
        field.value(at).filter(|v| v.is_finite()).unwrap_or(f64::NAN)
    };
    let slices = collect(FIELD_SIDE, |z| {
        let row = |y| (0..FIELD_SIDE).map(move |x| [x, y, z]);
        Slice { values: (0..FIELD_SIDE).flat_map(row).map(value).collect(), ..Slice::default() }
    });
    let values = together(&slices, |s| &s.values);
    // Changes from place to place, in the field's own spacing.
    let per_spacing = field.spacing() / step.min_element().max(f64::MIN_POSITIVE);
    let at = |x: usize, y: usize, z: usize| (z * FIELD_SIDE + y) * FIELD_SIDE + x;
    let changes = collect(values.len(), |i| {
        let (x, y, z) = (i % FIELD_SIDE, i / FIELD_SIDE % FIELD_SIDE, i / (FIELD_SIDE * FIELD_SIDE));
        let after = |n: usize| (n + 1).min(FIELD_SIDE - 1);
        let neighbours = [at(after(x), y, z), at(x, after(y), z), at(x, y, after(z))];
        let changes = neighbours.map(|n| values[n] - values[i]).map(|c| if c.is_nan() { 0.0 } else { c });
        per_spacing.min(1.0) * changes.iter().map(|c| c * c).sum::<f64>().sqrt()
    });
    Lattice { dims, values, next: Vec::new(), changes, origin, axes: DMat3::from_diagonal(step) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, Placement};

    #[test]
    fn a_large_grid_is_sampled_and_a_thin_one_keeps_its_slices() {
        assert_eq!(strides([64, 64, 64]), [1, 1, 1]);
        let strides_of = strides([512, 512, 20]);
        assert_eq!(strides_of[2], 1);
        let large = strides([512, 512, 512]);
        assert!(large.iter().all(|&s| s >= 5) && (512usize.div_ceil(large[0])).pow(3) <= MAX_SAMPLES);
        assert_eq!(strides([1, 1, 1]), [1, 1, 1]);
    }

    #[test]
    fn values_gradients_and_places_are_those_of_the_grid() {
        let samples: Vec<f32> = (0..5 * 4 * 3).map(|i| (i % 5) as f32 + 10.0 * (i / 5 % 4) as f32).collect();
        let placement = Placement::from_spacing([2.0, 1.0, 1.0]).unwrap();
        let grid = UniformGrid::new([5, 4, 3], samples, placement, Calibration::default()).unwrap();
        let lattice = Lattice::new(&grid.into());
        assert_eq!(lattice.values[1], 1.0);
        assert!((lattice.changes[6] - 101f64.sqrt()).abs() < 1e-12);
        assert_eq!(lattice.position([1, 2, 0]), DVec3::new(2.0, 2.0, 0.0));
        let inverse = lattice.axes.inverse();
        assert_eq!(lattice.nearest(inverse, DVec3::new(2.4, 0.4, 0.0)), Some(1));
        assert_eq!(lattice.nearest(inverse, DVec3::new(-1.5, 0.0, 0.0)), None);
    }
}
