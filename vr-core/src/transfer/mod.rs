//! Transfer functions: from the field's value to extinction and emission.

mod colormap;
mod lab;
mod msh;
mod presets;
mod rows;
mod srgb;

pub use colormap::{ColorMap, cool_warm, inferno, viridis};
pub use lab::Lab;
pub use msh::{Msh, diverging};
pub use presets::{HounsfieldScale, Preset, PresetFamily, PresetUnit, is_hounsfield};
pub use rows::{Mixture, RowMix, TransferRow};
pub use srgb::{linear_to_srgb, srgb_to_linear};

use crate::error::ParameterError;
use crate::limits::{MAX_COLOR, MAX_EMISSION, is_length};
use crate::optics::{extinction_of_opacity, opacity_of_depth, opacity_of_thickness, source_weight};

/// A point of a transfer function.
///
/// # Examples
/// ```
/// use vr_core::ControlPoint;
///
/// let bone = ControlPoint::new(300.0, [1.0, 0.95, 0.85], 0.9);
/// assert_eq!(bone.emission, None, "it emits κ·color");
/// let flame = ControlPoint { emission: Some([2.0, 0.5, 0.0]), ..ControlPoint::new(0.7, [0.0; 3], 0.0) };
/// assert_eq!(flame.opacity, 0.0, "light without absorption");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct ControlPoint {
    /// Calibrated value of the field.
    pub value: f64,
    /// Linear-light RGB.
    pub color: [f64; 3],
    /// Opacity of a slab of one unit distance, in [0, 1].
    pub opacity: f64,
    /// Emission per world unit, given on its own; absent: κ·color. On all points of a transfer function, or on none.
    pub emission: Option<[f64; 3]>,
}

impl ControlPoint {
    /// A point of a density emitter: emission κ·color.
    pub fn new(value: f64, color: [f64; 3], opacity: f64) -> Self {
        Self { value, color, opacity, emission: None }
    }
}

/// Rule by which the opacity of a control point becomes extinction.
///
/// # Examples
/// ```
/// use vr_core::{ControlPoint, OpacityRule, TransferFunction};
///
/// let extinction = |rule| {
///     let points = vec![ControlPoint::new(0.0, [1.0; 3], 0.5)];
///     TransferFunction::new(points, rule, 2.0).map(|transfer| transfer.extinction_at(0.0))
/// };
/// assert!((extinction(OpacityRule::Power)? - 2f64.ln() / 2.0).abs() < 1e-15);
/// assert_eq!(extinction(OpacityRule::Extinction)?, 0.25);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum OpacityRule {
    /// α is the opacity of a homogeneous slab one unit distance thick: κ = −ln(1 − α) / unit distance (VTK's structured
    /// mappers, ANARI).
    #[default]
    Power,
    /// κ = α / unit distance (OSPRay, VTK's tetrahedra).
    Extinction,
}

/// The optical properties at one value of the field, as the points give them.
///
/// # Examples
/// ```
/// use vr_core::ControlPoint;
/// use vr_core::transfer::Optical;
///
/// let at = Optical::at_point(&ControlPoint::new(300.0, [1.0, 0.5, 0.0], 0.5));
/// assert_eq!(at.pixel(), [0.5, 0.25, 0.0, 0.5], "premultiplied");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Optical {
    /// Opacity of one unit distance, in [0, 1].
    pub opacity: f64,
    /// Linear-light RGB.
    pub color: [f64; 3],
    /// Emission per world unit, where it is given on its own.
    pub emission: [f64; 3],
}

impl Optical {
    /// The properties at a point.
    pub fn at_point(p: &ControlPoint) -> Self {
        Self { opacity: p.opacity, color: p.color, emission: p.emission.unwrap_or_default() }
    }

    /// Pixel of a single value, premultiplied: (α·c, α), α of the unit distance, whatever the length of the ray.
    pub fn pixel(&self) -> [f64; 4] {
        let [r, g, b] = self.color.map(|c| c * self.opacity);
        [r, g, b, self.opacity]
    }

    /// The properties at a fraction `t` of the way from `a` to `b`.
    pub fn lerp(t: f64, a: &Self, b: &Self) -> Self {
        let mix = |a: f64, b: f64| a + t * (b - a);
        let mix3 = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| mix(a[i], b[i]));
        // a + t (b − a) may round past b by a bit: an opacity must not.
        Self {
            opacity: mix(a.opacity, b.opacity).clamp(0.0, 1.0),
            color: mix3(a.color, b.color),
            emission: mix3(a.emission, b.emission),
        }
    }
}

