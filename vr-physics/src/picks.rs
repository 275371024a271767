//! The compositing schemes that pick one value of a ray: maximum, minimum, average, first crossing.

use vr_core::TransferFunction;

use crate::crossings::crossings;
use crate::line::{LineField, LineModel};
use crate::optics::Optics;
use crate::poly::Poly;
use crate::transport::Certainty;

/// One value of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// The calibrated value.
    pub value: f64,
    /// Upper bound (or estimate) of its error.
    pub error: f64,
    /// Whether `error` is a bound.
    pub certain: bool,
    /// Where along the ray it is; +∞ for an average.
    pub s: f64,
}

impl Pick {
    /// The pixel (α(v)·c(v), α(v)), with α as given.
    pub fn pixel(&self, transfer: &TransferFunction) -> ([f64; 4], Certainty) {
        let rgba = |v: f64| {
            let o = transfer.at(v);
            [o.color[0] * o.opacity, o.color[1] * o.opacity, o.color[2] * o.opacity, o.opacity]
        };
        let pixel = rgba(self.value);
        let brightest = transfer.brightest_color().max(1.0);
        // Every segment that the true value may lie in: monotone in opacity and in colour, so its ends there tell how far.
        let (low, high) = (self.value - self.error, self.value + self.error);
        let mut error = 0.0f64;
        if self.error > 0.0 {
            for s in transfer.segments().iter().filter(|s| s.to >= low && s.from <= high) {
                for v in [low.max(s.from), high.min(s.to)] {
                    let o = s.at(v);
                    for c in 0..3 {
                        error = error.max((o.color[c] * o.opacity - pixel[c]).abs());
                    }
                    error = error.max((o.opacity - pixel[3]).abs());
                }
                // The product of two lines bends by at most a quarter of the product of their rises.
                let rise = (0..3).map(|c| (s.end.color[c] - s.start.color[c]).abs()).fold(0.0, f64::max);
                let part = ((high.min(s.to) - low.max(s.from)) / (s.to - s.from)).clamp(0.0, 1.0);
                if part.is_finite() {
                    error += 0.25 * rise * (s.end.opacity - s.start.opacity).abs() * part * part;
                }
            }
        }
        (pixel, Certainty::new(error + 4.0 * f64::EPSILON * brightest, self.certain))
    }
}

/// A stretch without breakpoints: from, to, and the field there.
type Stretch = (f64, f64, LineModel);

/// Halvings of a stretch whose field is only known roughly, where the whole of it counts.
const HALVINGS: u32 = 5;
/// The same, where only what is near one value counts.
const HALVINGS_NEAR: u32 = 12;

/// The stretches of a line that are not vacuum, halved where `matters` says that the field's error does.
fn stretches(line: &dyn LineField, halvings: u32, matters: &dyn Fn(&LineModel) -> bool) -> Vec<Stretch> {
    fn refine(
        line: &dyn LineField,
        (from, to): (f64, f64),
        halvings: u32,
        matters: &dyn Fn(&LineModel) -> bool,
        out: &mut Vec<Stretch>,
    ) {
        let Some(model) = line.between(from, to) else { return };
        let rough = model.field_error > 1e3 * rounding(&model.field);
        if rough && halvings > 0 && matters(&model) {
            let middle = 0.5 * (from + to);
            refine(line, (from, middle), halvings - 1, matters, out);
            refine(line, (middle, to), halvings - 1, matters, out);
        } else {
            out.push((from, to, model));
        }
    }
    let (mut breakpoints, mut out) = (Vec::new(), Vec::new());
    line.breakpoints(&mut breakpoints);
    for w in breakpoints.windows(2).filter(|w| w[1] > w[0]) {
        refine(line, (w[0], w[1]), halvings, matters, &mut out);
    }
    out
}

/// Rounding of a polynomial's value.
fn rounding(p: &Poly) -> f64 {
    4.0 * f64::EPSILON * (p.coefficients()[0].abs() + p.spread(1.0))
}

/// The largest (`sign` = 1) or smallest (−1) value; of equals the nearest. `None` where all is vacuum.
pub fn extreme(line: &dyn LineField, sign: f64) -> Option<Pick> {
    let mut best: Option<Pick> = None;
    let (mut error, mut certain) = (0.0f64, true);
    let mut turns = Vec::new();
    for (from, to, model) in stretches(line, HALVINGS, &|_| true) {
        // The error of the field is one for all: the true extreme lies in no stretch beyond its own error.
        error = error.max(model.field_error + rounding(&model.field));
        certain &= model.certain;
        // Bounded by its coefficients: most stretches cannot hold the extreme.
        let reach = sign * model.field.coefficients()[0] + model.field.spread(1.0);
        if best.is_some_and(|b| sign * b.value >= reach) {
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
                best = Some(Pick { value, error, certain, s });
            }
        }
    }
    best.map(|b| Pick { error, certain, ..b })
}

