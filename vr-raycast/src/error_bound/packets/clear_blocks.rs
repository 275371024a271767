//! Blocks in which nothing can be seen, and how much the field varies in the others.

use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{Cells, LANES, Lanes};

use super::super::blocks::{Blocks, EDGE, State};
use crate::leap::chessboard_distances;
use crate::packet::leap::block_index;

/// Blocks of a volume under a transfer function, as packets read them.
#[derive(Clone, Debug)]
pub(super) struct ClearBlocks {
    blocks: [usize; 3],
    /// Chessboard distance of each block, in blocks, to the nearest one in which something can be seen.
    distance: Vec<u8>,
    /// Difference of the largest and the smallest value in each block.
    span: Vec<f32>,
}

impl ClearBlocks {
    pub(super) const SHIFT: u32 = EDGE.trailing_zeros();

    pub(super) fn new(blocks: &Blocks) -> Self {
        let counts = blocks.counts();
        let all = 0..counts.iter().product();
        let mut distance: Vec<u8> =
            all.clone().map(|i| if blocks.state(i) == State::Clear { u8::MAX } else { 0 }).collect();
        chessboard_distances(counts, &mut distance);
        Self { blocks: counts, distance, span: all.map(|i| blocks.span(i)).collect() }
    }

    /// Returns the distances of the blocks of sixteen cells to the nearest visible ones, and what the field varies by in each.
    #[inline(always)]
    pub(super) fn at<S: Simd>(&self, simd: S, cells: &Cells<S>) -> [f32x16<S>; 2] {
        let index = block_index(cells, Self::SHIFT, self.blocks);
        let (mut distance, mut span) = (Lanes::ZERO, Lanes::ZERO);
        for i in 0..LANES {
            let at = index[i] as u32 as usize;
            distance.0[i] = f32::from(self.distance[at]);
            span.0[i] = self.span[at];
        }
        [distance.load(simd), span.load(simd)]
    }
}
