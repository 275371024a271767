//! Refined grid: the same trilinear field on more voxels.

use std::cmp::min;

use vr_core::{AnyGrid, Calibration, Filter, Placement, Scene, UniformGrid, Volume};

/// Largest number of cells along each axis that is refined: of larger volumes the middle is taken.
const MAX_CELLS: usize = 32;

/// Returns the middle of a scene's volume with each cell cut into `parts`³: where the voxels are finite, the field is the same up to rounding. `None` for
/// a field that is not trilinear or not on a uniform grid, and for one with missing voxels.
pub(crate) fn refined(scene: &Scene, parts: usize) -> Option<Scene> {
    let volume = scene.volume.grid()?;
    if volume.filter() != Filter::Trilinear || volume.value_stats().has_missing() {
        return None;
    }
    let calibration = volume.calibration();
    let value: Box<dyn Fn([usize; 3]) -> f64> = match volume.values() {
        AnyGrid::U8(g) => sample_of(g),
        AnyGrid::I8(g) => sample_of(g),
        AnyGrid::U16(g) => sample_of(g),
        AnyGrid::I16(g) => sample_of(g),
        AnyGrid::F32(g) => sample_of(g),
    };
    let cells = volume.dims().map(|n| min(n - 1, MAX_CELLS));
    let first: [usize; 3] = std::array::from_fn(|a| (volume.dims()[a] - 1 - cells[a]) / 2);
    let dims = cells.map(|n| n * parts + 1);
    let mut samples = Vec::with_capacity(dims.iter().product());
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let fine = [x, y, z];
                let low: [usize; 3] = std::array::from_fn(|a| min(fine[a] / parts, cells[a] - 1));
                let t: [f64; 3] = std::array::from_fn(|a| (fine[a] - low[a] * parts) as f64 / parts as f64);
                let mut sum = 0.0;
                for corner in 0..8 {
                    let high: [usize; 3] = std::array::from_fn(|a| corner >> a & 1);
                    let weight: f64 = (0..3).map(|a| if high[a] == 1 { t[a] } else { 1.0 - t[a] }).product();
                    sum += weight * value(std::array::from_fn(|a| first[a] + low[a] + high[a]));
                }
                samples.push(calibration.value(sum) as f32);
            }
        }
    }
    let axes = volume.placement().axes() * (1.0 / parts as f64);
    let origin = volume.placement().to_world(glam::DVec3::from_array(first.map(|i| i as f64)));
    let placement = Placement::new(origin, axes).ok()?;
    let grid = UniformGrid::new(dims, samples, placement, Calibration::default()).ok()?;
    Some(Scene { volume: Volume::from(grid), ..scene.clone() })
}

fn sample_of<T: vr_core::Voxel>(grid: &UniformGrid<T>) -> Box<dyn Fn([usize; 3]) -> f64 + '_> {
    let [nx, ny, _] = grid.dims();
    Box::new(move |[x, y, z]| f64::from(grid.samples()[(z * ny + y) * nx + x].to_f32()))
}
