//! A scalar field along one ray, in the form that an integrator needs.

use super::poly::Poly;
use crate::bound::{Bound, largest};

/// A field along one ray: smooth between breakpoints, and known there as a polynomial with a bound on its error.
///
/// Distances are world units behind [`Chord::offset`].
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::field::{Field, FunctionField};
/// use vr_core::{Clip, Ray};
///
/// let field = FunctionField::new((DVec3::NEG_ONE, DVec3::ONE), |p| 3.0 + p.x)?.with_lipschitz(1.0);
/// let ray = Ray { origin: -4.0 * DVec3::X, direction: DVec3::X };
/// let line = field.along(&ray, &Clip::default(), f64::INFINITY, false).expect("it meets the box");
/// let chord = line.chord();
/// let model = line.between(chord.start, chord.end).expect("there is no vacuum");
/// assert!((model.field.at(0.0) - 3.0).abs() <= model.error().value() + 1e-12, "in the middle of the box");
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
pub trait FieldLine {
    /// The part of the ray on which the field is given.
    fn chord(&self) -> Chord;

    /// Appends the distances, ascending, between which the field is smooth; the first and the last enclose all of it.
    fn breakpoints(&self, out: &mut Vec<f64>);

    /// The field between two distances that no breakpoint separates; `None` in vacuum.
    ///
    /// Integrators ask again for parts of an interval where the error was too large: the bound should shrink then.
    fn between(&self, from: f64, to: f64) -> Option<LineModel>;

    /// The colour of the places between two distances that no breakpoint separates, by which that of the transfer function is multiplied; `None` where
    /// all is as the transfer function has it.
    fn color(&self, _from: f64, _to: f64) -> Option<LineColor> {
        None
    }

    /// Largest distance of a breakpoint (an end of the line, or a jump of the field) from its true place. 0 where the field is continuous,
    /// for nothing depends on it there.
    fn misplaced(&self, _at: f64) -> f64 {
        0.0
    }

    /// Appends the distances at which an account of the ray begins anew, each with its reason, in any order: at least that of its entry.
    fn cuts(&self, out: &mut Vec<(f64, Cut)>) {
        out.push((self.chord().start, Cut::Entry));
    }
}

/// The part of a ray that a field is given on.
///
/// # Examples
/// ```
/// use vr_core::field::Chord;
///
/// // The eye is a million units away; the digits are kept for the place in the volume.
/// let chord = Chord { start: -1.5, end: 1.0, offset: 1e6 };
/// assert_eq!(chord.length(), 2.5);
/// assert_eq!(chord.offset + chord.start, 999_998.5, "distance from the eye at which it begins");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chord {
    /// Distance at which it begins.
    pub start: f64,
    /// Distance at which it ends; above `start`.
    pub end: f64,
    /// World distance from the ray's own origin to the place from which these are counted: so they keep their digits, however far it is.
    pub offset: f64,
}

impl Chord {
    /// Its length.
    pub fn length(&self) -> f64 {
        self.end - self.start
    }
}

/// A reason to cut a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cut {
    /// Entry into the volume, or into what the clip leaves of it; among scattered points, at every end of a vacuum.
    Entry,
    /// A face across an index axis, beyond which the field is another polynomial: of a cell or, with the nearest filter, between two voxels.
    Face {
        /// 0, 1 or 2.
        axis: usize,
        /// Its index coordinate on that axis.
        at: f64,
    },
    /// A place at which the value crosses, or touches, a knot of the transfer function.
    Knot {
        /// The knot's calibrated value.
        value: f64,
    },
    /// A distance that the caller asked for.
    Asked,
}

/// A field on an interval, stretched to [−1, 1].
///
/// # Examples
/// ```
/// use vr_core::field::{LineModel, Poly};
///
/// let model = LineModel {
///     field: Poly::new(&[5.0, 1.0]),
///     field_error: 0.01,
///     gradient: None,
///     gradient_error: 0.0,
///     limits: None,
///     certain: true,
/// };
/// let [low, high] = model.range();
/// assert!(low <= 3.99 && 6.01 <= high && high < 6.02);
/// let [_, high] = model.restricted(-1.0, 0.0).range();
/// assert!(5.01 <= high && high < 5.02);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct LineModel {
    /// The calibrated value.
    pub field: Poly,
    /// Upper bound on the interval of the distance of `field` from the true field.
    pub field_error: f64,
    /// The world gradient, if the caller asked for it, each component with an error of at most `gradient_error`.
    pub gradient: Option<[Poly; 3]>,
    /// Upper bound of the error of each component of `gradient`.
    pub gradient_error: f64,
    /// Open interval that holds every value of the field inside the stretch; its ends are reached at the stretch's ends at most. `None` if
    /// unknown.
    pub limits: Option<[f64; 2]>,
    /// False if the errors are estimates and no bounds.
    pub certain: bool,
}

