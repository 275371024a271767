//! Values at lattice points, and at the corners of elements.

use std::ops::{Add, Mul};

use glam::DVec3;

use super::block::AmrCentring;
use super::element::Element;
use super::grid::AmrGrid;
use super::level::{corner, divided, plus, times};

/// Something that is given at the lattice points of every level, and interpolated between them: NaN where there is none.
pub(super) trait Quantity: Copy + Add<Output = Self> + Mul<f64, Output = Self> {
    const ZERO: Self;
    const NONE: Self;

    fn at_sample(grid: &AmrGrid, level: usize, at: [i64; 3]) -> Self;

    /// Quantity in an element of a level, where there is a faster way to it than by its corners.
    fn within_block(_grid: &AmrGrid, _level: usize, _node: [i64; 3], _part: [f64; 3]) -> Option<Self> {
        None
    }
}

/// The value.
impl Quantity for f64 {
    const ZERO: Self = 0.0;
    const NONE: Self = Self::NAN;

    fn at_sample(grid: &AmrGrid, level: usize, at: [i64; 3]) -> Self {
        grid.sample(level, at)
    }

    fn within_block(grid: &AmrGrid, level: usize, node: [i64; 3], part: [f64; 3]) -> Option<Self> {
        // A sample that is missing may be one that does not count.
        grid.value_within_block(level, node, part).filter(|value| !value.is_nan())
    }
}

/// The gradient in world units.
impl Quantity for DVec3 {
    const ZERO: Self = Self::ZERO;
    const NONE: Self = Self::NAN;

    fn at_sample(grid: &AmrGrid, level: usize, at: [i64; 3]) -> Self {
        grid.gradient_at_sample(level, at)
    }

    fn within_block(grid: &AmrGrid, level: usize, node: [i64; 3], part: [f64; 3]) -> Option<Self> {
        grid.gradient_within_level(Element { level, node }, DVec3::from_array(part))
    }
}

impl AmrGrid {
    /// Block that covers a cell of a level: the first of several.
    #[inline]
    pub(super) fn holder_of_cell(&self, level: usize, cell: [i64; 3]) -> Option<usize> {
        let beyond = self.centring.beyond();
        let last = cell.map(|i| i + beyond);
        let candidates = self.levels[level].index.around(cell);
        candidates.iter().map(|&n| n as usize).find(|&n| self.blocks[n].holds(cell, last))
    }

    /// True if a cell of a level consists of cells of the next one: blocks cover whole cells, so that one of these tells.
    #[inline]
    pub(super) fn is_covered(&self, level: usize, cell: [i64; 3]) -> bool {
        let finer = level + 1;
        finer < self.levels.len() && self.holder_of_cell(finer, times(cell, self.levels[finer].ratio)).is_some()
    }

    /// Value at a lattice point of a level, the middle of a cell or a point; NaN where the level has none.
    #[inline]
    pub(super) fn sample(&self, level: usize, at: [i64; 3]) -> f64 {
        for &number in self.levels[level].index.around(at) {
            let block = &self.blocks[number as usize];
            if let Some(offset) = block.offset(at) {
                return f64::from(block.values[offset]);
            }
        }
        f64::NAN
    }

    /// True if a level has a lattice point, with a value or without.
    pub(super) fn holds_sample(&self, level: usize, at: [i64; 3]) -> bool {
        self.levels[level].index.around(at).iter().any(|&n| self.blocks[n as usize].offset(at).is_some())
    }

    /// Sets the value at a lattice point in all blocks of a level that have it.
    pub(super) fn set_all(&mut self, level: usize, at: [i64; 3], value: f32) {
        for &number in self.levels[level].index.around(at) {
            let block = &mut self.blocks[number as usize];
            if let Some(offset) = block.offset(at) {
                block.values[offset] = value;
            }
        }
    }

    /// Quantity at a node of a level that some leaf of this or a finer level touches, a corner of its elements; NaN in vacuum.
    pub(super) fn at_node<Q: Quantity>(&self, level: usize, node: [i64; 3]) -> Q {
        let elements = self.centring.elements();
        let mut coarsest = level;
        // The cells of the eight elements around the node: some of them are one.
        for i in 0..8 {
            let back = corner(i);
            if (0..3).any(|a| back[a] == 1 && node[a].rem_euclid(elements) != 0) {
                continue;
            }
            let cell = std::array::from_fn(|a| (node[a] - back[a]).div_euclid(elements));
            if self.holder_of_cell(level, cell).is_none() {
                match (self.coarser_leaf(level, cell), self.centring) {
                    (Some((leaf, _)), _) => coarsest = coarsest.min(leaf),
                    (None, AmrCentring::Cells) => return Q::NONE,
                    // Points on the outermost faces have values.
                    (None, AmrCentring::Points) => {}
                }
            }
        }
        if coarsest == level { self.at_own_node(level, node) } else { self.at_coarser(level, node, coarsest) }
    }