/// A range of values in which opacity, colour and emission are linear (constant in the two outermost ranges).
///
/// # Examples
/// ```
/// use vr_core::{ControlPoint, OpacityRule, TransferFunction};
///
/// let points = vec![ControlPoint::new(10.0, [1.0; 3], 0.0), ControlPoint::new(20.0, [1.0; 3], 0.5)];
/// let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0)?;
/// let [below, ramp, above] = transfer.segments() else { unreachable!() };
/// assert!(below.is_clear() && below.from == f64::NEG_INFINITY);
/// assert_eq!(ramp.at(15.0).opacity, 0.25);
/// assert_eq!(above.start.opacity, 0.5);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// Lower end; −∞ for the first.
    pub from: f64,
    /// Upper end; +∞ for the last.
    pub to: f64,
    /// The properties at the lower end.
    pub start: Optical,
    /// The properties at the upper end.
    pub end: Optical,
}

impl Segment {
    /// The properties at a value; beyond the segment, its line goes on (clamped to opacities in [0, 1]).
    pub fn at(&self, value: f64) -> Optical {
        if self.from == f64::NEG_INFINITY || self.to == f64::INFINITY {
            return self.start;
        }
        Optical::lerp((value - self.from) / (self.to - self.from), &self.start, &self.end)
    }

    /// True if nothing absorbs and nothing shines here.
    pub fn is_clear(&self) -> bool {
        [self.start, self.end].iter().all(|o| o.opacity == 0.0 && o.emission == [0.0; 3])
    }

    /// True if opacity is 1 throughout.
    pub fn is_opaque(&self) -> bool {
        self.start.opacity == 1.0 && self.end.opacity == 1.0
    }
}

/// A piecewise linear transfer function of the field's calibrated value: linear-light colour c and opacity α, constant
/// outside the end points. Two points at one value are a jump; at it the later point holds.
///
/// # Examples
/// ```
/// use vr_core::{ControlPoint, OpacityRule, TransferFunction};
///
/// let points = vec![ControlPoint::new(10.0, [0.0; 3], 0.0), ControlPoint::new(20.0, [1.0; 3], 0.5)];
/// let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0)?;
/// assert_eq!(transfer.at(15.0).opacity, 0.25);
/// assert_eq!(transfer.at(1000.0).color, [1.0; 3], "constant outside the end points");
/// // A slab of two unit distances lets through a quarter: half of a half.
/// let [.., alpha] = transfer.step(20.0, 2.0);
/// assert!((alpha - 0.75).abs() < 1e-15);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    points: Vec<ControlPoint>,
    segments: Vec<Segment>,
    rule: OpacityRule,
    unit_distance: f64,
    has_emission: bool,
    /// Rows by the gradient's magnitude; none of a function of the value alone.
    rows: Vec<TransferRow>,
}

impl TransferFunction {
    /// A transfer function from its points, in order of their values.
    ///
    /// # Errors
    /// A [`ParameterError`] naming the point for: no point, values not sorted, α outside [0, 1], negative or non-finite numbers,
    /// emission on some points only, a unit distance that is not 10⁻²⁴ to 10²⁴, colours above 10¹², or emission above 10¹² in a unit
    /// distance, which sums in f32 might not keep.
    pub fn new(points: Vec<ControlPoint>, rule: OpacityRule, unit_distance: f64) -> Result<Self, ParameterError> {
        if points.is_empty() {
            return Err(ParameterError::new("transfer.points", "none", "must have at least one point"));
        }
        if !is_length(unit_distance) {
            let field = "transfer.unit_distance";
            return Err(ParameterError::new(field, unit_distance, "must be positive and finite, 1e-24 to 1e24"));
        }
        let has_emission = points[0].emission.is_some();
        for (i, p) in points.iter().enumerate() {
            let field = |name: &str| format!("transfer.points[{i}].{name}");
            if !p.value.is_finite() {
                return Err(ParameterError::new(field("value"), p.value, "must be finite"));
            }
            if i > 0 && p.value < points[i - 1].value {
                return Err(ParameterError::new(field("value"), p.value, "points must be sorted by value"));
            }
            if !(0.0..=1.0).contains(&p.opacity) {
                return Err(ParameterError::new(field("opacity"), p.opacity, "must be in [0, 1]"));
            }
            let light = |c: [f64; 3], max: f64| c.iter().all(|x| (0.0..=max).contains(x));
            if !light(p.color, MAX_COLOR) {
                return Err(ParameterError::new(
                    field("color"),
                    p.color,
                    "must be finite and not negative, 1e12 at most",
                ));
            }
            if p.emission.is_some() != has_emission {
                let allowed = "emission must be given on all points or on none";
                return Err(ParameterError::new(field("emission"), p.emission, allowed));
            }
            // Per world unit: large in small worlds.
            if !light(p.emission.unwrap_or_default().map(|e| e * unit_distance), MAX_EMISSION) {
                let allowed = "must be finite and not negative, 1e12 in a unit distance at most";
                return Err(ParameterError::new(field("emission"), p.emission, allowed));
            }
        }
        let segments = segments(&points);
        Ok(Self { points, segments, rule, unit_distance, has_emission, rows: Vec::new() })
    }

