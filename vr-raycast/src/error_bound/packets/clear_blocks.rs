//! Blocks in which nothing can be seen, and how far rays may go before they look for them again.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use vr_kernels::vector::{Cells, LANES};

use super::super::blocks::{Blocks, EDGE, State};
use crate::leap::chessboard_distances;
use crate::packet::leap::block_index;

/// Blocks of a volume under a transfer function, as packets read them.
#[derive(Clone, Debug)]
pub(super) struct ClearBlocks {
    blocks: [usize; 3],
    /// Chessboard distance of each clear block, in blocks, to the nearest one in which something can be seen; of each of these, below 0, that to the nearest clear one.
    distance: Vec<i8>,
}

impl ClearBlocks {
    pub(super) const SHIFT: u32 = EDGE.trailing_zeros();

    pub(super) fn new(blocks: &Blocks) -> Self {
        let counts = blocks.counts();
        let all = 0..counts.iter().product();
        let distances = |from: bool| {
            let is_source = |i: usize| (blocks.state(i) == State::Clear) == from;
            let mut distance: Vec<u8> = all.clone().map(|i| if is_source(i) { 0 } else { u8::MAX }).collect();
            chessboard_distances(counts, &mut distance);
            distance.into_iter().map(|d| d.min(i8::MAX as u8) as i8)
        };
        let distance = distances(false).zip(distances(true)).map(|(to_visible, to_clear)| to_visible - to_clear);
        Self { blocks: counts, distance: distance.collect() }
    }

    /// Returns, for the blocks of sixteen cells, the distances of clear ones to the nearest visible ones, and below 0 those of visible ones to the nearest clear ones.
    #[inline(always)]
    pub(super) fn at<S: Simd>(&self, simd: S, cells: &Cells<S>) -> f32x16<S> {
        let index = block_index(cells, Self::SHIFT, self.blocks);
        let mut distance = [0; LANES];
        for i in 0..LANES {
            distance[i] = i32::from(self.distance[index[i] as u32 as usize]);
        }
        i32x16::load_array(simd, distance).to_float()
    }
}
