//! Stretches of a ray through an adaptive mesh.

use super::grid::AmrGrid;
use crate::field::Stretch;
use crate::ray::Ray;

impl AmrGrid {
    /// Appends the stretches of a ray between two world distances that are not vacuum, ascending: one for each region of leaves that it crosses.
    pub(super) fn stretches_along(&self, ray: &Ray, part: [f64; 2], out: &mut Vec<Stretch>) {
        out.extend(self.parts_along(ray, part).map(|part| Stretch {
            from: part.from,
            to: part.to,
            spacing: self.mean_spacing_of(self.blocks[part.block].level),
            range: part.range,
        }));
    }
}
