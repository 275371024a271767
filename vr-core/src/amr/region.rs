//! Values at many places, neighbours of which share what is looked up.

use glam::DVec3;

use super::bricks::EDGE;
use super::grid::AmrGrid;
use super::level::plus;
use crate::field::Field;

/// Cells of a block none of which is covered by finer ones.
#[derive(Clone, Copy)]
struct Region {
    level: usize,
    block: usize,
    from: [i64; 3],
    /// Behind the last one.
    to: [i64; 3],
}

impl Region {
    fn holds(&self, cell: [i64; 3]) -> bool {
        (0..3).all(|a| self.from[a] <= cell[a] && cell[a] < self.to[a])
    }
}

impl AmrGrid {
    /// Fills the values at world positions, NaN in vacuum: as long as they stay in one region, its block is not looked for again.
    pub(super) fn fill_values(&self, at: &[DVec3], out: &mut [f64]) {
        let elements = self.centring.elements();
        let mut region: Option<Region> = None;
        for (value, &at) in out.iter_mut().zip(at) {
            let within = region.and_then(|region| {
                let position = (at - self.origin) * self.levels[region.level].rate;
                let node = position.floor().to_array().map(|x| x as i64);
                let cell = if elements == 2 { node.map(|n| n >> 1) } else { node };
                if !region.holds(cell) {
                    return None;
                }
                self.within_level(region.level, region.block, node, position)
            });
            *value = within.unwrap_or_else(|| {
                region = self.region_at(at).or(region);
                self.value(at).unwrap_or(f64::NAN)
            });
        }
    }

    /// The region around a world position; `None` in vacuum, and where finer cells are near.
    fn region_at(&self, at: DVec3) -> Option<Region> {
        let element = self.element_at(at)?;
        let (level, elements) = (element.level, self.centring.elements());
        let cell = element.node.map(|n| n.div_euclid(elements));
        let number = self.holder_of_cell(level, cell)?;
        let block = &self.blocks[number];
        let end = plus(block.first, block.cells(self.centring).map(|n| n as i64));
        let bricks = self.bricks();
        if bricks.is_leaf(number) {
            return Some(Region { level, block: number, from: block.first, to: end });
        }
        let brick = std::array::from_fn(|a| (cell[a] - block.first[a]) / EDGE);
        let from: [i64; 3] = std::array::from_fn(|a| block.first[a] + brick[a] * EDGE);
        let to = std::array::from_fn(|a| (from[a] + EDGE).min(end[a]));
        (!bricks.at(self, number, brick).has_finer).then_some(Region { level, block: number, from, to })
    }
}
