//! Walk of a ray from region to region of leaves.

use glam::DVec3;

use super::bricks::{Bricks, EDGE};
use super::grid::AmrGrid;
use super::level::{divided, plus, times};
use crate::box_tree::LocalLine;
use crate::floor::floor;
use crate::ray::Ray;

/// Part of a ray among leaves of one block, which is not vacuum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmrPart {
    /// World distance along the ray at which it begins.
    pub from: f64,
    /// World distance at which it ends: the very number at which the next part begins, where no vacuum lies between them.
    pub to: f64,
    /// Number of the block.
    pub block: usize,
    /// Number of the brick in the mesh; `None` if the block is crossed as a whole.
    pub brick: Option<usize>,
    /// Two numbers that enclose every value on it.
    pub range: [f32; 2],
}

/// Parts of a ray through an adaptive mesh that are not vacuum, from its begin on, each found when it is asked for.
///
/// The ray goes from region to region: a brick of a block without finer cells, an evenly covered part of a brick, or a cube of elements that are all
/// solid where some of a brick is vacuum. The face by which it leaves a region is known as a whole number, so that the next region is found without doubt, and every
/// step leads further along an axis.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::Ray;
/// use vr_core::amr::{AmrBlock, AmrCentring, AmrGrid};
///
/// let coarse = AmrBlock { level: 0, first: [0; 3], dims: [4; 3], values: vec![1.0; 64] };
/// let fine = AmrBlock { level: 1, first: [2, 0, 0], dims: [4, 8, 8], values: vec![1.0; 256] };
/// let grid = AmrGrid::new(DVec3::ZERO, DVec3::ONE, vec![[2; 3]], vec![coarse, fine], AmrCentring::Cells)?;
/// let ray = Ray { origin: DVec3::new(-1.0, 2.2, 2.2), direction: DVec3::X };
/// let parts: Vec<_> = grid.parts_along(&ray, [0.0, 9.0]).map(|part| (part.from, part.to, part.block)).collect();
/// // Through the coarse block, the fine one, and the coarse one again, without a gap.
/// let [first, fine @ .., last] = &*parts else { panic!() };
/// assert_eq!((*first, *last), ((1.5, 2.0, 0), (4.0, 4.5, 0)));
/// assert!(fine.iter().all(|part| part.2 == 1));
/// assert!(parts.windows(2).all(|two| two[0].1 == two[1].0));
/// # Ok::<(), vr_core::amr::AmrError>(())
/// ```
#[derive(Clone, Debug)]
pub struct AmrTraversal<'a> {
    grid: &'a AmrGrid,
    bricks: &'a Bricks,
    /// World distance from the ray's own origin to the base.
    offset: f64,
    /// Place at distance 0, near the mesh, so that distances are small numbers.
    base: DVec3,
    direction: DVec3,
    per_unit: DVec3,
    /// Distance that the walk has reached, and that of its end.
    at: f64,
    end: f64,
    /// Element of the finest lattice that it has reached.
    node: [i64; 3],
    /// Level of the region before: the next is of the same one as a rule.
    level: usize,
    /// Distance at which the mesh was left last.
    left: f64,
    /// Blocks that are crossed as a whole, if they can be, with the ranges of their values.
    whole: Option<&'a [Option<[f32; 2]>]>,
    /// Such a block that is known to come next.
    next: Option<usize>,
}

/// Leaves of a block that are crossed at once.
struct Region {
    block: usize,
    /// Number of the brick; `None` if it is all of the block.
    brick: Option<usize>,
    /// Lattice nodes of its level at the lowest and the highest corner.
    nodes: [[i64; 3]; 2],
    range: [f32; 2],
    /// True if there is no field in it.
    is_vacuum: bool,
}

