//! Values at the rim of a level, where coarser leaves are near.

use glam::DVec3;

use super::block::AmrCentring;
use super::element::{Element, interpolated};
use super::grid::AmrGrid;
use super::inner_value::{around, trilinear};
use super::level::{corner, plus};

impl AmrGrid {
    /// The value in an element some corner of which a coarser leaf touches; NaN in vacuum. What [`corners`](Self::corners) are made of is looked up once.
    pub(super) fn rim_value(&self, element: Element, place: DVec3) -> f64 {
        let corners = match self.centring {
            AmrCentring::Cells => self.corners_from_cells(element),
            AmrCentring::Points => Some(self.corners_from_points(element)),
        };
        corners.map_or(f64::NAN, |corners| interpolated(&corners, place))
    }

    /// Values at the corners of an octant. It touches eight cells of its level, and each corner 1, 2, 4 or all of these; `None` if one of them is vacuum.
    fn corners_from_cells(&self, Element { level, node }: Element) -> Option<[f64; 8]> {
        let low = node.map(|n| (n - 1) >> 1);
        let mut cells = [(f64::NAN, level); 8];
        for (i, (value, leaf)) in cells.iter_mut().enumerate() {
            let cell = plus(low, corner(i));
            *value = self.sample(level, cell);
            if value.is_nan() {
                // Without a value, or not of this level.
                if self.holds_sample(level, cell) {
                    return None;
                }
                *leaf = self.coarser_leaf(level, cell)?.0;
            }
        }
        let at_corner = |number: usize| {
            let at = plus(node, corner(number));
            // An odd node is the middle of cells along that axis.
            let touches = |i: usize| (0..3).all(|a| at[a] & 1 == 0 || (at[a] >> 1) - low[a] == corner(i)[a]);
            let (mut sum, mut count, mut coarsest) = (0.0, 0.0, level);
            for (_, (value, leaf)) in cells.iter().enumerate().filter(|(i, _)| touches(*i)) {
                (sum, count, coarsest) = (sum + value, count + 1.0, coarsest.min(*leaf));
            }
            if coarsest == level { sum / count } else { self.at_coarser(level, at, coarsest) }
        };
        Some(std::array::from_fn(at_corner))
    }

    /// Values at the corners of a cell between points: each touches eight of the 27 cells around; NaN for those in vacuum.
    fn corners_from_points(&self, Element { level, node }: Element) -> [f64; 8] {
        let leaf_of = |i: usize| {
            let cell = plus(node, [i % 3, i / 3 % 3, i / 9].map(|side| side as i64 - 1));
            let is_own = i == 13 || self.holder_of_cell(level, cell).is_some();
            if is_own { level } else { self.coarser_leaf(level, cell).map_or(level, |leaf| leaf.0) }
        };
        let leaves: [usize; 27] = std::array::from_fn(leaf_of);
        std::array::from_fn(|number| {
            let up = corner(number);
            let touched = (0..8).map(|i| (0..3).map(|a| (up[a] + corner(i)[a]) as usize * [1, 3, 9][a]).sum::<usize>());
            let coarsest = touched.map(|i| leaves[i]).min().unwrap_or(level);
            let at = plus(node, up);
            if coarsest == level { self.sample(level, at) } else { self.at_coarser(level, at, coarsest) }
        })
    }

    /// The value in an element of a level, of which `part` is the place, if the samples of one block tell it.
    #[inline]
    pub(super) fn value_within_block(&self, level: usize, node: [i64; 3], part: [f64; 3]) -> Option<f64> {
        let elements = self.centring.elements();
        let holder = &self.blocks[self.holder_of_cell(level, node.map(|n| n.div_euclid(elements)))?];
        let part = DVec3::from_array(part);
        match self.centring {
            AmrCentring::Cells => {
                let low = node.map(|n| (n - 1) >> 1);
                // The lower or the upper half of the way between two middles.
                let half = DVec3::from_array(std::array::from_fn(|a| (node[a] - 2 * low[a] - 1) as f64));
                let inside = holder.holds(low, low.map(|i| i + 1));
                inside.then(|| trilinear(&around(holder, low), (half + part) * 0.5))
            }
            AmrCentring::Points => {
                let inside = holder.holds(node.map(|n| n - 1), node.map(|n| n + 2));
                inside.then(|| trilinear(&around(holder, node), part))
            }
        }
    }
}
