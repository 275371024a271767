//! An octree of ranges over the blocks.

use vr_core::{IndexRay, RangeBlocks, Real};

use super::beam::{Region, Regions, next_interval};
use super::visible_blocks::BlockGrid;
use super::{Leaper, Visibility};

/// A min/max octree over blocks (Wilhelms & Van Gelder 1992, "Octrees for faster isosurface generation"; Levoy 1990, "Efficient ray
/// tracing of volume data", for a binary one).
///
/// A node of level l is the union of the blocks whose indices agree but for their lowest l bits. Ranges of nodes are made once. When the
/// transfer function changes, nodes are marked from the root down: below one whose range is clear, nothing is looked at.
/// A ray descends from the root to the largest node, all of one kind, that holds it, each time it enters one.
#[derive(Clone, Debug)]
pub(crate) struct Octree {
    grid: BlockGrid,
    /// From the blocks (level 0) to the root.
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    nodes: [usize; 3],
    /// Of the nodes above level 0; those of blocks are the volume's.
    ranges: Vec<[f32; 2]>,
    kinds: Vec<Kind>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Clear,
    Visible,
    Mixed,
}

impl Octree {
    /// Over the blocks of a volume with the given samples along x, y, z.
    pub(crate) fn new<R: Real>(dims: [usize; 3], blocks: &RangeBlocks, visibility: &Visibility<R>) -> Self {
        let grid = BlockGrid::new(dims, blocks.edge());
        let kinds = |n: [usize; 3]| vec![Kind::Clear; n.iter().product()];
        let mut levels = vec![Level { nodes: grid.blocks, ranges: Vec::new(), kinds: kinds(grid.blocks) }];
        let mut below: Vec<[f32; 2]> = blocks.ranges().iter().map(|r| [r.low, r.high]).collect();
        let mut from = grid.blocks;
        while from != [1; 3] {
            let nodes = from.map(|n| n.div_ceil(2));
            let ranges = joined(&below, from, nodes);
            below.clone_from(&ranges);
            levels.push(Level { nodes, ranges, kinds: kinds(nodes) });
            from = nodes;
        }
        let mut made = Self { grid, levels };
        made.update(blocks, visibility);
        made
    }

    /// Marks the nodes anew.
    pub(crate) fn update<R: Real>(&mut self, blocks: &RangeBlocks, visibility: &Visibility<R>) {
        for level in &mut self.levels {
            level.kinds.fill(Kind::Clear);
        }
        self.mark(self.levels.len() - 1, [0; 3], blocks, visibility);
    }

    fn mark<R: Real>(&mut self, level: usize, node: [usize; 3], blocks: &RangeBlocks, seen: &Visibility<R>) -> Kind {
        let index = index(node, self.levels[level].nodes);
        let kind = if level == 0 {
            if seen.sees(&blocks.ranges()[index]) { Kind::Visible } else { Kind::Clear }
        } else {
            let [low, high] = self.levels[level].ranges[index];
            if !seen.is_visible(low, high) {
                return Kind::Clear;
            }
            let mut all: Option<Kind> = None;
            for child in children(node, self.levels[level - 1].nodes) {
                let kind = self.mark(level - 1, child, blocks, seen);
                all = Some(all.map_or(kind, |all| if all == kind { kind } else { Kind::Mixed }));
            }
            all.unwrap_or(Kind::Clear)
        };
        self.levels[level].kinds[index] = kind;
        kind
    }
}

fn index([x, y, z]: [usize; 3], n: [usize; 3]) -> usize {
    (z * n[1] + y) * n[0] + x
}

/// The up to eight nodes of the level below, which has `n` of them along each axis.
fn children(node: [usize; 3], n: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let all = (0..8).map(move |c| std::array::from_fn(|a| 2 * node[a] + (c >> a & 1)));
    all.filter(move |child: &[usize; 3]| (0..3).all(|a| child[a] < n[a]))
}

/// The ranges of the `to` nodes over the `from` ones of the level below.
fn joined(below: &[[f32; 2]], from: [usize; 3], to: [usize; 3]) -> Vec<[f32; 2]> {
    let mut ranges = vec![[f32::INFINITY, f32::NEG_INFINITY]; to.iter().product()];
    for (row, below) in below.chunks(from[0]).enumerate() {
        let start = index([0, row % from[1] / 2, row / from[1] / 2], to);
        for (x, [low, high]) in below.iter().enumerate() {
            let range = &mut ranges[start + x / 2];
            *range = [range[0].min(*low), range[1].max(*high)];
        }
    }
    ranges
}

impl Regions for Octree {
    #[inline(always)]
    fn is_visible(&self, index: usize) -> bool {
        self.levels[0].kinds[index] == Kind::Visible
    }

    fn around(&self, block: [usize; 3], _: usize) -> Region {
        let uniform = |l: &usize| {
            let level = &self.levels[*l];
            level.kinds[index(block.map(|b| b >> l), level.nodes)] != Kind::Mixed
        };
        let level = (1..self.levels.len()).rev().find(uniform).unwrap_or(0);
        aligned_cube(block, level)
    }
}

/// The node of a level that a block is in.
#[inline(always)]
pub(super) fn aligned_cube(block: [usize; 3], level: usize) -> Region {
    Region::Cube { low: block.map(|b| b >> level << level), high: block.map(|b| ((b >> level) + 1) << level) }
}

impl Leaper for Octree {
    fn next(&self, ray: &IndexRay, from: f64) -> Option<(f64, f64)> {
        next_interval(self.grid, self, ray, from)
    }

    fn bytes(&self) -> usize {
        self.levels.iter().map(|l| size_of_val(&l.ranges[..]) + l.kinds.len()).sum()
    }
}
