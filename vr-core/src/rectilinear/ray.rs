//! A ray among the planes of a rectilinear grid.

use glam::DVec3;

use super::grid::RectilinearGrid;
use crate::ray::Ray;
use crate::stretch::Stretch;

/// A ray among the planes of a rectilinear grid, with a bound on the rounding of its positions. Distances are world units behind an offset.
#[derive(Clone, Copy, Debug)]
pub(super) struct RectilinearRay<'a> {
    grid: &'a RectilinearGrid,
    origin: DVec3,
    direction: DVec3,
    /// Bound on the error of each coordinate, in world units.
    error: DVec3,
}

/// A plane that a ray crosses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    /// Distance.
    pub distance: f64,
    /// Bound on the error of the distance.
    pub error: f64,
    /// Axis that the plane is across.
    pub axis: usize,
    /// Number of the plane on that axis.
    pub plane: usize,
}

impl<'a> RectilinearRay<'a> {
    /// The ray among the planes of a grid; `offset` is the distance of its zero from the ray's own origin, and `farthest` the largest distance
    /// from there that is asked for.
    pub(super) fn new(grid: &'a RectilinearGrid, ray: &Ray, offset: f64, farthest: f64) -> Self {
        let (low, high) = grid.bounds();
        // A few roundings each of the places, of the origin, and of the sums along the ray.
        let size = low.abs().max(high.abs()) + ray.origin.abs() + (2.0 * offset.abs() + farthest) * ray.direction.abs();
        let origin = ray.origin + ray.direction * offset;
        Self { grid, origin, direction: ray.direction, error: 8.0 * f64::EPSILON * size }
    }

    /// World position at a distance.
    fn at(&self, distance: f64) -> DVec3 {
        self.origin + self.direction * distance
    }

    /// Calls `each` with every plane that is crossed between two distances; axis by axis.
    pub(super) fn each_crossing(&self, [from, to]: [f64; 2], mut each: impl FnMut(Crossing)) {
        for axis in (0..3).filter(|&a| self.direction[a] != 0.0) {
            let (places, rate) = (self.grid.axes()[axis].places(), self.direction[axis]);
            let (x0, x1) = (self.at(from)[axis], self.at(to)[axis]);
            let first = places.partition_point(|&p| p < x0.min(x1));
            for (plane, place) in places.iter().enumerate().skip(first) {
                if *place > x0.max(x1) {
                    break;
                }
                let distance = (place - self.origin[axis]) / rate;
                if distance > from && distance < to {
                    let error = self.error[axis] / rate.abs() + f64::EPSILON * distance.abs();
                    each(Crossing { distance, error, axis, plane });
                }
            }
        }
    }

    /// Bound on the error of the distance of the plane that lies at a distance; 0 if none does.
    pub(super) fn plane_error(&self, distance: f64) -> f64 {
        let (at, rounding) = (self.at(distance), f64::EPSILON * distance.abs());
        let mut largest = 0.0f64;
        for a in (0..3).filter(|&a| self.direction[a] != 0.0) {
            let axis = &self.grid.axes()[a];
            let cell = axis.cell(at[a]);
            let nearest =
                axis.places()[cell..=cell + 1].iter().map(|p| (p - at[a]).abs()).fold(f64::INFINITY, f64::min);
            if nearest <= 4.0 * (self.error[a] + self.direction[a].abs() * rounding) {
                largest = largest.max(self.error[a] / self.direction[a].abs() + rounding);
            }
        }
        largest
    }

    /// The stretch between two distances, in index space, and the cell that it lies in.
    pub(super) fn stretch(&self, from: f64, to: f64) -> (Stretch, [usize; 3]) {
        let (middle, length) = (self.at(0.5 * (from + to)), 0.5 * (to - from));
        let (mut index, mut half, mut position_error) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        let cell = std::array::from_fn(|a| {
            let axis = &self.grid.axes()[a];
            let cell = axis.cell(middle[a]);
            let (low, width) = (axis.places()[cell], axis.width(cell));
            // What rounding carries past a plane is still in the cell.
            let (first, last) = (cell as f64, (cell as f64 + 1.0).next_down());
            index[a] = (first + (middle[a] - low) / width).clamp(first, last);
            half[a] = self.direction[a] * length / width;
            position_error += self.error[a] / width + f64::EPSILON * index[a];
            cell
        });
        (Stretch { middle: index, half, position_error, gradient: None }, cell)
    }
}
