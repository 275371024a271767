//! Stretches of a ray through a rectilinear grid.

use super::grid::RectilinearGrid;
use super::line::ONE_CELL;
use crate::field::Stretch;
use crate::ray::{IndexRay, Ray};
use crate::view::Clip;

impl RectilinearGrid {
    /// Appends the stretches of a ray between two world distances that are not vacuum, ascending.
    pub(super) fn append_stretches(&self, ray: &Ray, [from, to]: [f64; 2], out: &mut Vec<Stretch>) {
        let Some(part) = IndexRay::new(ray, self.extent(), ONE_CELL, &Clip::default(), to) else { return };
        let IndexRay { start, end, offset, .. } = part;
        let calibration = self.lattice().calibration();
        let origin = ray.origin + ray.direction * offset;
        for part in self.parts_along(origin, ray.direction, [start.max(from - offset), end]) {
            // A part that is not vacuum has a range.
            let Some(range) = self.bricks().range(part.brick, calibration) else { continue };
            out.push(Stretch { from: part.from + offset, to: part.to + offset, spacing: part.spacing, range });
        }
    }
}
