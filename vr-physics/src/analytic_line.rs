//! An analytic field along a ray.

use vr_core::Ray;
use vr_core::phantom::Phantom;

use crate::bound::largest;
use crate::line::{LineField, LineModel};
use crate::poly::{Poly, chebyshev_point};

/// A phantom along a ray, as the function that it is (no samples, no filter).
///
/// Between its breakpoints the function is interpolated; the bound comes from its Lipschitz constant. A phantom that has none
/// (it is infinite) is only estimated.
pub struct AnalyticLine<'a> {
    phantom: &'a dyn Phantom,
    ray: Ray,
    start: f64,
    end: f64,
    /// Whether errors shall be bounds, where the phantom allows it.
    proven: bool,
}

/// Degree of the interpolating polynomial.
const DEGREE: usize = 12;
/// How far inside its ends a stretch is evaluated, as a part of its half length: above the rounding of the breakpoints.
const INSIDE: f64 = 1e-9;
/// Parts that a stretch without breakpoints is cut into: waves must not hide between the nodes.
const PARTS: usize = 32;

impl<'a> AnalyticLine<'a> {
    /// A phantom between two distances along a ray.
    pub fn new(phantom: &'a dyn Phantom, ray: Ray, start: f64, end: f64) -> Self {
        Self { phantom, ray, start, end, proven: true }
    }

    /// The same with errors that are estimates: from what interpolation misses at three points of each stretch. They fall with the
    /// twelfth power of its length, and bounds with the first.
    pub fn estimated(self) -> Self {
        Self { proven: false, ..self }
    }
}

impl LineField for AnalyticLine<'_> {
    fn breakpoints(&self, out: &mut Vec<f64>) {
        let mut cuts = Vec::new();
        self.phantom.breakpoints(self.ray.origin, self.ray.direction, &mut cuts);
        cuts.retain(|&s| s > self.start && s < self.end);
        let part = |k: usize| self.start + (self.end - self.start) * k as f64 / PARTS as f64;
        cuts.extend((0..PARTS).map(part));
        cuts.push(self.end);
        cuts.sort_by(f64::total_cmp);
        out.extend(cuts);
    }

    fn between(&self, from: f64, to: f64) -> Option<LineModel> {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        // A hair inside: at a breakpoint itself the field may belong to the other side.
        let value =
            |t: f64| self.phantom.value(self.ray.origin + self.ray.direction * (middle + half * t * (1.0 - INSIDE)));
        let node = |j: usize| chebyshev_point(DEGREE, j);
        let values: Vec<f64> = (0..=DEGREE).map(|j| value(node(j))).collect();
        let field = Poly::through_chebyshev_points(&values);
        // Half the largest gap between nodes, times how fast truth and interpolant can part.
        let gap = largest((0..DEGREE).map(|j| 0.5 * (node(j) - node(j + 1))));
        let slope = field.derivative();
        let parting = self.phantom.lipschitz_between_breakpoints() * half + slope.at(0.0).abs() + slope.spread(1.0);
        let certain = self.proven && parting.is_finite();
        let seen = [0.13, -0.58, 0.91].map(|t| (value(t) - field.at(t)).abs());
        let estimate = 4.0 * largest(seen);
        let field_error = if certain { (gap + INSIDE) * parting } else { estimate };
        Some(LineModel { field, field_error, gradient: None, gradient_error: 0.0, limits: None, certain })
    }
}
