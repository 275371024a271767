//! The first point of a ray where the field reaches a value.

use vr_core::bound::Bound;
use vr_core::field::{FieldLine, LineModel, Poly};

use crate::crossings::crossings;
use crate::optics::Optics;
use crate::picked_color::PickedColor;
use crate::transport::Certainty;
use crate::value_operators::{HALVINGS_NEAR, Stretch, rounding, stretches};

/// A first crossing.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance along the ray.
    pub s: f64,
    /// The value there: the threshold, or more at an entry.
    pub value: f64,
    /// Upper bound of the error of `value`: of a crossing none, for there it is the threshold.
    pub error: f64,
    /// Colour of the place, white where it has none of its own.
    pub color: PickedColor,
    /// World gradient there, if the line has one.
    pub gradient: Option<[f64; 3]>,
    /// Upper bound of the error of each of the gradient's components, that of the hit's place included.
    pub gradient_error: f64,
}

/// Result of the search for a first crossing.
#[derive(Clone, Copy, Debug)]
pub struct First {
    /// The crossing, if there is one.
    pub hit: Option<Hit>,
    /// False if the field comes so close to the threshold that rounding decides whether it is reached, or a field without
    /// bounds was asked.
    pub certain: bool,
}

/// Largest error of a crossing's place, as a part of half a stretch, at which it is still taken for certain.
const MAX_PLACE: f64 = 1e-6;

/// The first point where the field is at least `threshold`.
pub fn first(line: &dyn FieldLine, threshold: f64) -> First {
    let mut certain = true;
    // The value where the last stretch ended, and where that is.
    let mut before: Option<(f64, f64)> = None;
    let near = |m: &LineModel| Bound::new(m.field.coefficients()[0] - threshold) <= m.error() + m.field.spread(1.0);
    for stretch in stretches(line, HALVINGS_NEAR, &near) {
        let Stretch { from, to, model, .. } = &stretch;
        certain &= model.certain;
        let p = &model.field;
        let doubt = stretch.doubt();
        certain &= doubt.is_finite();
        let continuous = before.is_some_and(|(s, v)| s == *from && Bound::new(v - p.at(-1.0)) <= doubt * 4.0);
        before = Some((*to, p.at(1.0)));
        if doubt + (p.coefficients()[0] + p.spread(1.0) - threshold).max(0.0) == Bound::ZERO {
            // Constant, and at the threshold or below.
            if p.at(0.0) < threshold {
                continue;
            }
        } else if p.coefficients()[0] + p.spread(1.0) + doubt.value() < threshold {
            continue;
        }
        let reach = Reach { p, doubt, threshold };
        let found = reach.search(&mut certain);
        let Some(t) = found else { continue };
        certain &= stretch.exists();
        let entered = t == -1.0 && !continuous;
        let place = if doubt == Bound::ZERO || entered { Bound::ZERO } else { reach.place(t) };
        certain &= place.within(MAX_PLACE);
        let value = if entered { p.at(t) } else { threshold };
        let error = if entered { doubt } else { Bound::ZERO };
        let gradient = model.gradient.map(|g| g.map(|p| p.at(t)));
        let moved = place + (stretch.misplaced[0] / (0.5 * (to - from)));
        let color = line.color(*from, *to).map_or(PickedColor::WHITE, |color| PickedColor::at(&color, t, moved));
        let gradient_error = model.gradient.map_or(Bound::ZERO, |g| {
            let drift = |p: &Poly| {
                let slope = p.derivative();
                let steepest = Bound::new(slope.at(0.0)) + slope.spread(1.0);
                let moved =
                    if steepest == Bound::ZERO || moved == Bound::ZERO { Bound::ZERO } else { steepest * moved };
                moved + rounding(p)
            };
            let constant_zero = g.iter().all(|p| p.is_constant() && p.at(0.0) == 0.0);
            let drifts = g.iter().map(drift).fold(Bound::ZERO, Bound::max);
            if constant_zero { model.slope_error() } else { model.slope_error() + drifts }
        });
        let s = 0.5 * (from + to) + 0.5 * (to - from) * t;
        let hit = Hit { s, value, error: error.value(), color, gradient, gradient_error: gradient_error.value() };
        return First { hit: Some(hit), certain };
    }
    First { hit: None, certain }
}

