//! Grids made from grids: parts, reversed axes, other sizes and other types of voxels.

mod convert;
mod halve;
mod part;
mod resample;

pub use convert::{Rounding, convert_grid};
pub use halve::{Reduction, halve_grid};
pub(crate) use halve::{halved_dims, halving};
pub use part::{crop_grid, flip_grid};
pub use resample::resample_grid;

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};
    use vr_core::{Calibration, Filter, GridVolume, Placement, UniformGrid, Voxel, with_grid};

    /// A turned and mirrored box with its voxels numbered, none of its axes like another.
    pub fn numbered() -> GridVolume {
        let axes = DMat3::from_cols(DVec3::new(0.0, 2.0, 0.0), DVec3::new(-0.5, 0.0, 0.0), DVec3::new(0.0, 0.0, -3.0));
        let placement = Placement::new(DVec3::new(10.0, -20.0, 5.0), axes).unwrap();
        let samples: Vec<i16> = (0..60).collect();
        let calibration = Calibration { slope: 0.5, intercept: -10.0 };
        GridVolume::new(UniformGrid::new([5, 4, 3], samples, placement, calibration).unwrap().into(), Filter::default())
    }

    pub fn samples(grid: &GridVolume) -> Vec<f32> {
        with_grid!(grid.values(), g => g.samples().iter().map(|s| s.to_f32()).collect())
    }

    /// The stored number of each voxel with its place in the world, sorted.
    pub fn in_world(grid: &GridVolume) -> Vec<(f32, [i64; 3])> {
        let [nx, ny, _] = grid.dims();
        let place = |i: usize| {
            let index = DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64);
            grid.placement().to_world(index).to_array().map(|x| (x * 1e6).round() as i64)
        };
        let mut all: Vec<_> = samples(grid).into_iter().enumerate().map(|(i, s)| (s, place(i))).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    }
}
