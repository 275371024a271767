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
            AmrCentring::Points => Some(self.corners::<f64>(element)),
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
