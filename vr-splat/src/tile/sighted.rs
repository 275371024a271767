//! Rays of blocks that are in cells in which something can be seen, sheet by sheet: what a splat adds to sheets where none is need not be found.

use std::ops::RangeInclusive;

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::painter::{Content, Painter, VisibleCells};
use super::{BLOCKS, Tile};

/// The rays of each block in each sheet of a ring, once they have been looked up.
pub(super) struct Sighted {
    /// Slot by slot; none where there are no cells to look at.
    slots: Vec<Slot>,
}

/// A sheet.
#[derive(Clone)]
struct Slot {
    blocks: SightedBlocks,
    /// Rays that are in cells in which something can be seen, a bit each, by block.
    rays: [u16; BLOCKS],
}

/// Blocks of one or more sheets, a bit each.
#[derive(Clone, Copy)]
pub(super) struct SightedBlocks {
    /// Looked up.
    known: u64,
    /// Looked up, and no ray is in such a cell.
    pub(super) dark: u64,
}

impl Sighted {
    const NONE: Slot = Slot { blocks: SightedBlocks { known: 0, dark: 0 }, rays: [0; BLOCKS] };

    pub(super) fn new(painter: &Painter<'_>, slots: usize) -> Self {
        Self { slots: vec![Self::NONE; if sighted_cells(painter).is_some() { slots } else { 0 }] }
    }

    /// Blocks that are known, and those that are dark, in all of some sheets.
    #[inline(always)]
    pub(super) fn blocks(&self, sheets: RangeInclusive<u32>) -> SightedBlocks {
        let mut all = SightedBlocks { known: u64::MAX, dark: 0 };
        if self.slots.is_empty() {
            return all;
        }
        all.dark = u64::MAX;
        for sheet in sheets {
            let blocks = self.slots[sheet as usize & (self.slots.len() - 1)].blocks;
            all.known &= blocks.known;
            all.dark &= blocks.dark;
        }
        all
    }

    /// The rays of a block in a sheet, if they have been looked up.
    #[inline(always)]
    pub(super) fn rays(&self, sheet: usize, number: usize) -> Option<u16> {
        let slot = self.slots.get(sheet & self.slots.len().wrapping_sub(1))?;
        (slot.blocks.known >> number & 1 == 1).then(|| slot.rays[number])
    }

    /// Forgets a sheet.
    #[inline(always)]
    pub(super) fn clear(&mut self, slot: usize) {
        if let Some(slot) = self.slots.get_mut(slot) {
            slot.blocks = Self::NONE.blocks;
        }
    }
}

/// Cells in which something can be seen, where sheets in others leave nothing: operators that pick values are told of vacuum, too.
fn sighted_cells<'a>(painter: &Painter<'a>) -> Option<VisibleCells<'a>> {
    match painter.content {
        Content::Values { cells, .. } if !painter.operator.picks() => cells,
        _ => None,
    }
}

impl Tile<'_> {
    /// The number of a block that takes more, which a splat is added to as it is not dark in all of the splat's sheets; its rays are ready then.
    #[inline(always)]
    pub(super) fn take_in_sight<S: Simd>(
        &mut self,
        simd: S,
        [x, y]: [u32; 2],
        blocks: SightedBlocks,
        sheets: [u32; 2],
    ) -> Option<usize> {
        let number = self.ready(x, y)?;
        let is_dark = if blocks.known >> number & 1 == 1 {
            blocks.dark >> number & 1 == 1
        } else {
            self.look_up(simd, number, sheets)
        };
        if is_dark {
            return None;
        }
        self.work.met += 1;
        Some(number)
    }

    /// Looks up the rays of a block in some sheets, and returns true if it is dark in all of them. A function of its own: it is called once for each sheet.
    #[inline(never)]
    fn look_up<S: Simd>(&mut self, simd: S, number: usize, sheets: [u32; 2]) -> bool {
        simd.vectorize(
            #[inline(always)]
            || self.look_up_here(simd, number, sheets),
        )
    }

    #[inline(always)]
    fn look_up_here<S: Simd>(&mut self, simd: S, number: usize, [first, last]: [u32; 2]) -> bool {
        let Some(cells) = sighted_cells(self.painter) else { return false };
        let mut is_dark = true;
        for sheet in first..=last {
            let at = sheet as usize & (self.sighted.slots.len() - 1);
            let SightedBlocks { known, dark } = self.sighted.slots[at].blocks;
            if known >> number & 1 == 0 {
                let [start, end] = self.faces(simd, number, sheet);
                let there = start.simd_lt(end).to_bitmask() as u16;
                let rays = if there == 0 {
                    0
                } else {
                    there & self.in_visible_cells(simd, number, (start + end) * 0.5, &cells)
                };
                let slot = &mut self.sighted.slots[at];
                slot.rays[number] = rays;
                slot.blocks.known |= 1 << number;
                slot.blocks.dark |= u64::from(rays == 0) << number;
                is_dark &= rays == 0;
            } else {
                is_dark &= dark >> number & 1 == 1;
            }
        }
        is_dark
    }
}