    /// The points, as given; of a function with rows, those of their upper bound.
    pub fn points(&self) -> &[ControlPoint] {
        &self.points
    }

    /// The ranges of values on which everything is linear, from −∞ to +∞ without gaps.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Rule by which the opacities become extinction.
    pub fn rule(&self) -> OpacityRule {
        self.rule
    }

    /// World length that the opacities belong to.
    pub fn unit_distance(&self) -> f64 {
        self.unit_distance
    }

    /// True if emission is given on its own, rather than as κ·color.
    pub fn has_emission(&self) -> bool {
        self.has_emission
    }

    /// The segment that holds at a value.
    pub fn segment_at(&self, value: f64) -> &Segment {
        let i = self.segments.partition_point(|s| s.from <= value);
        &self.segments[i.max(1) - 1]
    }

    /// Opacity, colour and emission at a value, exactly as the points give them.
    pub fn at(&self, value: f64) -> Optical {
        self.segment_at(value).at(value)
    }

    /// The limit of opacity, colour and emission as values approach this one from below.
    pub fn at_below(&self, value: f64) -> Optical {
        let i = self.segments.partition_point(|s| s.from < value);
        let segment = &self.segments[i.max(1) - 1];
        if value == segment.to { segment.end } else { segment.at(value) }
    }

    /// Values at which light or extinction jumps, ascending: those at which there are two different points, and the ends of opaque
    /// ranges, at which extinction goes to infinity and stays there.
    pub fn breaks(&self) -> impl Iterator<Item = f64> + '_ {
        let opaque = |s: &Segment| s.is_opaque() && self.rule == OpacityRule::Power;
        let breaks = self.segments.windows(2).filter(move |w| w[0].end != w[1].start || opaque(&w[0]) != opaque(&w[1]));
        breaks.map(|w| w[1].from)
    }

    /// κ of an opacity of this transfer function, per world unit; +∞ for 1 under the power rule.
    pub fn extinction(&self, opacity: f64) -> f64 {
        match self.rule {
            OpacityRule::Power => extinction_of_opacity(opacity, self.unit_distance),
            OpacityRule::Extinction => opacity / self.unit_distance,
        }
    }

    /// κ at a value, per world unit.
    pub fn extinction_at(&self, value: f64) -> f64 {
        self.extinction(self.at(value).opacity)
    }

    /// Light (r, g, b) and opacity of a homogeneous step of `length` world units at a value: b = q·length·w(τ), α = 1 − e^(−τ).
    pub fn step(&self, value: f64, length: f64) -> [f64; 4] {
        self.step_of(&self.at(value), length)
    }

    /// Light and opacity of a homogeneous step of `length` world units with the given properties; see [`TransferFunction::step`].
    pub fn step_of(&self, at: &Optical, length: f64) -> [f64; 4] {
        let ratio = length / self.unit_distance;
        let (alpha, tau) = match self.rule {
            OpacityRule::Power => (opacity_of_thickness(at.opacity, ratio), self.extinction(at.opacity) * length),
            OpacityRule::Extinction => (opacity_of_depth(at.opacity * ratio), at.opacity * ratio),
        };
        let light = if self.has_emission {
            let weight = source_weight(tau) * length;
            at.emission.map(|e| e * weight)
        } else {
            at.color.map(|c| c * alpha)
        };
        [light[0], light[1], light[2], alpha]
    }

    /// The largest colour or emission component of any point.
    pub fn brightest(&self) -> f64 {
        self.brightest_color().max(self.brightest_emission())
    }

    /// The largest colour component of any point.
    pub fn brightest_color(&self) -> f64 {
        self.brightest_color_by_channel().into_iter().fold(0.0, f64::max)
    }

    /// The largest colour of any point, channel by channel.
    pub fn brightest_color_by_channel(&self) -> [f64; 3] {
        std::array::from_fn(|c| self.points.iter().map(|p| p.color[c]).fold(0.0, f64::max))
    }

    /// The largest emission component of any point, per world unit; 0 where emission is not given on its own.
    pub fn brightest_emission(&self) -> f64 {
        self.points.iter().flat_map(|p| p.emission.unwrap_or_default()).fold(0.0, f64::max)
    }

    /// True if it jumps, by two different points at one value.
    pub fn has_jumps(&self) -> bool {
        let jumps = |own: &Self| own.segments.windows(2).any(|w| w[0].end != w[1].start);
        jumps(self) || self.rows.iter().any(|row| jumps(&row.transfer))
    }
}