/// The search for a threshold on a stretch.
struct Reach<'a> {
    p: &'a Poly,
    doubt: Bound,
    threshold: f64,
}

impl Reach<'_> {
    /// The first t at which the threshold is reached, if it is. `certain` becomes false if an error of `doubt` could change that.
    fn search(&self, certain: &mut bool) -> Option<f64> {
        let Self { p, doubt, threshold } = *self;
        let at_front = p.at(-1.0);
        let close = |v: f64| doubt > Bound::ZERO && Bound::new(v - threshold) <= doubt;
        // Just at the threshold, it is reached at once if the field rises.
        *certain &= !close(at_front) || p.derivative().at(-1.0) > 0.0 && self.place(-1.0).within(MAX_PLACE);
        if at_front >= threshold {
            return Some(-1.0);
        }
        let mut roots = Vec::new();
        crossings(p, &[threshold], &mut roots);
        // Of the points near a touch only those that reach it.
        roots.retain(|&t| Bound::new((threshold - p.at(t)).max(0.0)) <= doubt);
        let mut turns = Vec::new();
        crossings(&p.derivative(), &[0.0], &mut turns);
        let first = roots.iter().copied().reduce(f64::min);
        // A crest in front of it, or an end where nothing is reached, must stay below.
        let before = turns.into_iter().filter(|&t| first.is_none_or(|r| t < r));
        let open_end = if first.is_none() { Some(1.0) } else { None };
        let crests = before.chain(open_end);
        *certain &= !crests.into_iter().any(|t| close(p.at(t)));
        first
    }

    /// Bound on the distance of the crossing from t: the error over the slope, if the slope is nearly constant.
    fn place(&self, t: f64) -> Bound {
        let slope = self.p.derivative();
        let place = self.doubt / slope.at(t);
        let bend = slope.derivative();
        let bend = Bound::new(bend.at(0.0)) + bend.spread(1.0);
        if place == Bound::ZERO || (place * bend).within(0.5 * slope.at(t).abs()) {
            place * 2.0
        } else {
            Bound::UNKNOWN
        }
    }
}

impl First {
    /// The pixel (c, 1), shaded if shading is on; (0, 0, 0, 0) without a hit.
    pub fn pixel(&self, optics: &Optics<'_>) -> ([f64; 4], Certainty) {
        let brightest = optics.brightest_first().max(1.0);
        let doubt = Bound::new(if self.certain { 8.0 * f64::EPSILON * brightest } else { brightest });
        let Some(hit) = self.hit else { return ([0.0; 4], Certainty::new(doubt, true)) };
        let mut color = optics.transfer.at(hit.value).color;
        let mut error = doubt + optics.color_error(hit.value, Bound::new(hit.error));
        if hit.color != PickedColor::WHITE {
            error += Bound::new(hit.color.error) * optics.transfer.brightest_color();
            color = std::array::from_fn(|c| color[c] * hit.color.rgb[c]);
        }
        if let (Some((shading, ray)), Some(g)) = (&optics.shading, hit.gradient) {
            let (factor, added) = ray.reflect(g);
            color = std::array::from_fn(|c| color[c] * factor[c] + added[c]);
            error = error * optics.largest_color_factor() + optics.shaded_error(g, Bound::new(hit.gradient_error));
            error += 16.0 * f64::EPSILON * (1.0 + shading.power) * brightest;
        }
        ([color[0], color[1], color[2], 1.0], Certainty::new(error.min(brightest), true))
    }
}
