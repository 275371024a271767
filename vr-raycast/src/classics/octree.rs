//! An octree of ranges over the blocks.

use std::sync::Arc;

use vr_core::{IndexRay, Real};
use vr_kernels::ranges::RangeBlocks;

use crate::leap::BlockGrid;
use crate::leap::{Leaper, Visibility};
use crate::leap::{Region, Regions, next_interval};

/// A min/max octree over blocks (Wilhelms & Van Gelder 1992, "Octrees for faster isosurface generation"; Levoy 1990, "Efficient ray
/// tracing of volume data", for one of empty and filled nodes).
///
/// A node of level l is the union of the blocks whose indices agree but for their lowest l bits. Ranges of nodes are made once. When the
/// transfer function changes, nodes are marked from the root down: below one whose range is clear, nothing is looked at.
/// A ray descends from the root to the largest node, all of one kind, that holds it, each time it enters one.
#[derive(Clone, Debug)]
pub(crate) struct Octree {
    nodes: Arc<NodeRanges>,
    /// Kinds of the blocks (level 0) and of the nodes above them, up to the root.
    kinds: Vec<Vec<Kind>>,
}

/// The ranges of an octree's nodes.
#[derive(Clone, Debug)]
pub(crate) struct NodeRanges {
    grid: BlockGrid,
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    /// Nodes along x, y, z.
    nodes: [usize; 3],
    /// Smallest and largest value in each node above the blocks, whose ranges the volume keeps.
    ranges: Vec<[f32; 2]>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Clear,
    Visible,
    Mixed,
}

impl NodeRanges {
    /// Computes the ranges of the nodes over the blocks of a volume with the given voxels along x, y, z.
    pub(crate) fn new(dims: [usize; 3], blocks: &RangeBlocks) -> Self {
        let grid = BlockGrid::new(dims, blocks.edge());
        let mut below: Vec<[f32; 2]> = blocks.ranges().iter().map(|r| [r.low, r.high]).collect();
        let mut levels = vec![Level { nodes: grid.blocks, ranges: Vec::new() }];
        let mut from = grid.blocks;
        while from != [1; 3] {
            let nodes = from.map(|n| n.div_ceil(2));
            let ranges = joined(&below, from, nodes);
            below.clone_from(&ranges);
            levels.push(Level { nodes, ranges });
            from = nodes;
        }
        Self { grid, levels }
    }
}

impl Octree {
    /// Makes the octree over the blocks that the ranges were made of.
    pub(crate) fn new<R: Real>(nodes: Arc<NodeRanges>, blocks: &RangeBlocks, visibility: &Visibility<R>) -> Self {
        let mut kinds: Vec<_> =
            nodes.levels.iter().map(|level| vec![Kind::Clear; level.nodes.iter().product()]).collect();
        let root = nodes.levels.len() - 1;
        mark(&nodes, &mut kinds, root, [0; 3], blocks, visibility);
        Self { nodes, kinds }
    }

    /// Ranges of the nodes, which outlive a transfer function.
    pub(crate) fn nodes(&self) -> Arc<NodeRanges> {
        Arc::clone(&self.nodes)
    }
}

/// Marks a node and those below it; all are marked clear before.
fn mark<R: Real>(
    nodes: &NodeRanges,
    kinds: &mut [Vec<Kind>],
    level: usize,
    node: [usize; 3],
    blocks: &RangeBlocks,
    visibility: &Visibility<R>,
) -> Kind {
    let index = index(node, nodes.levels[level].nodes);
    let kind = if level == 0 {
        if visibility.shows_block(&blocks.ranges()[index]) { Kind::Visible } else { Kind::Clear }
    } else {
        let [low, high] = nodes.levels[level].ranges[index];
        if !visibility.shows(low, high) {
            return Kind::Clear;
        }
        let mut all: Option<Kind> = None;
        for child in children(node, nodes.levels[level - 1].nodes) {
            let kind = mark(nodes, kinds, level - 1, child, blocks, visibility);
            all = Some(all.map_or(kind, |all| if all == kind { kind } else { Kind::Mixed }));
        }
        all.unwrap_or(Kind::Clear)
    };
    kinds[level][index] = kind;
    kind
}

fn index([x, y, z]: [usize; 3], n: [usize; 3]) -> usize {
    (z * n[1] + y) * n[0] + x
}

/// Returns the up to eight nodes of the level below, which has `n` of them along each axis.
fn children(node: [usize; 3], n: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let all = (0..8).map(move |c| std::array::from_fn(|a| 2 * node[a] + (c >> a & 1)));
    all.filter(move |child: &[usize; 3]| (0..3).all(|a| child[a] < n[a]))
}

/// Joins the ranges of the `from` nodes of a level to those of the `to` nodes above.
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
        self.kinds[0][index] == Kind::Visible
    }

    fn around(&self, block: [usize; 3], _: usize) -> Region {
        let uniform =
            |&l: &usize| self.kinds[l][index(block.map(|b| b >> l), self.nodes.levels[l].nodes)] != Kind::Mixed;
        let level = (1..self.kinds.len()).rev().find(uniform).unwrap_or(0);
        aligned_cube(block, level)
    }
}

/// Returns the node of a level that a block is in.
#[inline(always)]
pub(super) fn aligned_cube(block: [usize; 3], level: usize) -> Region {
    Region::Cube { low: block.map(|b| b >> level << level), high: block.map(|b| ((b >> level) + 1) << level) }
}

impl Leaper for Octree {
    fn next(&self, ray: &IndexRay, from: f64) -> Option<(f64, f64)> {
        next_interval(self.nodes.grid, self, ray, from)
    }

    #[cfg(test)]
    fn bytes(&self) -> usize {
        let nodes = &self.nodes.levels;
        nodes.iter().map(|l| size_of_val(&l.ranges[..])).sum::<usize>() + self.kinds.iter().map(Vec::len).sum::<usize>()
    }
}
