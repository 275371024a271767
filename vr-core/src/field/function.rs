//! A field that is given by a function.

use std::fmt;
use std::sync::Arc;

use glam::DVec3;

use super::{Field, FieldLine, FunctionLine};
use crate::error::ParameterError;
use crate::limits::{MAX_COORDINATE, is_length};
use crate::phantom::Phantom;
use crate::ray::Ray;
use crate::view::Clip;

type Value = dyn Fn(DVec3) -> f64 + Send + Sync;
type Gradient = dyn Fn(DVec3) -> DVec3 + Send + Sync;
type Breakpoints = dyn Fn(&Ray, &mut Vec<f64>) + Send + Sync;

/// A field given by a function of the world position, in a box.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::field::{Field, FunctionField};
///
/// // A ball that is densest in its middle, in vacuum.
/// let ball = |p: DVec3| if p.length() < 1.0 { 1.0 - p.length_squared() } else { f64::NAN };
/// let field = FunctionField::new((DVec3::NEG_ONE, DVec3::ONE), ball)?.with_gradient(|p| -2.0 * p);
/// assert_eq!(field.value(DVec3::new(0.5, 0.0, 0.0)), Some(0.75));
/// assert_eq!(field.value(DVec3::new(0.9, 0.9, 0.0)), None);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone)]
pub struct FunctionField {
    bounds: (DVec3, DVec3),
    spacing: f64,
    range: Option<(f64, f64)>,
    value: Arc<Value>,
    gradient: Option<Arc<Gradient>>,
    lipschitz: Option<f64>,
    breakpoints: Option<Arc<Breakpoints>>,
}

/// Number of parts that the mean edge of the box has by default.
const PARTS: f64 = 64.0;
/// Number of places along each edge at which the function is evaluated for the range.
const PLACES: usize = 24;

/// Spacing of a function of which nothing is known: a part of the mean edge of its box.
fn default_spacing((low, high): (DVec3, DVec3)) -> f64 {
    (high - low).element_sum() / (3.0 * PARTS)
}

impl FunctionField {
    /// A field in a world box, given by its value at a position; NaN is vacuum.
    ///
    /// Steps are counted in a 64th of the box's mean edge, and the range of values is that at 24³ places in the box, unless the caller says
    /// otherwise.
    ///
    /// # Errors
    /// A box without extent, or beyond 10³⁰.
    pub fn new(
        bounds: (DVec3, DVec3),
        value: impl Fn(DVec3) -> f64 + Send + Sync + 'static,
    ) -> Result<Self, ParameterError> {
        let (low, high) = bounds;
        let possible = |x: f64| x.abs() <= MAX_COORDINATE;
        if !(low.cmplt(high).all() && [low, high].iter().all(|c| c.to_array().into_iter().all(possible))) {
            let allowed = "must be two corners, the first below the second, both within 1e30";
            return Err(ParameterError::new("volume.bounds", bounds, allowed));
        }
        Ok(Self {
            bounds,
            spacing: default_spacing(bounds),
            range: seen_range(bounds, &value),
            value: Arc::new(value),
            gradient: None,
            lipschitz: None,
            breakpoints: None,
        })
    }

    /// A phantom as the function that it is, without a grid.
    pub fn of_phantom(phantom: Arc<dyn Phantom>) -> Self {
        let [value, gradient, breakpoints] = [0; 3].map(|_| Arc::clone(&phantom));
        Self {
            bounds: phantom.domain(),
            spacing: default_spacing(phantom.domain()),
            range: Some(phantom.value_range()),
            value: Arc::new(move |p| value.value(p)),
            gradient: Some(Arc::new(move |p| gradient.gradient(p))),
            lipschitz: None,
            breakpoints: Some(Arc::new(move |ray, out| breakpoints.breakpoints(ray.origin, ray.direction, out))),
        }
    }

    /// The same with its gradient per world unit, so that it can be shaded.
    #[must_use]
    pub fn with_gradient(self, gradient: impl Fn(DVec3) -> DVec3 + Send + Sync + 'static) -> Self {
        Self { gradient: Some(Arc::new(gradient)), ..self }
    }