    /// Quantity at a node from the samples of its level alone: their mean around it, or the sample in its place.
    fn at_own_node<Q: Quantity>(&self, level: usize, node: [i64; 3]) -> Q {
        match self.centring {
            AmrCentring::Points => Q::at_sample(self, level, node),
            AmrCentring::Cells => {
                let (mut sum, mut count) = (Q::ZERO, 0u32);
                for i in 0..8 {
                    let back = corner(i);
                    if (0..3).any(|a| back[a] == 1 && node[a] & 1 != 0) {
                        continue;
                    }
                    let cell = std::array::from_fn(|a| (node[a] - back[a]) >> 1);
                    sum = sum + Q::at_sample(self, level, cell);
                    count += 1;
                }
                sum * (1.0 / f64::from(count))
            }
        }
    }

    /// Leaf of a coarser level that covers a cell which its own level does not have: level and cell; `None` in vacuum.
    pub(super) fn coarser_leaf(&self, level: usize, mut cell: [i64; 3]) -> Option<(usize, [i64; 3])> {
        for coarser in (0..level).rev() {
            cell = divided(cell, self.levels[coarser + 1].ratio);
            if self.holder_of_cell(coarser, cell).is_some() {
                return Some((coarser, cell));
            }
        }
        None
    }

    /// Quantity at a node of a level, as a leaf of a coarser level that touches it has it: interpolated between the nodes of that level around it.
    pub(super) fn at_coarser<Q: Quantity>(&self, level: usize, node: [i64; 3], coarser: usize) -> Q {
        let [fine, coarse] = [level, coarser].map(|l| self.levels[l].to_finest);
        let ratio: [i64; 3] = std::array::from_fn(|a| coarse[a] / fine[a]);
        let below = divided(node, ratio);
        let part: [f64; 3] = std::array::from_fn(|a| (node[a] - below[a] * ratio[a]) as f64 / ratio[a] as f64);
        if let Some(found) = Q::within_block(self, coarser, below, part) {
            return found;
        }
        let mut sum = Q::ZERO;
        for i in 0..8 {
            let up = corner(i);
            let weight: f64 = (0..3).map(|a| if up[a] == 1 { part[a] } else { 1.0 - part[a] }).product();
            // On a face or an edge of the lattice, the nodes off it do not count, and need not exist.
            if weight > 0.0 {
                sum = sum + self.at_node::<Q>(coarser, plus(below, up)) * weight;
            }
        }
        sum
    }

    /// Gradient at a lattice point in world units: central differences on the level's own lattice. Where the level ends, the field beyond is taken in
    /// place of a sample; the difference is one-sided where there is no value either.
    pub(super) fn gradient_at_sample(&self, level: usize, at: [i64; 3]) -> DVec3 {
        let here = self.sample(level, at);
        let spacing = self.levels[level].spacing;
        let along = |a: usize| {
            let side = |by: i64| {
                let mut beside = at;
                beside[a] += by;
                let sample = self.sample(level, beside);
                if sample.is_nan() { self.beyond_level(level, beside) } else { sample }
            };
            let [low, high] = [side(-1), side(1)];
            let (from, to) = (if low.is_nan() { here } else { low }, if high.is_nan() { here } else { high });
            let steps = f64::from(u8::from(!low.is_nan())) + f64::from(u8::from(!high.is_nan()));
            if steps == 0.0 && !here.is_nan() { 0.0 } else { (to - from) / (steps * spacing[a]) }
        };
        DVec3::new(along(0), along(1), along(2))
    }

    /// Value of the field at a lattice point that a level does not have; NaN in vacuum.
    pub(super) fn beyond_level(&self, level: usize, at: [i64; 3]) -> f64 {
        let (node, leaf) = match self.centring {
            AmrCentring::Cells => (at.map(|i| 2 * i + 1), self.coarser_leaf(level, at)),
            AmrCentring::Points => {
                // The coarsest of the leaves around it tells, as for any node.
                let around = (0..8).map(|i| std::array::from_fn(|a| at[a] - corner(i)[a]));
                (at, around.filter_map(|cell| self.coarser_leaf(level, cell)).min())
            }
        };
        leaf.map_or(f64::NAN, |(leaf, _)| self.at_coarser(level, node, leaf))
    }
}
