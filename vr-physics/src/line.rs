//! A scalar field along one ray, as the integrator wants it.

use crate::bound::{Bound, largest};
use crate::poly::Poly;
use crate::segments::Cut;

/// A field along one ray: smooth between breakpoints, and known there as a polynomial with a bound on its error.
///
/// Grids under any reconstruction filter are such fields ([`crate::GridLine`]), and so are analytic functions
/// ([`crate::AnalyticLine`]). Implement it to have the reference integrate any other kind of field.
pub trait LineField {
    /// Appends the distances, ascending, between which the field is smooth; the first and the last enclose all of it.
    fn breakpoints(&self, out: &mut Vec<f64>);

    /// The field between two distances that no breakpoint separates; `None` in vacuum.
    ///
    /// Asked again for parts of an interval where the error was too large: the bound should shrink then.
    fn between(&self, from: f64, to: f64) -> Option<LineModel>;

    /// Upper bound of how far the breakpoint at a distance may be from its true place: an end of the line, or where the field jumps.
    /// 0 where the field is continuous, for nothing depends on it there.
    fn misplaced(&self, _at: f64) -> f64 {
        0.0
    }
}

/// The part of a ray that a field is given on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Chord {
    /// Where it begins.
    pub(crate) start: f64,
    /// Where it ends; above `start`.
    pub(crate) end: f64,
    /// World distance from the ray's own origin to where these are counted from.
    pub(crate) offset: f64,
}

impl Chord {
    /// Its length.
    pub(crate) fn length(&self) -> f64 {
        self.end - self.start
    }
}

/// A field along a ray that says what its breakpoints are.
pub(crate) trait RayField: LineField {
    /// The part of the ray.
    fn chord(&self) -> Chord;

    /// Appends where an account of the ray begins anew, and why; in any order.
    fn cuts(&self, out: &mut Vec<(f64, Cut)>);
}

/// A field on an interval, stretched to [−1, 1].
#[derive(Clone, Copy, Debug)]
pub struct LineModel {
    /// The calibrated value.
    pub field: Poly,
    /// Upper bound of |field − truth| on the interval.
    pub field_error: f64,
    /// The world gradient, if it was asked for, each component with an error of at most `gradient_error`.
    pub gradient: Option<[Poly; 3]>,
    /// See there.
    pub gradient_error: f64,
    /// Open interval that holds every value of the field inside the stretch; its ends are reached at the stretch's ends at most. `None` if
    /// unknown.
    pub limits: Option<[f64; 2]>,
    /// False if the errors are estimates and no bounds.
    pub certain: bool,
}

impl LineModel {
    /// The error of the field; unknown if it is NaN.
    pub(crate) fn error(&self) -> Bound {
        Bound::new(self.field_error)
    }

    /// The error of each component of the gradient.
    pub(crate) fn slope_error(&self) -> Bound {
        Bound::new(self.gradient_error)
    }

    /// Enclosure of the field's true values on the interval.
    pub(crate) fn range(&self) -> [f64; 2] {
        let (value, reach) = (self.field.coefficients()[0], Bound::new(self.field.spread(1.0)) + self.error());
        let reach = (reach + 2.0 * f64::EPSILON * value).value();
        if value.is_nan() { [f64::NEG_INFINITY, f64::INFINITY] } else { [value - reach, value + reach] }
    }

    /// True if the limits do not rule out that the field takes this value inside the stretch.
    pub(crate) fn may_be(&self, value: f64) -> bool {
        self.limits.is_none_or(|[low, high]| low < value && value < high)
    }

    /// The same on a part [a, b] of [−1, 1], stretched again.
    pub fn restricted(&self, a: f64, b: f64) -> Self {
        // Each coefficient is rounded again: beside a large constant that is much.
        let rounding = |p: &Poly| {
            let (constant, spread) = (p.coefficients()[0].abs(), p.spread(1.0));
            if spread == 0.0 { 0.0 } else { f64::EPSILON * (constant + p.degree() as f64 * spread) }
        };
        let turned = self.gradient.map_or(0.0, |g| largest(g.iter().map(rounding)));
        Self {
            field: self.field.restricted(a, b),
            field_error: (self.error() + rounding(&self.field)).value(),
            gradient: self.gradient.map(|g| g.map(|p| p.restricted(a, b))),
            gradient_error: (self.slope_error() + turned).value(),
            ..*self
        }
    }
}