    /// The same with another world length that steps are counted in.
    ///
    /// # Errors
    /// A length that is not positive and finite.
    pub fn with_spacing(self, spacing: f64) -> Result<Self, ParameterError> {
        if !is_length(spacing) {
            return Err(ParameterError::new("volume.spacing", spacing, "must be positive and finite, 1e-24 to 1e24"));
        }
        Ok(Self { spacing, ..self })
    }

    /// The same with another range of values.
    #[must_use]
    pub fn with_value_range(self, range: (f64, f64)) -> Self {
        Self { range: Some(range), ..self }
    }

    /// The same with an upper bound of the gradient's length between breakpoints, from which errors are bounded; without one they are
    /// estimated, which is far cheaper.
    #[must_use]
    pub fn with_lipschitz(self, bound: f64) -> Self {
        Self { lipschitz: Some(bound), ..self }
    }

    /// The same with the places at which it is not smooth: appends world distances along a ray, in any order and of either sign.
    #[must_use]
    pub fn with_breakpoints(self, breakpoints: impl Fn(&Ray, &mut Vec<f64>) + Send + Sync + 'static) -> Self {
        Self { breakpoints: Some(Arc::new(breakpoints)), ..self }
    }

    /// The value at a world position, inside the box or not; NaN in vacuum.
    pub(super) fn raw(&self, at: DVec3) -> f64 {
        (self.value)(at)
    }

    pub(super) fn raw_gradient(&self) -> Option<&Gradient> {
        self.gradient.as_deref()
    }

    pub(super) fn lipschitz(&self) -> Option<f64> {
        self.lipschitz
    }

    pub(super) fn breakpoints(&self, ray: &Ray, out: &mut Vec<f64>) {
        if let Some(breakpoints) = &self.breakpoints {
            breakpoints(ray, out);
        }
    }

    fn contains(&self, at: DVec3) -> bool {
        at.cmpge(self.bounds.0).all() && at.cmple(self.bounds.1).all()
    }
}

/// Smallest and largest value at places spread over a box; `None` if all of them are vacuum.
fn seen_range((low, high): (DVec3, DVec3), value: impl Fn(DVec3) -> f64) -> Option<(f64, f64)> {
    let place = |i: usize| {
        let at = [i % PLACES, i / PLACES % PLACES, i / PLACES / PLACES];
        low + (high - low) * DVec3::from_array(at.map(|k| (k as f64 + 0.5) / PLACES as f64))
    };
    let values = (0..PLACES * PLACES * PLACES).map(|i| value(place(i))).filter(|v| v.is_finite());
    values.map(|v| (v, v)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

impl Field for FunctionField {
    fn kind(&self) -> &'static str {
        "function"
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    fn spacing(&self) -> f64 {
        self.spacing
    }

    fn value_range(&self) -> Option<(f64, f64)> {
        self.range
    }

    fn value(&self, at: DVec3) -> Option<f64> {
        let value = self.contains(at).then(|| self.raw(at))?;
        (!value.is_nan()).then_some(value)
    }

    fn has_gradient(&self) -> bool {
        self.gradient.is_some()
    }

    fn gradient(&self, at: DVec3) -> Option<DVec3> {
        self.value(at)?;
        self.gradient.as_ref().map(|gradient| gradient(at))
    }

    fn along<'a>(&'a self, ray: &Ray, clip: &Clip, far: f64, gradients: bool) -> Option<Box<dyn FieldLine + 'a>> {
        let boxed = Clip { crop: Some(self.bounds), planes: Vec::new() };
        let ([a, b], [from, to]) = (ray.inside(&boxed)?, ray.inside(clip)?);
        let (start, end) = (a.max(from), b.min(to).min(far));
        let line = FunctionLine::new(self, *ray, start, end);
        (start < end).then(|| Box::new(if gradients { line.with_gradients() } else { line }) as Box<dyn FieldLine>)
    }
}

impl fmt::Debug for FunctionField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "FunctionField {{ bounds: {:?}, spacing: {} }}", self.bounds, self.spacing)
    }
}