impl AmrGrid {
    /// The parts of a ray between two world distances that are not vacuum.
    pub fn parts_along(&self, ray: &Ray, part: [f64; 2]) -> AmrTraversal<'_> {
        let (low, high) = self.bounds();
        let offset = (0.5 * low + 0.5 * high - ray.origin).dot(ray.direction);
        let (base, direction) = (ray.origin + ray.direction * offset, ray.direction);
        let [at, end] = inside(base, direction, [low, high], part.map(|s| s - offset)).unwrap_or([0.0; 2]);
        AmrTraversal {
            grid: self,
            bricks: self.bricks(),
            offset,
            base,
            direction,
            per_unit: direction.recip(),
            at,
            end,
            node: self.finest_node(base + direction * at),
            level: self.levels.len() - 1,
            left: f64::NEG_INFINITY,
            whole: None,
            next: None,
        }
    }

    /// Numbers of the bricks of a block, and of each the range of its values; parts of rays are parts of these as a rule. Empty where finer cells cover it.
    pub fn brick_ranges(&self, block: usize) -> impl Iterator<Item = (usize, [f32; 2])> {
        let bricks = self.bricks();
        bricks.of_block(block).map(|number| (number, bricks.get(number).range))
    }

    /// Number of bricks of all blocks.
    pub fn brick_count(&self) -> usize {
        self.blocks.len().checked_sub(1).map_or(0, |last| self.bricks().of_block(last).end)
    }
}

impl<'a> AmrTraversal<'a> {
    /// Crosses blocks that have a range at once, where all of their cells are leaves and none is vacuum: one entry for each block.
    #[must_use]
    pub fn by_blocks(self, whole: &'a [Option<[f32; 2]>]) -> Self {
        Self { whole: Some(whole), ..self }
    }
}