fn segments(points: &[ControlPoint]) -> Vec<Segment> {
    let constant =
        |from, to, p: &ControlPoint| Segment { from, to, start: Optical::at_point(p), end: Optical::at_point(p) };
    let (first, last) = (&points[0], &points[points.len() - 1]);
    let mut segments = vec![constant(f64::NEG_INFINITY, first.value, first)];
    for pair in points.windows(2).filter(|pair| pair[0].value < pair[1].value) {
        segments.push(Segment {
            from: pair[0].value,
            to: pair[1].value,
            start: Optical::at_point(&pair[0]),
            end: Optical::at_point(&pair[1]),
        });
    }
    segments.push(constant(last.value, f64::INFINITY, last));
    segments
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tf(points: &[(f64, f64)]) -> TransferFunction {
        let points = points.iter().map(|&(v, a)| ControlPoint::new(v, [a, 1.0, 0.5], a)).collect();
        TransferFunction::new(points, OpacityRule::Power, 2.0).unwrap()
    }

    #[test]
    fn linear_between_constant_outside_and_later_at_a_jump() {
        let t = tf(&[(0.0, 0.0), (10.0, 0.5), (10.0, 0.9), (20.0, 1.0)]);
        assert_eq!(t.at(-5.0).opacity, 0.0);
        assert_eq!(t.at(5.0).opacity, 0.25);
        assert_eq!(t.at(10.0).opacity, 0.9);
        assert!((t.at(10.0f64.next_down()).opacity - 0.5).abs() < 1e-15);
        assert_eq!(t.at(99.0).opacity, 1.0);
        assert_eq!(t.at(5.0).pixel(), [0.0625, 0.25, 0.125, 0.25]);
        assert_eq!(t.extinction_at(99.0), f64::INFINITY);
        assert!((t.extinction_at(5.0) - -(0.75f64.ln()) / 2.0).abs() < 1e-16);
        assert!(t.has_jumps());
        assert!(!tf(&[(0.0, 0.1), (1.0, 0.2)]).has_jumps());
    }

    #[test]
    fn refuses_what_makes_no_sense() {
        let p = ControlPoint::new;
        let new = |points, unit| TransferFunction::new(points, OpacityRule::Power, unit);
        assert!(new(vec![], 1.0).is_err());
        assert!(new(vec![p(1.0, [0.0; 3], 0.0), p(0.0, [0.0; 3], 0.0)], 1.0).is_err());
        for alpha in [-0.1, 1.1, f64::NAN] {
            let e = new(vec![p(1.0, [0.0; 3], alpha)], 1.0).unwrap_err();
            assert_eq!(e.field, "transfer.points[0].opacity");
        }
        assert!(new(vec![p(f64::NAN, [0.0; 3], 0.0)], 1.0).is_err());
        assert!(new(vec![p(0.0, [-1.0; 3], 0.0)], 1.0).is_err());
        assert!(new(vec![p(0.0, [0.0; 3], 0.0)], 0.0).is_err());
        let mixed = vec![p(0.0, [0.0; 3], 0.0), ControlPoint { emission: Some([1.0; 3]), ..p(1.0, [0.0; 3], 0.0) }];
        assert!(new(mixed, 1.0).is_err());
    }

    #[test]
    fn refuses_what_arithmetic_cannot_keep() {
        let with = |color: f64, emission: Option<f64>, unit| {
            let p = ControlPoint { emission: emission.map(|e| [e; 3]), ..ControlPoint::new(0.0, [color; 3], 0.5) };
            TransferFunction::new(vec![p], OpacityRule::Power, unit)
        };
        // The largest and the smallest that are allowed leave κ and its inverse finite in f32.
        for unit in [1e-24, 1e24] {
            let kappa = with(1e12, Some(1e11 / unit), unit).unwrap().extinction_at(0.0) as f32;
            assert!(kappa.is_normal() && (1.0 / kappa).is_normal(), "{kappa}");
        }
        for unit in [1e-46, 9e-25, 2e24, f64::INFINITY] {
            let e = with(1.0, None, unit).unwrap_err();
            assert!(e.field == "transfer.unit_distance" && e.allowed.contains("1e-24 to 1e24"), "{e}");
        }
        let field = |color, emission| with(color, emission, 1.0).unwrap_err().field;
        assert_eq!(field(1.1e12, None), "transfer.points[0].color");
        assert_eq!(field(f64::INFINITY, None), "transfer.points[0].color");
        assert_eq!(field(1.0, Some(1.1e12)), "transfer.points[0].emission");
        assert_eq!(field(1.0, Some(f64::NAN)), "transfer.points[0].emission");
    }
}
