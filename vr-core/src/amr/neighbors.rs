//! Blocks beside each block.

use super::block::AmrCentring;
use super::grid::AmrGrid;
use crate::cancel;
use crate::parallel::collect;

/// For each block, the blocks of its level that hold the samples beside it: in 27 places, from those beyond its lowest corner on, x fastest; its own
/// in the middle.
#[derive(Clone, Debug)]
pub(super) struct Neighbors(Vec<[u32; 27]>);

/// Number for samples that no one block holds: some are those of another one, or there are none.
const SEVERAL: u32 = u32::MAX;

impl Neighbors {
    pub(super) fn new(grid: &AmrGrid) -> Self {
        // As far as central differences at the samples around a place beside the block reach.
        let depth = if grid.centring == AmrCentring::Cells { 2 } else { 1 };
        let beside = |number: usize| {
            let block = &grid.blocks[number];
            let end = block.end();
            let range = |a: usize, side: usize| match side {
                0 => [block.first[a] - depth, block.first[a] - 1],
                1 => [block.first[a], end[a] - 1],
                _ => [end[a], end[a] + depth - 1],
            };
            std::array::from_fn(|place| {
                if place == 13 {
                    return number as u32;
                }
                let ranges = [range(0, place % 3), range(1, place / 3 % 3), range(2, place / 9)];
                let [from, to] = [0, 1].map(|i| ranges.map(|r| r[i]));
                let near = grid.levels[block.level].index.around(from);
                near.iter().copied().find(|&n| grid.blocks[n as usize].holds(from, to)).unwrap_or(SEVERAL)
            })
        };
        cancel::claim("the neighbours of blocks", (grid.blocks.len() * size_of::<[u32; 27]>()) as u64);
        Self(collect(grid.blocks.len(), beside))
    }

    /// Block that holds all samples on one side of a block; `None` if no single one does.
    #[inline]
    pub(super) fn of(&self, number: usize, place: usize) -> Option<usize> {
        let found = self.0[number][place];
        (found != SEVERAL).then_some(found as usize)
    }
}
