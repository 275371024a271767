//! A flat pyramid: levels stored in the blocks.

use vr_core::IndexRay;

use super::octree::aligned_cube;
use crate::leap::BlockGrid;
use crate::leap::{Leaper, VisibleBlocks};
use crate::leap::{Region, Regions, next_interval};

/// The octree folded into its leaves: each block stores the level of the largest aligned cube around it that is all of its own kind, so
/// that a ray asks once and descends nowhere (after Yagel & Shi 1993, "Accelerating volume animation by space-leaping").
#[derive(Clone, Debug)]
pub(crate) struct Pyramid {
    grid: BlockGrid,
    /// Level of each block, and [`VISIBLE`] where it can be seen.
    levels: Vec<u8>,
}

/// Bit that is set for a block that can be seen.
const VISIBLE: u8 = 0x80;
/// Mark of a node whose blocks are not all of one kind.
const MIXED: u8 = 0x7f;

impl Pyramid {
    /// Computes the levels of visible and clear blocks.
    pub(crate) fn new(blocks: &VisibleBlocks) -> Self {
        let grid = blocks.grid();
        let mut level = Vec::with_capacity(grid.len());
        for z in 0..grid.blocks[2] {
            for y in 0..grid.blocks[1] {
                let row = blocks.row(y, z);
                level.extend((0..grid.blocks[0]).map(|x| (row[x / 64] >> (x % 64) & 1) as u8 * VISIBLE));
            }
        }
        // Up: whether a node is clear, visible or mixed.
        let mut levels = vec![(grid.blocks, level)];
        while let Some((n, below)) = levels.last()
            && *n != [1; 3]
        {
            let above = above(below, *n);
            levels.push(above);
        }
        // Down: a node inside a larger one of one kind takes that one's level.
        let (mut n, mut larger) = levels.pop().expect("the blocks at least");
        if larger[0] != MIXED {
            larger[0] |= levels.len() as u8;
        }
        while let Some((m, mut nodes)) = levels.pop() {
            let level = levels.len() as u8;
            for (row, nodes) in nodes.chunks_mut(m[0]).enumerate() {
                let start = (row / m[1] / 2 * n[1] + row % m[1] / 2) * n[0];
                for (node, &parent) in nodes.iter_mut().zip(larger[start..].iter().flat_map(|p| [p, p])) {
                    if parent != MIXED {
                        *node = parent;
                    } else if *node != MIXED {
                        *node |= level;
                    }
                }
            }
            (n, larger) = (m, nodes);
        }
        Self { grid, levels: larger }
    }
}

/// Returns the level above `n` nodes.
fn above(below: &[u8], n: [usize; 3]) -> ([usize; 3], Vec<u8>) {
    const NONE: u8 = 0x7e;
    let m = n.map(|n| n.div_ceil(2));
    let mut nodes = vec![NONE; m.iter().product()];
    for (row, below) in below.chunks(n[0]).enumerate() {
        let start = (row / n[1] / 2 * m[1] + row % n[1] / 2) * m[0];
        for (pair, node) in below.chunks(2).zip(&mut nodes[start..]) {
            for &kind in pair {
                *node = if *node == NONE || *node == kind { kind } else { MIXED };
            }
        }
    }
    (m, nodes)
}

impl Regions for Pyramid {
    #[inline(always)]
    fn is_visible(&self, index: usize) -> bool {
        self.levels[index] & VISIBLE != 0
    }

    #[inline(always)]
    fn around(&self, block: [usize; 3], index: usize) -> Region {
        aligned_cube(block, usize::from(self.levels[index] & !VISIBLE))
    }
}

impl Leaper for Pyramid {
    fn next(&self, ray: &IndexRay, from: f64) -> Option<(f64, f64)> {
        next_interval(self.grid, self, ray, from)
    }

    #[cfg(test)]
    fn bytes(&self) -> usize {
        self.levels.len()
    }
}
