//! The run-length encoded volume of one principal axis, and its fast classification (Lacroute & Levoy 1994; Lacroute 1995, *Fast volume
//! rendering using a shear-warp factorization of the viewing transformation*, thesis).
//!
//! Seen along the axis w of (u, v, w), the samples of one w are a *layer*; in it lie voxel rows v of columns u. A *cell* (u, v) is the
//! square between columns u, u + 1 and rows v, v + 1. Of the volume we see bilinear samples in a layer (4 corners, `N = 2` edges
//! along u) or trilinear ones between layers k and k + 1 (8 corners, `N = 4` edges).
//!
//! 1. [`Pyramid`]: ranges of blocks of 4³ cells and of ever larger ones; made once a volume.
//! 2. [`VisibleLevels`]: which ranges may be visible; made anew for each transfer function.
//! 3. [`Pyramid::visible`]: the blocks that may be visible.
//! 4. Either [`packed()`]: tight runs and a copy of the voxels that they touch; or [`block_runs`]: runs of whole blocks that point into
//!    the volume itself, for which no voxel is looked at.

mod blocks;
mod dense;
mod masks;
mod packed;
mod pyramid;
mod runs;
#[cfg(test)]
mod tests;

pub(crate) use vr_kernels::ranges::{Leveled, VisibleLevels};
pub(crate) use {
    blocks::block_runs,
    dense::{Dense, Layout},
    packed::packed,
    pyramid::{Pyramid, VisibleBlocks},
    runs::{Run, Runs},
};

/// Elements behind the last voxel, so that vector code may read past the end.
pub(crate) const PAD: usize = 32;

/// Cells that may be visible. Whatever the rule, one with a missing corner is not: it is vacuum.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Rule<'a> {
    /// Samples are interpolated, then classified: a cell with anything visible between its smallest and its largest corner.
    Interpolated(&'a VisibleLevels),
    /// Voxels are classified, then interpolated: a cell with a corner that is visible itself.
    Classified(&'a VisibleLevels),
    /// Every cell: for the operators that no opacity hides from.
    Everything,
}
