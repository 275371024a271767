//! An adaptive mesh as a field.

use glam::DVec3;

use super::element::{Element, interpolated};
use super::grid::AmrGrid;
use super::line::AmrLine;
use super::nodes::Quantity;
use crate::field::{Field, FieldLine};
use crate::ray::Ray;
use crate::view::Clip;

impl AmrGrid {
    /// Quantity at a world position; `None` in vacuum. Places on the outermost face belong to the field.
    fn at<Q: Quantity>(&self, at: DVec3, is_there: impl Fn(&Q) -> bool) -> Option<Q> {
        let (low, high) = self.bounds();
        if !(at.cmpge(low).all() && at.cmple(high).all()) {
            return None;
        }
        let inside = |element: Element| {
            let place = self.coordinates(element, at).clamp(DVec3::ZERO, DVec3::ONE);
            Some(interpolated(&self.corners::<Q>(element), place)).filter(&is_there)
        };
        let found = self.element_at(at).and_then(inside);
        // The outermost faces are the lower ones of elements in vacuum.
        found.or_else(|| {
            let back = DVec3::select(at.cmpge(high), self.finest_spacing() * 1e-3, DVec3::ZERO);
            if back == DVec3::ZERO { None } else { self.element_at(at - back).and_then(inside) }
        })
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
        self.at(at, |value: &f64| !value.is_nan())
    }

    fn has_gradient(&self) -> bool {
        true
    }

    fn gradient(&self, at: DVec3) -> Option<DVec3> {
        self.at(at, |gradient: &DVec3| !gradient.is_nan())
    }

    fn jumps(&self, ray: &Ray, part: [f64; 2], out: &mut Vec<f64>) {
        AmrLine::jumps(self, ray, part, out);
    }

    fn along<'a>(&'a self, ray: &Ray, clip: &Clip, far: f64, gradients: bool) -> Option<Box<dyn FieldLine + 'a>> {
        Some(Box::new(AmrLine::new(self, ray, clip, far, gradients)?))
    }

    fn prepare_derived(&self) {
        self.tree();
    }
}
