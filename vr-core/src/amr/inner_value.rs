//! Values inside a level, where no coarser leaf is near.

use glam::DVec3;

use super::block::{AmrBlock, AmrCentring};
use super::element::Element;
use super::grid::AmrGrid;
use super::level::{corner, plus};

impl AmrGrid {
    /// The value at a world position in an element, where the samples of its level tell it: all those around it are there. NaN in vacuum; `None` where the
    /// corners of the element have to be looked at one by one.
    #[inline]
    pub(super) fn inner_value(&self, Element { level, node }: Element, at: DVec3) -> Option<f64> {
        let elements = self.centring.elements();
        let number = self.holder_of_cell(level, node.map(|n| n.div_euclid(elements)))?;
        self.within_level(level, number, node, (at - self.origin) * self.levels[level].rate)
    }

    /// The same in an element of a cell of the block `number`; `position` is counted in elements of the level.
    #[inline]
    pub(super) fn within_level(&self, level: usize, number: usize, node: [i64; 3], position: DVec3) -> Option<f64> {
        let block = &self.blocks[number];
        let place = |from: [i64; 3], edge: f64| {
            let t = (position - DVec3::from_array(from.map(|i| i as f64))) * edge;
            t.clamp(DVec3::ZERO, DVec3::ONE)
        };
        match self.centring {
            AmrCentring::Cells => {
                let low = node.map(|n| (n - 1) >> 1);
                let place = place(low.map(|i| 2 * i + 1), 0.5);
                if block.holds(low, low.map(|i| i + 1)) {
                    return Some(trilinear(&around(block, low), place));
                }
                // Among several blocks; a sample that is not there may be that of a coarser level.
                let values = std::array::from_fn(|i| self.sample(level, plus(low, corner(i))));
                let value = trilinear(&values, place);
                (!value.is_nan()).then_some(value)
            }
            AmrCentring::Points => {
                let is_inner =
                    block.holds(node.map(|n| n - 1), node.map(|n| n + 2)) || self.has_same_level_around(number, node);
                is_inner.then(|| trilinear(&around(block, node), place(node, 1.0)))
            }
        }
    }

    /// True if all cells around one at the rim of a block are known to be of its level.
    pub(super) fn has_same_level_around(&self, number: usize, cell: [i64; 3]) -> bool {
        let block = &self.blocks[number];
        let complete = self.bricks().complete_sides(number);
        (0..27).all(|direction: i64| {
            let by = [direction % 3 - 1, direction / 3 % 3 - 1, direction / 9 - 1];
            // The side of the block on which the neighbour lies: its own cells are of its level.
            let side = |a: usize| {
                let beside = cell[a] + by[a];
                let is_behind = beside >= block.first[a] + block.dims[a] as i64 - 1;
                if beside < block.first[a] {
                    0
                } else if is_behind {
                    2
                } else {
                    1
                }
            };
            complete >> (side(0) + 3 * side(1) + 9 * side(2)) & 1 == 1
        })
    }
}

/// The eight samples of a block from one on, which it has.
#[inline]
pub(super) fn around(block: &AmrBlock, low: [i64; 3]) -> [f64; 8] {
    let Some(first) = block.offset(low) else { return [f64::NAN; 8] };
    let (row, layer) = (block.dims[0], block.dims[0] * block.dims[1]);
    let at = |offset: usize| f64::from(block.values[first + offset]);
    [at(0), at(1), at(row), at(row + 1), at(layer), at(layer + 1), at(layer + row), at(layer + row + 1)]
}

#[inline]
pub(super) fn trilinear(values: &[f64; 8], at: DVec3) -> f64 {
    let between = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let line = |i: usize| between(values[i], values[i + 1], at.x);
    let [a, b] = [between(line(0), line(2), at.y), between(line(4), line(6), at.y)];
    between(a, b, at.z)
}