impl AmrTraversal<'_> {
    /// The region that the walk has come to; `None` where there are no cells.
    fn region(&mut self) -> Option<Region> {
        let grid = self.grid;
        let elements = grid.centring.elements();
        let holder = |level: usize| {
            let node = divided(self.node, grid.levels[level].to_finest);
            let cell = divided(node, [elements; 3]);
            grid.holder_of_cell(level, cell).map(|block| (level, block, node, cell))
        };
        let brick = |block: usize, cell: [i64; 3]| {
            let first = grid.blocks[block].first;
            let number = self.bricks.number_at(grid, block, std::array::from_fn(|a| (cell[a] - first[a]) / EDGE));
            (number, self.bricks.get(number))
        };
        // The finest level that has the cell; no other needs to be asked where nothing finer is near.
        let (level, block, node, cell) = match holder(self.level) {
            Some(own @ (_, block, _, cell)) if brick(block, cell).1.has_finer => {
                (self.level + 1..grid.levels.len()).rev().find_map(holder).unwrap_or(own)
            }
            Some(own) => own,
            None => (0..self.level).rev().find_map(holder)?,
        };
        if let Some(region) = self.whole_region(block) {
            self.level = level;
            return Some(region);
        }
        let (place, found) = brick(block, cell);
        let (found, number) = (*found, Some(place));
        self.level = level;
        let held = &grid.blocks[block];
        let (first, end) = (held.first, plus(held.first, held.cells(grid.centring).map(|n| n as i64)));
        if let Some(solid) = self.bricks.solid_elements(place) {
            let from = std::array::from_fn(|a| (first[a] + (cell[a] - first[a]) / EDGE * EDGE) * elements);
            let cube = solid.cube_at(plus(node, from.map(|i| -i)));
            // Vacuum and finer cells are told apart element by element.
            let is_single = !cube.is_solid && found.has_finer;
            let low = if is_single { node } else { plus(from, cube.first) };
            let edge = if is_single { 1 } else { cube.edge };
            let high = std::array::from_fn(|a| (low[a] + edge).min(end[a] * elements));
            return Some(Region {
                block,
                brick: number,
                nodes: [low, high],
                range: found.range,
                is_vacuum: !cube.is_solid,
            });
        }
        let grain = i64::from(found.grain);
        let from: [i64; 3] = std::array::from_fn(|a| first[a] + (cell[a] - first[a]) / grain * grain);
        let to = std::array::from_fn(|a| (from[a] + grain).min(end[a]));
        let nodes = [from, to].map(|cell| times(cell, [elements; 3]));
        Some(Region { block, brick: number, nodes, range: found.range, is_vacuum: false })
    }

    /// All of a block, if it is to be crossed at once and can be.
    #[inline]
    fn whole_region(&self, block: usize) -> Option<Region> {
        let range = (*self.whole?.get(block)?)?;
        let nodes = self.grid.nodes_of_block(block);
        self.bricks.is_solid(block).then_some(Region { block, brick: None, nodes, range, is_vacuum: false })
    }

    /// Goes on to the face by which the ray leaves a region.
    fn leave(&mut self, region: &Region) {
        let level = &self.grid.levels[self.level];
        let [low, high] = region.nodes;
        let (mut nearest, mut axis) = (f64::INFINITY, 0);
        for a in (0..3).filter(|&a| self.direction[a] != 0.0) {
            let node = if self.direction[a] > 0.0 { high[a] } else { low[a] };
            let distance = (self.grid.origin[a] + node as f64 * level.edge[a] - self.base[a]) * self.per_unit[a];
            if distance < nearest {
                (nearest, axis) = (distance, a);
            }
        }
        self.at = if nearest < self.end { nearest.max(self.at) } else { self.end };
        if region.brick.is_none() {
            let face = 2 * axis + usize::from(self.direction[axis] > 0.0);
            self.next =
                self.bricks.beside(region.block, face).filter(|&next| self.whole.is_some_and(|w| w[next].is_some()));
            if self.next.is_some() {
                return;
            }
        }
        // Along the other axes it is where it was, whatever rounding says.
        let finest = self.grid.levels[self.grid.levels.len() - 1].rate;
        let place = (self.base + self.direction * self.at - self.grid.origin) * finest;
        for a in 0..3 {
            let (first, end) = (low[a] * level.to_finest[a], high[a] * level.to_finest[a]);
            self.node[a] = match () {
                () if a != axis => floor(place[a]).clamp(first, end - 1),
                () if self.direction[a] > 0.0 => end,
                () => first - 1,
            };
        }
    }

    /// Goes on to the next block that the ray meets, from where there is none.
    fn leap(&mut self) {
        let sliver = 1e-9 * self.grid.finest_spacing().min_element();
        // What has been left by rounding is not met again.
        let reached = self.at.max(self.left + sliver);
        let line = LocalLine {
            origin: self.base - self.grid.tree().middle(),
            direction: self.direction,
            ends: [reached, self.end],
        };
        let mut nearest: Option<(f64, usize)> = None;
        self.grid.tree().each_along(&line, |number| {
            let [low, high] =
                self.grid.nodes_of_block(number).map(|n| self.grid.position(self.grid.blocks[number].level, n));
            if let Some([from, to]) = inside(self.base, self.direction, [low, high], [reached, self.end])
                && to > reached + sliver
                && nearest.is_none_or(|(distance, _)| from < distance)
            {
                nearest = Some((from, number));
            }
        });
        (self.left, self.at) = (reached, self.end);
        if let Some((from, number)) = nearest {
            self.at = from;
            let to_finest = self.grid.levels[self.grid.blocks[number].level].to_finest;
            let [low, high] = self.grid.nodes_of_block(number).map(|node| times(node, to_finest));
            let node = self.grid.finest_node(self.base + self.direction * from);
            self.node = std::array::from_fn(|a| node[a].clamp(low[a], high[a] - 1));
        }
    }
}

impl Iterator for AmrTraversal<'_> {
    type Item = AmrPart;

    fn next(&mut self) -> Option<AmrPart> {
        while self.at < self.end {
            let known = self.next.take().and_then(|block| self.whole_region(block));
            let Some(region) = known.or_else(|| self.region()) else {
                self.leap();
                continue;
            };
            let from = self.at;
            self.leave(&region);
            let [from, to] = [from, self.at].map(|s| s + self.offset);
            if from < to && !region.is_vacuum {
                return Some(AmrPart { from, to, block: region.block, brick: region.brick, range: region.range });
            }
        }
        None
    }
}

/// Part of a line between two distances that is inside a box; `None` if nothing of positive length is.
fn inside(base: DVec3, direction: DVec3, [low, high]: [DVec3; 2], [mut from, mut to]: [f64; 2]) -> Option<[f64; 2]> {
    for a in 0..3 {
        let [near, far] = [low[a] - base[a], high[a] - base[a]];
        if direction[a] != 0.0 {
            let [s, t] = [near / direction[a], far / direction[a]];
            (from, to) = (from.max(s.min(t)), to.min(s.max(t)));
        } else if near > 0.0 || far < 0.0 {
            return None;
        }
    }
    (from < to).then_some([from, to])
}
