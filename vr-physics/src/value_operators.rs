//! The compositing operators of values: maximum, minimum, average, first crossing.

use vr_core::TransferFunction;
use vr_core::bound::{Bound, largest};
use vr_core::cancel;
use vr_core::field::{FieldLine, LineModel, Poly};

use crate::crossings::crossings;
pub use crate::first_crossing::{First, Hit, first};
pub use crate::picked_color::PickedColor;
use crate::transport::Certainty;

/// One value of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// The calibrated value.
    pub value: f64,
    /// Upper bound (or estimate) of its error.
    pub error: f64,
    /// True if `error` is a bound.
    pub certain: bool,
    /// Distance along the ray; +∞ for an average.
    pub s: f64,
    /// Colour of the place, white where it has none of its own; of an average the mean.
    pub color: PickedColor,
}

impl Pick {
    /// The pixel (α(v)·c(v)·color, α(v)), with α as given.
    pub fn pixel(&self, transfer: &TransferFunction) -> ([f64; 4], Certainty) {
        let pixel = transfer.at(self.value).pixel();
        let [red, green, blue] = self.color.rgb;
        let brightest = transfer.brightest_color().max(1.0);
        // Every segment that the true value may lie in: monotone in opacity and in colour, so its ends there tell how far.
        let (low, high) = (self.value - self.error, self.value + self.error);
        let mut error = Bound::ZERO;
        let off = Bound::new(self.error);
        if !off.is_finite() || self.value.is_nan() {
            error = Bound::new(brightest);
        } else if off > Bound::ZERO {
            for s in transfer.segments().iter().filter(|s| s.to >= low && s.from <= high) {
                for v in [low.max(s.from), high.min(s.to)] {
                    for (there, here) in s.at(v).pixel().into_iter().zip(pixel) {
                        error = error.max(there - here);
                    }
                }
                // The product of two lines bends by at most a quarter of the product of their rises.
                let rise = largest((0..3).map(|c| s.end.color[c] - s.start.color[c]));
                // An error below the value's own rounding does not show at the ends.
                let unseen = off.min(4.0 * f64::EPSILON * self.value);
                let run = s.to - s.from;
                if run.is_finite() {
                    let steep = (s.end.opacity - s.start.opacity).abs() * brightest + rise;
                    error += unseen * (steep / run);
                }
                let part = ((high.min(s.to) - low.max(s.from)) / (s.to - s.from)).clamp(0.0, 1.0);
                if part.is_finite() {
                    error += 0.25 * rise * (s.end.opacity - s.start.opacity).abs() * part * part;
                }
            }
        }
        if self.color != PickedColor::WHITE {
            error = (error + Bound::new(self.color.error) * brightest).min(brightest);
        }
        let colored = [pixel[0] * red, pixel[1] * green, pixel[2] * blue, pixel[3]];
        (colored, Certainty::new(error + 8.0 * f64::EPSILON * brightest, self.certain))
    }
}

/// A stretch without breakpoints.
pub(crate) struct Stretch {
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) model: LineModel,
    /// Bounds on the misplacement of its ends.
    pub(crate) misplaced: [Bound; 2],
}

impl Stretch {
    /// True if it certainly exists: longer than the misplacement of its ends.
    pub(crate) fn exists(&self) -> bool {
        let [a, b] = self.misplaced;
        a + b < Bound::new(self.to - self.from)
    }

    /// Bound on the error of the field's values on it: the field's own, rounding, and that of its ends' places.
    pub(crate) fn doubt(&self) -> Bound {
        let p = &self.model.field;
        if !p.coefficients().iter().all(|c| c.is_finite()) {
            return Bound::UNKNOWN;
        }
        if p.is_constant() {
            return self.model.error();
        }
        let slope = p.derivative();
        let steepest = (Bound::new(slope.at(0.0)) + slope.spread(1.0)) * (2.0 / (self.to - self.from));
        let [a, b] = self.misplaced;
        let moved = if a + b == Bound::ZERO { Bound::ZERO } else { steepest * a.max(b) };
        self.model.error() + rounding(p) + moved
    }
}

/// Largest number of halvings of a stretch whose field is only known roughly, if all of it counts.
const HALVINGS: u32 = 5;
/// The same, if only the neighbourhood of one value counts.
pub(crate) const HALVINGS_NEAR: u32 = 12;

