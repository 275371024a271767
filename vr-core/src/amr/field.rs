//! An adaptive mesh as a field.

use glam::DVec3;

use super::element::{Element, interpolated};
use super::grid::AmrGrid;
use super::line::AmrLine;
use crate::field::{Field, FieldLine, Stretch};
use crate::ray::Ray;
use crate::view::Clip;

impl AmrGrid {
    /// Place of a world position in the element that holds it, 0 to 1.
    fn place(&self, element: Element, at: DVec3) -> DVec3 {
        self.coordinates(element, at).clamp(DVec3::ZERO, DVec3::ONE)
    }

    /// True if a world position is in the box of the values, up to rounding.
    fn is_inside(&self, at: DVec3) -> bool {
        let (low, high) = self.bounds();
        let slack = self.finest_spacing() * 1e-9;
        at.cmpge(low - slack).all() && at.cmple(high + slack).all()
    }
}

impl Field for AmrGrid {
    fn kind(&self) -> &'static str {
        "adaptive mesh"
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds()
    }

    fn spacing(&self) -> f64 {
        self.mean_spacing()
    }

    fn value_range(&self) -> Option<(f64, f64)> {
        Some(self.value_range())
    }

    fn value(&self, at: DVec3) -> Option<f64> {
        if !self.is_inside(at) {
            return None;
        }
        let element = self.element_at(at)?;
        let at_rim = || self.rim_value(element, self.place(element, at));
        let value = self.inner_value(element, at).unwrap_or_else(at_rim);
        (!value.is_nan()).then_some(value)
    }

    fn values(&self, at: &[DVec3], out: &mut [f64]) {
        self.fill_values(at, out);
    }

    fn has_gradient(&self) -> bool {
        true
    }

    fn gradient(&self, at: DVec3) -> Option<DVec3> {
        if !self.is_inside(at) {
            return None;
        }
        let element = self.element_at(at)?;
        let by_corners = || interpolated(&self.corners::<DVec3>(element), self.place(element, at));
        let gradient = self.inner_gradient(element, at).unwrap_or_else(by_corners);
        (!gradient.is_nan()).then_some(gradient)
    }

    fn jumps(&self, ray: &Ray, part: [f64; 2], out: &mut Vec<f64>) {
        let mut stretches = Vec::new();
        self.stretches_along(ray, part, &mut stretches);
        for (number, stretch) in stretches.iter().enumerate() {
            if number == 0 || !stretches[number - 1].touches(stretch) {
                out.push(stretch.from);
            }
            if stretches.get(number + 1).is_none_or(|next| !stretch.touches(next)) {
                out.push(stretch.to);
            }
        }
    }

    fn stretches(&self, ray: &Ray, part: [f64; 2], out: &mut Vec<Stretch>) -> bool {
        self.stretches_along(ray, part, out);
        true
    }

    fn along<'a>(&'a self, ray: &Ray, clip: &Clip, far: f64, gradients: bool) -> Option<Box<dyn FieldLine + 'a>> {
        Some(Box::new(AmrLine::new(self, ray, clip, far, gradients)?))
    }

    fn prepare_derived(&self) {
        self.tree();
        self.bricks();
        self.neighbors();
    }
}
