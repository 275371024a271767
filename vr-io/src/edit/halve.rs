//! A grid of half as many voxels along each axis: a coarser level of a pyramid.

use glam::{DMat3, DVec3};
use vr_core::{AnyGrid, Calibration, GridError, GridVolume, Placement, UniformGrid, Voxel, parallel};

use crate::error::FieldError;

/// Way in which the voxels of a block become one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reduction {
    /// Their mean, rounded to the nearest where voxels are integers, halves to the even one: right for quantities.
    #[default]
    Mean,
    /// The one that occurs most often, of several the one nearest to the first voxel of the grid: right for numbers that are names.
    Mode,
}

impl Reduction {
    /// Returns the name, as OME-Zarr has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mean => "mean",
            Self::Mode => "mode",
        }
    }
}

/// Returns the number of voxels that become one along each axis: two, or one where an axis is too short to be halved.
pub(crate) fn halving(dims: [usize; 3]) -> [usize; 3] {
    // A grid has two voxels along each axis.
    dims.map(|n| if n > 2 { 2 } else { 1 })
}

/// Returns the dims of the grid that blocks of voxels make: the last block of an odd axis is half full, and counts.
pub(crate) fn halved_dims(dims: [usize; 3]) -> [usize; 3] {
    let factors = halving(dims);
    [0, 1, 2].map(|a| dims[a].div_ceil(factors[a]))
}

/// Returns a grid in which each block of 2×2×2 voxels is one, in the middle of the block; an axis of two voxels stays as it is. A block at the end of
/// an odd axis holds the voxels that there are. Type and calibration stay; a missing voxel counts only where all of a block are missing.
///
/// # Errors
/// A placement that cannot be halved, which none of a file is.
pub fn halve_grid(grid: &GridVolume, reduction: Reduction) -> Result<GridVolume, FieldError> {
    let factors = halving(grid.dims()).map(|f| f as f64);
    let placement = grid.placement();
    let axes = placement.axes() * DMat3::from_diagonal(DVec3::from(factors));
    let first = placement.to_world(DVec3::from(factors.map(|f| 0.5 * (f - 1.0))));
    let wrong = |e: GridError| FieldError::new("level", "another one", e.to_string());
    let placement = Placement::new(first, axes).map_err(wrong)?;
    let calibration = grid.calibration();
    let values = match grid.values() {
        AnyGrid::U8(g) => halved(g, reduction, |x| x as u8, placement, calibration),
        AnyGrid::I8(g) => halved(g, reduction, |x| x as i8, placement, calibration),
        AnyGrid::U16(g) => halved(g, reduction, |x| x as u16, placement, calibration),
        AnyGrid::I16(g) => halved(g, reduction, |x| x as i16, placement, calibration),
        AnyGrid::F32(g) => halved(g, reduction, |x| x as f32, placement, calibration),
    };
    Ok(GridVolume::new(values.map_err(wrong)?, grid.filter()))
}

fn halved<T: Voxel>(
    grid: &UniformGrid<T>,
    reduction: Reduction,
    to: impl Fn(f64) -> T + Sync,
    placement: Placement,
    calibration: Calibration,
) -> Result<AnyGrid, GridError>
where
    AnyGrid: From<UniformGrid<T>>,
{
    let [nx, ny, nz] = grid.dims();
    let [fx, fy, fz] = halving(grid.dims());
    let dims = halved_dims(grid.dims());
    let samples = grid.samples();
    let round = |mean: f64| if T::TYPE.is_integer() { mean.round_ties_even() } else { mean };
    let made = parallel::collect(dims.iter().product(), |i| {
        let [x, y, z] = [i % dims[0] * fx, i / dims[0] % dims[1] * fy, i / dims[0] / dims[1] * fz];
        let (mut block, mut count) = ([T::default(); 8], 0);
        for z in z..(z + fz).min(nz) {
            for y in y..(y + fy).min(ny) {
                let row = (z * ny + y) * nx;
                for &voxel in samples[row + x..row + (x + fx).min(nx)].iter().filter(|voxel| !voxel.is_missing()) {
                    block[count] = voxel;
                    count += 1;
                }
            }
        }
        match (&block[..count], reduction) {
            ([], _) => to(f64::NAN),
            (block, Reduction::Mean) => {
                let sum: f64 = block.iter().map(|voxel| f64::from(voxel.to_f32())).sum();
                to(round(sum / count as f64))
            }
            (block, Reduction::Mode) => most_frequent(block),
        }
    });
    UniformGrid::new(dims, made, placement, calibration).map(AnyGrid::from)
}

/// Returns the voxel that occurs most often, of several the first.
fn most_frequent<T: Voxel>(block: &[T]) -> T {
    let (mut most, mut found) = (0, T::default());
    for &voxel in block {
        let count = block.iter().filter(|&&other| other == voxel).count();
        if count > most {
            (most, found) = (count, voxel);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use vr_core::Filter;

    use super::super::tests::{numbered, samples};
    use super::*;

    fn grid<T: Voxel>(dims: [usize; 3], samples: Vec<T>) -> GridVolume
    where
        AnyGrid: From<UniformGrid<T>>,
    {
        let placement = Placement::from_spacing([1.0, 2.0, 3.0]).unwrap();
        let grid = UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap();
        GridVolume::new(grid.into(), Filter::default())
    }

    #[test]
    fn blocks_become_their_mean_in_their_middle() {
        // Voxel x + 5 y + 20 z of 5×4×3: the mean of a linear function is its value in the middle of the voxels that there are.
        let before = numbered();
        let half = halve_grid(&before, Reduction::Mean).unwrap();
        assert_eq!((half.dims(), half.calibration()), ([3, 2, 2], before.calibration()));
        let middle = |i: usize, n: usize| if 2 * i + 1 < n { 2.0 * i as f32 + 0.5 } else { 2.0 * i as f32 };
        let expected = (0..12).map(|i| {
            let mean = middle(i % 3, 5) + 5.0 * middle(i / 3 % 2, 4) + 20.0 * middle(i / 6, 3);
            mean.round_ties_even()
        });
        assert_eq!(samples(&half), expected.collect::<Vec<_>>());
        let (first, step) = (half.placement(), before.placement());
        assert!((first.origin() - step.to_world(DVec3::splat(0.5))).length() < 1e-12);
        assert!((first.spacing() - 2.0 * step.spacing()).length() < 1e-12);
        // Two voxels along an axis stay two.
        let thin = halve_grid(&half, Reduction::Mean).unwrap();
        assert_eq!(thin.dims(), [2, 2, 2]);
        assert_eq!(thin.placement().spacing().y, half.placement().spacing().y);
    }

    #[test]
    fn names_stay_names_and_missing_voxels_count_where_all_are() {
        let names = grid([4, 2, 2], vec![7u8, 7, 3, 9, 7, 2, 3, 9, 200, 200, 9, 9, 7, 200, 3, 1]);
        // An axis of two stays: pairs along x alone, of which the first is taken where they differ.
        assert_eq!(samples(&halve_grid(&names, Reduction::Mode).unwrap()), [7., 3., 7., 3., 200., 9., 7., 3.]);
        assert_eq!(most_frequent(&[1u8, 5, 5, 2, 2, 5]), 5);
        let missing = grid([4, 2, 2], [f32::NAN, 4.0, f32::NAN, f32::NAN, 1.0, 2.0, 3.0, 5.0].repeat(2));
        let found = samples(&halve_grid(&missing, Reduction::Mean).unwrap());
        assert!(found[0] == 4.0 && found[1].is_nan() && found[2] == 1.5 && found[3] == 4.0, "{found:?}");
    }
}
