//! Empty-space leaping: the parts of a ray in which something can be visible.
//!
//! The field's range is known per block of cells ([`vr_kernels::ranges::RangeBlocks`], made once). When the transfer function changes,
//! [`Visibility`] says of each block whether anything in it can be visible ([`VisibleBlocks`]), and from those one structure is
//! made that rays are sent through:
//!
//! | structure | per block | a ray goes on by | source |
//! |---|---|---|---|
//! | [`ExactCloud`] | 2 bytes | the ball up to the nearest block of the other kind | Cohen & Sheffer 1994 |
//!
//! It cuts a ray exactly at the faces of visible blocks. "The other kind" is clear or visible: what is visible throughout is crossed as
//! fast as what is clear throughout, and so it costs next to nothing in a fog that it cannot help. The structures that it beat are in
//! `classics`.
//!
//! Packets find their way by [`ClearSpace`]: the same distances, and a bit for each cell of blocks that are visible in part.
//!
//! # Guarantee
//! Kernels round positions: a sample that lies in a clear block may be taken on the other side of its face. So a ray is a beam, a
//! little thicker than that rounding ([`reach`]), and all of the ray where the beam touches a visible block lies in an interval. A ray that
//! lies in a face touches the blocks on both sides, one that runs through a corner all eight.

mod beam;
mod chessboard;
mod clear_space;
mod empty_space;
mod exact_cloud;
mod visible_blocks;

pub(crate) use beam::{Region, Regions, next_interval};
pub(crate) use chessboard::chessboard_distances;
pub(crate) use clear_space::ClearSpace;
pub(crate) use empty_space::{empty_space, visibility};
pub(crate) use exact_cloud::ExactCloud;
pub(crate) use visible_blocks::{BlockGrid, VisibleBlocks};

use std::any::Any;

use vr_core::IndexRay;
pub(crate) use vr_kernels::ranges::Visibility;

/// Cells along the edge of a block. Ranges of blocks of 8³ take 12 bytes per 512 voxels; of 4³, they would take more than an 8-bit volume may
/// grow by, and rays would ask more often.
pub(crate) const EDGE: usize = 8;

/// Structure that finds the intervals of a ray in which something can be visible.
pub(crate) trait Leaper: Any + Send + Sync {
    /// Returns the first interval of the ray, in world distances like the ray's own, that ends behind `from` and may hold something visible; cut
    /// off at `from` and at the ray's end. `None` if all the rest is clear.
    ///
    /// Asked again from the end of the last answer on, it gives disjoint intervals in order, and all that is visible lies in
    /// them, ends included.
    fn next(&self, ray: &IndexRay, from: f64) -> Option<(f64, f64)>;

    /// Returns the memory of the structure in bytes, without the ranges of the blocks.
    #[cfg(test)]
    fn bytes(&self) -> usize;
}

/// Returns half the width of the beam that stands for a ray, in cells: the largest distance, per axis, of a kernel's sample from the ray.
///
/// Positions found as x₀ + j·δ in f32 suffer three roundings of numbers up to the largest index, a relative 2⁻²⁴ each: at most 2⁻²² of that
/// index. The result is twice that, so that roundings of the leapers themselves, in f64, are covered many times over.
pub(crate) fn reach(dims: [usize; 3]) -> f64 {
    const PER_INDEX: f64 = 1.0 / (1u64 << 21) as f64;
    dims.into_iter().max().unwrap_or_default() as f64 * PER_INDEX
}
