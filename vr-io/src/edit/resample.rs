//! The field of a grid at the points of another lattice.

use glam::DMat3;
use vr_core::filter::Reconstruction;
use vr_core::{
    AnyGrid, Calibration, Filter, GridError, GridVolume, Placement, Sampler, SamplerVisitor, UniformGrid, Voxel,
    VoxelType, parallel, sample_count,
};

use crate::error::FieldError;

/// Returns a grid of other dims over the same box, from the first to the last voxel of each axis: values are interpolated linearly
/// between the eight voxels around them, without smoothing, so that a smaller grid may miss what is finer than its voxels. Type and
/// calibration stay; integers are rounded. A voxel beside a missing one is missing.
///
/// # Errors
/// Dims that make no grid.
pub fn resample_grid(grid: &GridVolume, dims: [usize; 3]) -> Result<GridVolume, FieldError> {
    let wrong = |e: GridError| FieldError::new("resample", format!("{dims:?}"), e.to_string());
    sample_count(dims).map_err(wrong)?;
    let before = grid.dims();
    let stretch = [0, 1, 2].map(|a| (before[a] - 1) as f64 / (dims[a] - 1) as f64);
    let axes = grid.placement().axes() * DMat3::from_diagonal(stretch.into());
    let placement = Placement::new(grid.placement().origin(), axes).map_err(wrong)?;
    let is_integer = grid.voxel_type().is_integer();
    let numbers = grid.with_filter(Filter::Trilinear).with_sampler(AtLattice { before, dims, is_integer });
    let calibration = grid.calibration();
    let values = match grid.voxel_type() {
        VoxelType::U8 => made(dims, numbers.iter().map(|&x| x as u8).collect(), placement, calibration),
        VoxelType::I8 => made(dims, numbers.iter().map(|&x| x as i8).collect(), placement, calibration),
        VoxelType::U16 => made(dims, numbers.iter().map(|&x| x as u16).collect(), placement, calibration),
        VoxelType::I16 => made(dims, numbers.iter().map(|&x| x as i16).collect(), placement, calibration),
        VoxelType::F32 => made(dims, numbers, placement, calibration),
    };
    Ok(GridVolume::new(values.map_err(wrong)?, grid.filter()))
}

fn made<T: Voxel>(
    dims: [usize; 3],
    samples: Vec<T>,
    placement: Placement,
    calibration: Calibration,
) -> Result<AnyGrid, GridError>
where
    AnyGrid: From<UniformGrid<T>>,
{
    UniformGrid::new(dims, samples, placement, calibration).map(AnyGrid::from)
}

/// Stored numbers at the points of a lattice over the box; f32 holds every integer of 16 bits.
struct AtLattice {
    before: [usize; 3],
    dims: [usize; 3],
    is_integer: bool,
}

impl SamplerVisitor for AtLattice {
    type Output = Vec<f32>;

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> Vec<f32> {
        let Self { before, dims, is_integer } = self;
        // Multiplied first: the last point is the last voxel, exactly.
        let at = |axis: usize, i: usize| (i * (before[axis] - 1)) as f64 / (dims[axis] - 1) as f64;
        parallel::collect(dims.iter().product(), |i| {
            let (x, y, z) = (i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]);
            let value = sampler.value([at(0, x), at(1, y), at(2, z)]);
            (if is_integer { value.round() } else { value }) as f32
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{numbered, samples};
    use super::*;

    fn floats(samples: Vec<f32>) -> GridVolume {
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid = UniformGrid::new([3, 2, 2], samples, placement, Calibration::default()).unwrap();
        GridVolume::new(grid.into(), Filter::default())
    }

    #[test]
    fn the_box_stays_and_linear_functions_are_exact() {
        let grid = numbered();
        let fine = resample_grid(&grid, [9, 7, 5]).unwrap();
        let apart = fine.corners().into_iter().zip(grid.corners()).map(|(a, b)| (a - b).length());
        assert!(apart.into_iter().all(|d| d < 1e-12));
        assert_eq!((fine.voxel_type(), fine.calibration()), (grid.voxel_type(), grid.calibration()));
        // Voxel x + 5 y + 20 z, at steps of ½: halves are rounded away from 0.
        let expected = (0..9 * 7 * 5).map(|i| {
            let (x, y, z) = (i % 9, i / 9 % 7, i / 63);
            (x as f32 / 2.0 + 5.0 * y as f32 / 2.0 + 20.0 * z as f32 / 2.0).round()
        });
        assert_eq!(samples(&fine), expected.collect::<Vec<_>>());
        assert_eq!(samples(&resample_grid(&fine, grid.dims()).unwrap()), samples(&grid));
        assert!(resample_grid(&grid, [1, 4, 3]).unwrap_err().to_string().contains("resample: found [1, 4, 3]"));
    }

    #[test]
    fn missing_voxels_stay_missing() {
        let mut voxels: Vec<f32> = (0..12).map(|i| i as f32).collect();
        voxels[0] = f32::NAN;
        let fine = resample_grid(&floats(voxels), [5, 3, 3]).unwrap();
        let found = samples(&fine);
        assert!(found[0].is_nan() && found[1].is_nan() && found[4] == 2.0, "{found:?}");
    }
}