/// A colour on an interval, stretched to [−1, 1]: linear light between 0 and 1.
///
/// # Examples
/// ```
/// use vr_core::field::{LineColor, Poly};
///
/// // From black to yellow.
/// let rise = Poly::new(&[0.5, 0.5]);
/// let color = LineColor { channels: [rise, rise, Poly::constant(0.0)], error: 0.0 };
/// assert_eq!(color.at(0.5), [0.75, 0.75, 0.0]);
/// assert_eq!(color.restricted(0.0, 1.0).at(0.0), [0.75, 0.75, 0.0]);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct LineColor {
    /// Red, green and blue.
    pub channels: [Poly; 3],
    /// Upper bound on the interval of the distance of each channel from the true colour.
    pub error: f64,
}

impl LineColor {
    /// The colour at a place.
    pub fn at(&self, t: f64) -> [f64; 3] {
        self.channels.each_ref().map(|channel| channel.at(t))
    }

    /// The same on a part [a, b] of [−1, 1], stretched again.
    pub fn restricted(&self, a: f64, b: f64) -> Self {
        let rounding = largest(self.channels.iter().map(restriction_rounding));
        Self {
            channels: self.channels.each_ref().map(|channel| channel.restricted(a, b)),
            error: (Bound::new(self.error) + rounding).value(),
        }
    }
}

/// Appends the two ends of a line's chord and, in order, the faces between them, each a distance with its error. Faces that may be one (an edge, a
/// corner, the box itself) become one: what would lie between them need not exist. The surer one tells: a face that is grazed must not
/// swallow another that is crossed.
pub fn distinct_places([start, end]: [(f64, f64); 2], mut faces: Vec<(f64, f64)>, out: &mut Vec<f64>) {
    faces.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut last = start;
    out.push(start.0);
    for face in faces {
        let same = |other: (f64, f64)| (face.0 - other.0).abs() <= 4.0 * face.1.min(other.1);
        if !same(last) && !same(end) {
            out.push(face.0);
            last = face;
        }
    }
    out.push(end.0);
}

/// Rounding of the coefficients of a restricted polynomial: each is rounded again, and beside a large constant that is much.
fn restriction_rounding(p: &Poly) -> f64 {
    let (constant, spread) = (p.coefficients()[0].abs(), p.spread(1.0));
    if spread == 0.0 { 0.0 } else { f64::EPSILON * (constant + p.degree() as f64 * spread) }
}

impl LineModel {
    /// The error of the field; unknown if it is NaN.
    pub fn error(&self) -> Bound {
        Bound::new(self.field_error)
    }

    /// The error of each component of the gradient.
    pub fn slope_error(&self) -> Bound {
        Bound::new(self.gradient_error)
    }

    /// Enclosure of the field's true values on the interval.
    pub fn range(&self) -> [f64; 2] {
        let (value, reach) = (self.field.coefficients()[0], Bound::new(self.field.spread(1.0)) + self.error());
        let reach = (reach + 2.0 * f64::EPSILON * value).value();
        if value.is_nan() { [f64::NEG_INFINITY, f64::INFINITY] } else { [value - reach, value + reach] }
    }

    /// True if the limits do not rule out that the field takes this value inside the stretch.
    pub fn may_be(&self, value: f64) -> bool {
        self.limits.is_none_or(|[low, high]| low < value && value < high)
    }

    /// The same on a part [a, b] of [−1, 1], stretched again.
    pub fn restricted(&self, a: f64, b: f64) -> Self {
        let turned = self.gradient.map_or(0.0, |g| largest(g.iter().map(restriction_rounding)));
        Self {
            field: self.field.restricted(a, b),
            field_error: (self.error() + restriction_rounding(&self.field)).value(),
            gradient: self.gradient.map(|g| g.map(|p| p.restricted(a, b))),
            gradient_error: (self.slope_error() + turned).value(),
            ..*self
        }
    }
}