/// The stretches of a line that are not vacuum, halved `halvings` times at most while their error is large and `matters` is true.
pub(crate) fn stretches(line: &dyn FieldLine, halvings: u32, matters: &dyn Fn(&LineModel) -> bool) -> Vec<Stretch> {
    fn refine(
        line: &dyn FieldLine,
        (from, to): (f64, f64),
        halvings: u32,
        matters: &dyn Fn(&LineModel) -> bool,
        out: &mut Vec<Stretch>,
    ) {
        let Some(model) = line.between(from, to) else { return };
        let rough = !model.error().within(1e3 * rounding(&model.field));
        if rough && halvings > 0 && matters(&model) {
            let middle = 0.5 * (from + to);
            refine(line, (from, middle), halvings - 1, matters, out);
            refine(line, (middle, to), halvings - 1, matters, out);
        } else {
            let misplaced = [from, to].map(|s| Bound::new(line.misplaced(s)));
            out.push(Stretch { from, to, model, misplaced });
        }
    }
    let (mut breakpoints, mut out) = (Vec::new(), Vec::new());
    line.breakpoints(&mut breakpoints);
    for w in breakpoints.windows(2).filter(|w| w[1] > w[0]) {
        cancel::poll();
        refine(line, (w[0], w[1]), halvings, matters, &mut out);
    }
    out
}

/// Rounding of a polynomial's value.
pub(crate) fn rounding(p: &Poly) -> f64 {
    4.0 * f64::EPSILON * (p.coefficients()[0].abs() + p.spread(1.0))
}

/// The largest (`sign` = 1) or smallest (−1) value; of equals the nearest. `None` where all is vacuum.
pub fn extreme(line: &dyn FieldLine, sign: f64) -> Option<Pick> {
    let mut best: Option<Pick> = None;
    // The same of what is surely there.
    let mut surely: Option<f64> = None;
    let (mut error, mut certain) = (Bound::ZERO, true);
    let mut turns = Vec::new();
    let stretches = stretches(line, HALVINGS, &|_| true);
    let mut place = (0, 0.0);
    for (i, stretch) in stretches.iter().enumerate() {
        let Stretch { from, to, model, .. } = stretch;
        // The error of the field is one for all: the true extreme lies in no stretch beyond its own error.
        error = error.max(stretch.doubt());
        certain &= model.certain;
        // Bounded by its coefficients: most stretches cannot hold the extreme.
        let reach = sign * model.field.coefficients()[0] + model.field.spread(1.0);
        let exists = stretch.exists();
        if surely.is_some_and(|b| sign * b >= reach) {
            continue;
        }
        turns.clear();
        turns.extend([-1.0, 1.0]);
        crossings(&model.field.derivative(), &[0.0], &mut turns);
        turns.sort_by(f64::total_cmp);
        for &t in &turns {
            let value = model.field.at(t);
            if best.is_none_or(|b| sign * value > sign * b.value) {
                let s = 0.5 * (from + to) + 0.5 * (to - from) * t;
                best = Some(Pick { value, error: 0.0, certain, s, color: PickedColor::WHITE });
                place = (i, t);
            }
            if exists && surely.is_none_or(|b| sign * value > sign * b) {
                surely = Some(value);
            }
        }
    }
    best.map(|b| {
        let doubtful = surely.map_or(Bound::UNKNOWN, |v| Bound::new(v - b.value));
        let error = error + doubtful;
        let color = PickedColor::of_extreme(line, &stretches, place, (sign, b.value, error));
        Pick { error: error.value(), certain, color, ..b }
    })
}

/// The mean over the part that is not vacuum.
pub fn average(line: &dyn FieldLine) -> Option<Pick> {
    let stretches = stretches(line, HALVINGS, &|_| true);
    let color = PickedColor::mean(line, &stretches);
    let constant = |s: &Stretch| s.model.field.is_constant() && s.model.error() == Bound::ZERO;
    if let Some(first) = stretches.first() {
        let value = first.model.field.at(0.0);
        // A field that is one number everywhere is its own mean, to the last bit.
        if stretches.iter().all(|s| constant(s) && s.model.field.at(0.0) == value) {
            let certain = stretches.iter().all(|s| s.model.certain);
            return Some(Pick { value, error: 0.0, certain, s: f64::INFINITY, color });
        }
    }
    let (mut sum, mut length, mut count) = (0.0, 0.0, 0.0);
    let (mut doubt, mut size) = (Bound::ZERO, Bound::ZERO);
    let mut certain = true;
    for Stretch { from, to, model, misplaced } in stretches {
        let half = 0.5 * (to - from);
        let part = half * model.field.integral();
        let largest = Bound::new(model.field.coefficients()[0]) + model.field.spread(1.0);
        sum += part;
        size += Bound::new(part) + 2.0 * half * rounding(&model.field);
        length += to - from;
        doubt += (model.error() + rounding(&model.field)) * (to - from);
        // Twice: of the integral and, times the mean, of the length.
        let off = misplaced[0] + misplaced[1] + 2.0 * f64::EPSILON * from.abs().max(to.abs());
        doubt += largest * off * 2.0;
        certain &= model.certain;
        count += 1.0;
    }
    let error = (doubt + size * (f64::EPSILON * count)) / length;
    (length > 0.0).then(|| Pick { value: sum / length, error: error.value(), certain, s: f64::INFINITY, color })
}
