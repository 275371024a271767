//! Rays that pass through visible cells, block by block and sheet by sheet. A block takes no splat that lies in none but its dark sheets: those in which no ray does.

use std::ops::RangeInclusive;

use fearless_simd::Simd;
use fearless_simd::prelude::*;

use super::painter::{Content, Painter, VisibleCells};
use super::{BLOCKS, Tile};

/// Rays of each block in visible cells, for each sheet of a ring; looked up when they are first asked for.
pub(super) struct Sighted {
    /// One a sheet; empty where visible cells are not known or do not matter.
    slots: Vec<Slot>,
}

/// Blocks of one sheet.
#[derive(Clone)]
struct Slot {
    blocks: SightedBlocks,
    /// Rays in visible cells, a bit each, by block; valid for known blocks.
    rays: [u16; BLOCKS],
}

/// State of blocks in one or more sheets, a bit each.
#[derive(Clone, Copy)]
pub(super) struct SightedBlocks {
    /// Blocks that have been looked up.
    known: u64,
    /// Blocks that have been looked up and have no ray in a visible cell.
    pub(super) dark: u64,
}

impl Sighted {
    const NONE: Slot = Slot { blocks: SightedBlocks { known: 0, dark: 0 }, rays: [0; BLOCKS] };

    pub(super) fn new(painter: &Painter<'_>, slots: usize) -> Self {
        Self { slots: vec![Self::NONE; if sighted_cells(painter).is_some() { slots } else { 0 }] }
    }

    /// Blocks that are known in all of the sheets, and blocks that are dark in all of them.
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

    /// Rays of a block that are in visible cells in a sheet; `None` if that has not been looked up.
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

/// Visible cells, if nothing outside them counts. Operators that pick values count vacuum, too.
fn sighted_cells<'a>(painter: &Painter<'a>) -> Option<VisibleCells<'a>> {
    match painter.content {
        Content::Values { cells, .. } if !painter.operator.picks() => cells,
        _ => None,
    }
}

impl Tile<'_> {
    /// True if a block takes a splat: it takes more, and is not dark in all sheets of the splat. Its rays are set up then.
    #[inline(always)]
    pub(super) fn takes_in_sight<S: Simd>(
        &mut self,
        simd: S,
        number: usize,
        blocks: SightedBlocks,
        sheets: [u32; 2],
    ) -> bool {
        if !self.takes_more(number) {
            return false;
        }
        let is_dark = if blocks.known >> number & 1 == 1 {
            blocks.dark >> number & 1 == 1
        } else {
            self.look_up(simd, number, sheets)
        };
        self.work.met += u64::from(!is_dark);
        !is_dark
    }

    /// Looks up the rays of a block in the sheets, and returns true if it is dark in all of them. Not inlined: it runs once for each block and sheet.
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
