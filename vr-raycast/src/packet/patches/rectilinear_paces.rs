//! Paces of rays in the bricks of a rectilinear grid, found once for a scene.

use vr_core::rectilinear::RectilinearGrid;
use vr_kernels::ranges::BlockRange;

use crate::pace::{Lengths, Pace};

/// Paces in the bricks of a rectilinear grid.
#[derive(Clone, Debug)]
pub(crate) struct RectilinearPaces {
    lengths: Lengths,
    /// Values between which those of each brick lie, and true if something can be seen.
    bricks: Vec<([f32; 2], bool)>,
}

impl RectilinearPaces {
    /// Finds the paces; the visibility must be that of stored numbers.
    pub(crate) fn new(grid: &RectilinearGrid, pace: &Pace<f32>) -> Self {
        let (bricks, calibration) = (grid.bricks(), grid.lattice().calibration());
        let of = |brick: usize| {
            let (Some(range), Some(stored)) = (bricks.range(brick, calibration), bricks.stored_range(brick)) else {
                return ([0.0; 2], false);
            };
            let block = BlockRange::of_trilinear(stored);
            (range, pace.visibility.as_ref().is_none_or(|visibility| visibility.shows_block(&block)))
        };
        Self { lengths: pace.lengths.clone(), bricks: (0..bricks.len()).map(of).collect() }
    }

    /// Returns the length of a step in a brick, and true if something can be seen.
    #[inline]
    pub(super) fn of(&self, brick: usize, spacing: f64) -> (f64, bool) {
        let (range, is_seen) = self.bricks[brick];
        (self.lengths.of(range, spacing), is_seen)
    }
}
