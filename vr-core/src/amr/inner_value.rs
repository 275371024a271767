//! Values inside a level, where no coarser leaf is near.

use glam::DVec3;

use super::block::{AmrBlock, AmrCentring};
use super::grid::AmrGrid;
use super::level::{corner, divided, plus};

impl AmrGrid {
    /// The value at a world position in the box of the values, where the samples of one level tell it: all eight around it are there. NaN
    /// in vacuum; `None` where the corners of the element have to be looked at one by one.
    #[inline]
    pub(super) fn inner_value(&self, at: DVec3) -> Option<f64> {
        let mut node = self.finest_node(at);
        for level in (0..self.levels.len()).rev() {
            let cell = match self.centring {
                AmrCentring::Cells => node.map(|n| n >> 1),
                AmrCentring::Points => node,
            };
            if let Some(holder) = self.holder_of_cell(level, cell) {
                return self.within_level(level, &self.blocks[holder], node, at);
            }
            node = divided(node, self.levels[level].ratio);
        }
        Some(f64::NAN)
    }

    /// The same in an element of a level, of a cell of a block.
    #[inline]
    pub(super) fn within_level(&self, level: usize, block: &AmrBlock, node: [i64; 3], at: DVec3) -> Option<f64> {
        let position = (at - self.origin) / self.levels[level].spacing;
        let local = |low: [i64; 3], shift: f64| {
            let t = position - DVec3::from_array(low.map(|i| i as f64)) - shift;
            t.clamp(DVec3::ZERO, DVec3::ONE)
        };
        match self.centring {
            AmrCentring::Cells => {
                let low = node.map(|n| (n - 1) >> 1);
                let place = local(low, 0.5);
                if block.holds(low, low.map(|i| i + 1)) {
                    return Some(trilinear(&around(block, low), place));
                }
                // Among several blocks; a sample that is not there may be that of a coarser level.
                let values = std::array::from_fn(|i| self.sample(level, plus(low, corner(i))));
                let value = trilinear(&values, place);
                (!value.is_nan()).then_some(value)
            }
            AmrCentring::Points => {
                let is_inner = block.holds(node.map(|n| n - 1), node.map(|n| n + 2)) || self.has_neighbors(level, node);
                is_inner.then(|| trilinear(&around(block, node), local(node, 0.0)))
            }
        }
    }

    /// True if a level has all cells around one.
    pub(super) fn has_neighbors(&self, level: usize, cell: [i64; 3]) -> bool {
        let side = |i: i64| i - 1;
        (0..27).all(|i: i64| {
            let by = [side(i % 3), side(i / 3 % 3), side(i / 9)];
            self.holder_of_cell(level, plus(cell, by)).is_some()
        })
    }
}

/// The eight samples of a block from one on, which it has.
#[inline]
fn around(block: &AmrBlock, low: [i64; 3]) -> [f64; 8] {
    let Some(first) = block.offset(low) else { return [f64::NAN; 8] };
    let (row, layer) = (block.dims[0], block.dims[0] * block.dims[1]);
    let at = |offset: usize| f64::from(block.values[first + offset]);
    [at(0), at(1), at(row), at(row + 1), at(layer), at(layer + 1), at(layer + row), at(layer + row + 1)]
}

#[inline]
fn trilinear(values: &[f64; 8], at: DVec3) -> f64 {
    let between = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let line = |i: usize| between(values[i], values[i + 1], at.x);
    let [a, b] = [between(line(0), line(2), at.y), between(line(4), line(6), at.y)];
    between(a, b, at.z)
}
