//! A component of the medium on a stretch of a ray: one segment of one row of the transfer function, and its share.

use vr_core::OpacityRule;
use vr_core::transfer::Segment;

/// A quantity linear in the field: value where the field's polynomial is at its middle coefficient, and slope.
#[derive(Clone, Copy)]
pub(crate) struct Linear {
    pub(crate) middle: f64,
    pub(crate) slope: f64,
}

impl Linear {
    pub(crate) fn bound(self, spread: f64) -> f64 {
        self.middle.abs() + self.slope.abs() * spread
    }
}

/// Share of a component, a factor on its extinction: value where the gradient is that of the stretch's middle, and slope by the gradient's magnitude.
#[derive(Clone, Copy)]
pub(crate) struct Share {
    pub(crate) middle: f64,
    pub(crate) slope: f64,
}

impl Share {
    pub(crate) const ALL: Self = Self { middle: 1.0, slope: 0.0 };

    /// Bound where the square of the gradient is no farther than `spread` from its value `square` at the middle.
    pub(crate) fn bound(self, square: f64, spread: f64) -> f64 {
        self.middle.abs() + 2.0 * self.slope.abs() * (square + spread).max(0.0).sqrt()
    }
}

/// A component of the medium on a stretch: opacity, colour and emission are linear in the field.
#[derive(Clone, Copy)]
pub(crate) struct Component {
    pub(crate) share: Share,
    pub(crate) alpha: Linear,
    /// 1 − α at the middle, with all its digits however close α comes to 1.
    pub(crate) clear: f64,
    pub(crate) color: [Linear; 3],
    pub(crate) emission: [Linear; 3],
    /// Opacity at the segment's start.
    pub(crate) first_opacity: f64,
}

impl Component {
    /// Makes the component of a segment where the field is `f0` in the middle.
    pub(crate) fn new(segment: &Segment, f0: f64, share: Share) -> Self {
        let (start, end) = (&segment.start, &segment.end);
        let span = segment.to - segment.from;
        let at = segment.at(f0);
        let linear = |middle: f64, a: f64, b: f64| Linear { middle, slope: if a == b { 0.0 } else { (b - a) / span } };
        // Not clamped as Segment::at does: the line must go on for the bounds to hold.
        let t = if span.is_finite() { (f0 - segment.from) / span } else { 0.0 };
        let alpha = linear(start.opacity + t * (end.opacity - start.opacity), start.opacity, end.opacity);
        // From the end where less is clear: a sum of two numbers that are not negative.
        let (less, at_less) =
            if start.opacity > end.opacity { (start.opacity, segment.from) } else { (end.opacity, segment.to) };
        let clear =
            if alpha.slope == 0.0 { 1.0 - alpha.middle } else { (1.0 - less) + (alpha.slope * (f0 - at_less)).abs() };
        Self {
            share,
            alpha,
            clear,
            color: std::array::from_fn(|c| linear(at.color[c], start.color[c], end.color[c])),
            emission: std::array::from_fn(|c| linear(at.emission[c], start.emission[c], end.emission[c])),
            first_opacity: start.opacity,
        }
    }
}

/// κ of an opacity α and of 1 − α, whichever has the digits.
pub(crate) fn extinction_of(rule: OpacityRule, unit: f64, alpha: f64, clear: f64) -> f64 {
    match rule {
        OpacityRule::Extinction => alpha / unit,
        OpacityRule::Power if alpha < 0.5 => -libm::log1p(-alpha) / unit,
        OpacityRule::Power => -libm::log(clear) / unit,
    }
}
