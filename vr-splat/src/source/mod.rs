//! Sources of splats: the voxels of a grid, or points.

mod grid;
mod points;

pub(crate) use grid::{GridSplats, Spread};
pub(crate) use points::PointSplats;

use crate::splat::Splat;

/// Splats, in chunks that can be made independently.
pub(crate) trait Source: Sync {
    /// Number of chunks.
    fn chunks(&self) -> usize;

    /// Largest possible number of splats altogether.
    fn count(&self) -> u64;

    /// Makes the splats of a chunk, in an order that is always the same. A splat comes with the sheet that it belongs to, for a source that has sheets of
    /// its own.
    fn splats(&self, chunk: usize, emit: &mut dyn FnMut(Splat, u32));
}
