//! Elements: parts of leaves in which the field is one trilinear function.

use glam::DVec3;

use super::grid::AmrGrid;
use super::level::{corner, divided, plus};
use super::nodes::Quantity;
use crate::floor::floor;

/// An element of a leaf: an octant of a cell with a value in its middle, or a cell between points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Element {
    /// Level of the leaf.
    pub(super) level: usize,
    /// Lowest corner, among the nodes of the level.
    pub(super) node: [i64; 3],
}

impl AmrGrid {
    /// The element of the finest lattice that holds a world position, up to rounding within the box of the values. Of several that share a face, the
    /// upper one, but at the end of the box.
    #[inline]
    pub(super) fn finest_node(&self, at: DVec3) -> [i64; 3] {
        let position = (at - self.origin) * self.levels[self.levels.len() - 1].rate;
        let [low, high] = self.inner_nodes();
        std::array::from_fn(|a| floor(position[a]).clamp(low[a], high[a] - 1))
    }

    /// The element that holds a world position within the box of the values; `None` where there are no cells.
    pub(super) fn element_at(&self, at: DVec3) -> Option<Element> {
        let elements = self.centring.elements();
        let mut node = self.finest_node(at);
        for level in (0..self.levels.len()).rev() {
            if self.holder_of_cell(level, divided(node, [elements; 3])).is_some() {
                return Some(Element { level, node });
            }
            // Corners of elements of the coarser level: of the same number of elements in a cell.
            node = divided(node, self.levels[level].ratio);
        }
        None
    }

    /// Coordinates of a world position in an element, 0 to 1 inside.
    pub(super) fn coordinates(&self, element: Element, at: DVec3) -> DVec3 {
        let position = (at - self.origin) * self.levels[element.level].rate;
        position - DVec3::from_array(element.node.map(|n| n as f64))
    }

    /// Quantity at the eight corners of an element, x fastest; NaN for corners in vacuum.
    pub(super) fn corners<Q: Quantity>(&self, element: Element) -> [Q; 8] {
        std::array::from_fn(|i| self.at_node(element.level, plus(element.node, corner(i))))
    }
}

/// Trilinear interpolation between the corners of an element.
#[inline]
pub(super) fn interpolated<Q: Quantity>(corners: &[Q; 8], at: DVec3) -> Q {
    let between = |a: Q, b: Q, t: f64| a * (1.0 - t) + b * t;
    let line = |i: usize| between(corners[i], corners[i + 1], at.x);
    let plane = |i: usize| between(line(i), line(i + 2), at.y);
    between(plane(0), plane(4), at.z)
}
