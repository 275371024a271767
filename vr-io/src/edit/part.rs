//! Parts of a grid, in the order of its axes or reversed.

use std::ops::Range;

use glam::{DMat3, DVec3};
use vr_core::{AnyGrid, GridVolume, Placement, UniformGrid, Voxel, with_grid};

use crate::error::FieldError;

/// Returns the voxels of a box, each where it was in the world. Ranges are half open; each holds at least two voxels.
///
/// # Errors
/// A range that reaches beyond the grid, or holds less than two voxels.
pub fn crop_grid(grid: &GridVolume, ranges: [Range<usize>; 3]) -> Result<GridVolume, FieldError> {
    for ((range, n), axis) in ranges.iter().zip(grid.dims()).zip(["x", "y", "z"]) {
        if range.end > n || range.len() < 2 {
            let found = format!("{}:{} along {axis}", range.start, range.end);
            let allowed = format!("must be within 0:{n} and hold at least two voxels; the end is not part of it");
            return Err(FieldError::new("crop", found, allowed));
        }
    }
    part(grid, ranges, [false; 3])
}

/// Returns the voxels in reverse order along an axis (0 is x), each where it was in the world: the direction of the axis is reversed, and
/// the origin moves to its other end, so that pictures stay the same.
///
/// # Errors
/// A placement that cannot be reversed, which none of a scan is.
///
/// # Panics
/// Panics for an axis beyond 2.
pub fn flip_grid(grid: &GridVolume, axis: usize) -> Result<GridVolume, FieldError> {
    let mut reversed = [false; 3];
    reversed[axis] = true;
    part(grid, grid.dims().map(|n| 0..n), reversed)
}

fn part(grid: &GridVolume, ranges: [Range<usize>; 3], reversed: [bool; 3]) -> Result<GridVolume, FieldError> {
    let placement = grid.placement();
    let first = [0, 1, 2].map(|a| if reversed[a] { ranges[a].end - 1 } else { ranges[a].start } as f64);
    let axes = placement.axes();
    // Subtracted, not negated: −0 in a header looks odd.
    let step = |column: DVec3, axis: usize| if reversed[axis] { DVec3::ZERO - column } else { column };
    let axes = DMat3::from_cols(step(axes.x_axis, 0), step(axes.y_axis, 1), step(axes.z_axis, 2));
    let placement = Placement::new(placement.to_world(first.into()), axes)
        .map_err(|e| FieldError::new("placement", "another one", e.to_string()))?;
    let values = with_grid!(grid.values(), g => taken(g, &ranges, reversed, placement))?;
    Ok(GridVolume::new(values, grid.filter()))
}

fn taken<T: Voxel>(
    grid: &UniformGrid<T>,
    ranges: &[Range<usize>; 3],
    reversed: [bool; 3],
    placement: Placement,
) -> Result<AnyGrid, FieldError>
where
    AnyGrid: From<UniformGrid<T>>,
{
    let [nx, ny, _] = grid.dims();
    let order = |axis: usize, i: usize| {
        let Range { start, end } = ranges[axis];
        if reversed[axis] { end - 1 - i } else { start + i }
    };
    let dims = [0, 1, 2].map(|a| ranges[a].len());
    let mut out = Vec::with_capacity(dims.iter().product());
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            let row = (order(2, z) * ny + order(1, y)) * nx;
            let row = &grid.samples()[row + ranges[0].start..row + ranges[0].end];
            if reversed[0] { out.extend(row.iter().rev()) } else { out.extend_from_slice(row) }
        }
    }
    UniformGrid::new(dims, out, placement, grid.calibration())
        .map(AnyGrid::from)
        .map_err(|e| FieldError::new("grid", "another one", e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{in_world, numbered, samples};
    use super::*;

    #[test]
    fn a_part_stays_where_it_was() {
        let grid = numbered();
        let part = crop_grid(&grid, [1..4, 2..4, 0..2]).unwrap();
        assert_eq!((part.dims(), part.calibration()), ([3, 2, 2], grid.calibration()));
        assert_eq!(samples(&part), [11., 12., 13., 16., 17., 18., 31., 32., 33., 36., 37., 38.]);
        let all = in_world(&grid);
        assert!(in_world(&part).iter().all(|voxel| all.contains(voxel)));
        for wrong in [[0..6, 0..4, 0..3], [0..5, 2..3, 0..3], [0..5, 0..4, 1..1]] {
            let message = crop_grid(&grid, wrong).unwrap_err().to_string();
            assert!(message.contains("must be within 0:"), "{message}");
        }
    }

    #[test]
    fn a_flip_reverses_the_order_and_keeps_the_world() {
        let grid = numbered();
        for axis in 0..3 {
            let flipped = flip_grid(&grid, axis).unwrap();
            assert_eq!(in_world(&flipped), in_world(&grid));
            let first = [4.0, 15.0, 40.0][axis];
            assert_eq!(samples(&flipped)[0], first);
            assert_eq!(samples(&flip_grid(&flipped, axis).unwrap()), samples(&grid));
        }
    }
}
