//! Proximity clouds in the chessboard metric.

use vr_core::IndexRay;

use crate::leap::BlockGrid;
use crate::leap::{Leaper, VisibleBlocks, chessboard_distances};
use crate::leap::{Region, Regions, next_interval};

/// Proximity cloud: each block stores the distance of the nearest block of the other kind, as a king moves, max(|Δx|, |Δy|, |Δz|). All in the cube around it up
/// to there is of its own kind (Cohen & Sheffer 1994, "Proximity clouds: an acceleration technique for 3D grid traversal"; there
/// the distance is from empty to filled voxels).
#[derive(Clone, Debug)]
pub(crate) struct ChessboardCloud {
    grid: BlockGrid,
    /// Distance of each block, and [`VISIBLE`] where it can be seen.
    distances: Vec<u8>,
}

/// Bit that is set for a block that can be seen.
const VISIBLE: u8 = 0x80;
/// Largest distance that can be stored: larger ones are stored as this, for one that is too short does no harm.
const FAR: u8 = 0x7f;

impl ChessboardCloud {
    /// Computes the distances between visible and clear blocks.
    pub(crate) fn new(blocks: &VisibleBlocks) -> Self {
        let grid = blocks.grid();
        let to = |kind: &VisibleBlocks| {
            let mut distances = vec![u8::MAX; grid.len()];
            kind.for_each_beyond(&VisibleBlocks::clear(grid), |i| distances[i] = 0);
            chessboard_distances(grid.blocks, &mut distances);
            distances
        };
        let (to_visible, to_clear) = vr_core::parallel::join(|| to(blocks), || to(&blocks.inverted()));
        let stored =
            |(visible, clear): (u8, u8)| if visible == 0 { VISIBLE | clear.min(FAR) } else { visible.min(FAR) };
        let distances = to_visible.into_iter().zip(to_clear).map(stored).collect();
        Self { grid, distances }
    }

    /// Returns the distance of a block from the nearest visible one, in blocks as a king moves; 0 if it is visible itself. At most 127.
    #[cfg(test)]
    pub(crate) fn distance(&self, block: [usize; 3]) -> u8 {
        let stored = self.distances[self.grid.index(block)];
        if stored & VISIBLE == 0 { stored } else { 0 }
    }
}

impl Regions for ChessboardCloud {
    #[inline(always)]
    fn is_visible(&self, index: usize) -> bool {
        self.distances[index] & VISIBLE != 0
    }

    #[inline(always)]
    fn around(&self, block: [usize; 3], index: usize) -> Region {
        let distance = usize::from(self.distances[index] & FAR);
        Region::Cube { low: block.map(|b| (b + 1).saturating_sub(distance)), high: block.map(|b| b + distance) }
    }
}

impl Leaper for ChessboardCloud {
    fn next(&self, ray: &IndexRay, from: f64) -> Option<(f64, f64)> {
        next_interval(self.grid, self, ray, from)
    }

    #[cfg(test)]
    fn bytes(&self) -> usize {
        self.distances.len()
    }
}