/// The mean over the part that is not vacuum.
pub fn average(line: &dyn LineField) -> Option<Pick> {
    let (mut sum, mut length, mut doubt, mut size, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let mut certain = true;
    for (from, to, model) in stretches(line, HALVINGS, &|_| true) {
        let half = 0.5 * (to - from);
        let part = half * model.field.integral();
        sum += part;
        size += part.abs() + 2.0 * half * rounding(&model.field);
        length += to - from;
        doubt += (to - from) * (model.field_error + rounding(&model.field));
        certain &= model.certain;
        count += 1.0;
    }
    let error = (doubt + f64::EPSILON * count * size) / length;
    (length > 0.0).then(|| Pick { value: sum / length, error, certain, s: f64::INFINITY })
}

/// A first crossing.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Where along the ray.
    pub s: f64,
    /// The value there: the threshold, or more at an entry.
    pub value: f64,
    /// World gradient there, if the line has one.
    pub gradient: Option<[f64; 3]>,
    /// How far the shaded normal may be turned by errors of place and gradient.
    pub turn: f64,
}

/// What is known about a first crossing.
#[derive(Clone, Copy, Debug)]
pub struct First {
    /// The crossing, if there is one.
    pub hit: Option<Hit>,
    /// False if the field comes so close to the threshold that rounding decides whether it is reached, or a field without
    /// bounds was asked.
    pub certain: bool,
}

/// The first point where the field is at least `threshold`.
pub fn first(line: &dyn LineField, threshold: f64) -> First {
    let mut certain = true;
    let mut roots = Vec::new();
    let near = |m: &LineModel| (m.field.coefficients()[0] - threshold).abs() <= m.field.spread(1.0) + m.field_error;
    for (from, to, model) in stretches(line, HALVINGS_NEAR, &near) {
        certain &= model.certain;
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let p = &model.field;
        let doubt = model.field_error + rounding(p);
        let doubt = if p.is_constant() && model.field_error == 0.0 { 0.0 } else { doubt };
        if p.coefficients()[0] + p.spread(1.0) + doubt < threshold {
            continue;
        }
        roots.clear();
        if p.at(-1.0) >= threshold {
            roots.push(-1.0);
        } else {
            crossings(p, &[threshold], &mut roots);
            // Of the points near a touch only those that reach it.
            roots.retain(|&t| p.at(t) >= threshold - doubt);
        }
        let Some(t) = roots.iter().copied().reduce(f64::min) else {
            // Not reached: surely?
            let highest = extreme_of(p);
            certain &= highest + doubt < threshold || doubt == 0.0;
            continue;
        };
        let slope = p.derivative().at(t);
        // A crossing at a slope is sure; one at a touch is not.
        let place = if t > -1.0 { doubt / slope.abs() } else { 0.0 };
        certain &= place < 1e-6;
        let gradient = model.gradient.map(|g| g.map(|p| p.at(t)));
        let turn = model.gradient.map_or(0.0, |g| {
            let size = g.iter().map(|p| p.at(t).powi(2)).sum::<f64>().sqrt();
            let drift: f64 = g.iter().map(|p| p.derivative().at(t).abs() * place.min(1.0)).sum();
            if size > 0.0 { 2.0 * (drift + model.gradient_error) / size } else { 0.0 }
        });
        let value = if t == -1.0 { p.at(t) } else { threshold };
        return First { hit: Some(Hit { s: middle + half * t, value, gradient, turn }), certain };
    }
    First { hit: None, certain }
}

fn extreme_of(p: &Poly) -> f64 {
    let mut turns = vec![-1.0, 1.0];
    crossings(&p.derivative(), &[0.0], &mut turns);
    turns.into_iter().map(|t| p.at(t)).fold(f64::NEG_INFINITY, f64::max)
}

impl First {
    /// The pixel (c, 1), shaded if shading is on; (0, 0, 0, 0) without a hit.
    pub fn pixel(&self, optics: &Optics<'_>) -> ([f64; 4], Certainty) {
        let brightest = optics.brightest_surface().max(1.0);
        let doubt = if self.certain { 4.0 * f64::EPSILON * brightest } else { brightest };
        let Some(hit) = self.hit else { return ([0.0; 4], Certainty::Bound(doubt)) };
        let mut color = optics.transfer.at(hit.value).color;
        let mut error = doubt;
        if let (Some((shading, ray)), Some(g)) = (&optics.shading, hit.gradient) {
            let (factor, added) = ray.reflect(g);
            color = std::array::from_fn(|c| color[c] * factor[c] + added[c]);
            error += hit.turn.min(1.0) * (shading.diffuse + shading.specular * shading.power.max(1.0)) * brightest;
        }
        ([color[0], color[1], color[2], 1.0], Certainty::Bound(error))
    }
}
