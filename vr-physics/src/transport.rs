//! The equation of transfer along one ray: emission and absorption, with a bound on the result's own error.
//!
//! The ray is cut where the field is not smooth (cell faces), where it crosses a knot of the transfer function, and, shaded,
//! where a light goes behind the horizon. Each piece is a [`Leaf`]: integrated if its a-priori bound fits its share of the
//! tolerance, else halved.

use vr_core::transfer::Segment;

use crate::crossings::crossings;
use crate::leaf::{Gain, Leaf, Whole};
use crate::line::{LineField, LineModel};
use crate::optics::Optics;
use crate::poly::Poly;

/// Light that leaves a ray at its front, and how deep the ray is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transport {
    /// Radiance ∫ q e^(−τ) ds.
    pub radiance: [f64; 3],
    /// Optical depth τ; +∞ behind a wall.
    pub depth: f64,
    /// Distance along the ray at which 1 − e^(−τ) reaches ½; +∞ if it does not.
    pub half_way: f64,
    /// How far radiance and opacity may be from the truth.
    pub certainty: Certainty,
    /// Stretches integrated.
    pub pieces: u64,
}

/// How far a number may be from the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Certainty {
    /// No farther than this.
    Bound(f64),
    /// About so far: somebody (a field, a model) had no bound to offer.
    Estimate(f64),
}

impl Certainty {
    /// The number, bound or not.
    pub fn value(self) -> f64 {
        match self {
            Self::Bound(e) | Self::Estimate(e) => e,
        }
    }

    pub(crate) fn new(error: f64, certain: bool) -> Self {
        if certain { Self::Bound(error) } else { Self::Estimate(error) }
    }

    /// Of a sum or a mean of two results, the error being at most `error`.
    pub(crate) fn and(self, other: Self, error: f64) -> Self {
        Self::new(error, matches!((self, other), (Self::Bound(_), Self::Bound(_))))
    }
}

impl Transport {
    /// Opacity 1 − e^(−τ).
    pub fn opacity(&self) -> f64 {
        -libm::expm1(-self.depth)
    }

    /// Transmittance e^(−τ).
    pub fn transmittance(&self) -> f64 {
        libm::exp(-self.depth)
    }

    /// The radiance that leaves the front if `incoming` enters at the back: the boundary condition I₀.
    pub fn with_incoming(&self, incoming: [f64; 3]) -> [f64; 3] {
        let t = self.transmittance();
        std::array::from_fn(|c| self.radiance[c] + t * incoming[c])
    }
}

/// Integrates along a line to an absolute tolerance (relative to the ray's own radiance where that is above 1).
///
/// `level` cuts the integral where the opacity reaches it (1: never).
pub fn transport(line: &dyn LineField, optics: &Optics<'_>, tolerance: f64, level: f64) -> Transport {
    let mut breakpoints = Vec::with_capacity(64);
    line.breakpoints(&mut breakpoints);
    let length = match (breakpoints.first(), breakpoints.last()) {
        (Some(a), Some(b)) if b > a => b - a,
        _ => 1.0,
    };
    let surface = optics.brightest_surface();
    let emission = optics.brightest_emission();
    let mut walk = Walk {
        optics,
        tolerance,
        length,
        end: breakpoints.last().copied().unwrap_or(0.0),
        surface,
        emission,
        deepest: if level < 1.0 { -libm::log1p(-level) } else { f64::INFINITY },
        result: Transport {
            radiance: [0.0; 3],
            depth: 0.0,
            half_way: f64::INFINITY,
            certainty: Certainty::Bound(0.0),
            pieces: 0,
        },
        light_error: 0.0,
        depth_error: 0.0,
        certain: true,
        pending_wall: 0.0,
        splits: 0,
        ended: false,
        cuts: Vec::new(),
        values: Vec::new(),
    };
    for pair in breakpoints.windows(2) {
        if walk.ended {
            break;
        }
        if pair[1] > pair[0] {
            walk.stretch(line, pair[0], pair[1], 0);
        }
    }
    walk.finish(level)
}

/// ln 2: the depth of opacity ½.
const HALF_DEPTH: f64 = std::f64::consts::LN_2;
/// Halvings after which a stretch is enclosed crudely instead: 2⁻⁶⁰ of a cell.
const MOST_HALVINGS: u32 = 60;
/// Halvings of all stretches of one ray together: no scene may hang the reference.
const MOST_SPLITS: u64 = 1 << 18;
/// Halvings that may be spent on a field which is only known roughly.
const FIELD_HALVINGS: u32 = 8;

struct Walk<'a> {
    optics: &'a Optics<'a>,
    tolerance: f64,
    length: f64,
    end: f64,
    /// Largest light of a surface, and largest emission per unit.
    surface: f64,
    emission: f64,
    /// Optical depth to stop at.
    deepest: f64,
    result: Transport,
    light_error: f64,
    depth_error: f64,
    certain: bool,
    /// What it costs if the value of a wall, just passed within the field's error, was reached without being seen.
    pending_wall: f64,
    /// Halvings so far.
    splits: u64,
    ended: bool,
    cuts: Vec<f64>,
    values: Vec<f64>,
}

impl Walk<'_> {
    /// A stretch between breakpoints.
    fn stretch(&mut self, line: &dyn LineField, from: f64, to: f64, halvings: u32) {
        let Some(model) = line.between(from, to) else { return };
        let clear = |s: &Segment| s.is_clear();
        let value = model.field.coefficients()[0];
        let reach = model.field.spread(1.0) + model.field_error;
        let (low, high) = (value - reach, value + reach);
        // Most of a typical scan is air: nothing to do there.
        let t = self.optics.transfer;
        let first = t.segments().partition_point(|s| s.to <= low);
        let last = t.segments().partition_point(|s| s.from <= high).max(first + 1);
        if t.segments()[first..last.min(t.segments().len())].iter().all(clear) {
            return;
        }
        // A field known only roughly is asked again for halves, as long as that helps and its error matters.
        let rough = 1e3 * f64::EPSILON * (value.abs() + model.field.spread(1.0));
        if model.field_error > rough && halvings < FIELD_HALVINGS {
            let steep = self.steepness(low, high);
            let share = self.tolerance * (to - from) / self.length;
            if (to - from) * steep * model.field_error > share {
                let middle = 0.5 * (from + to);
                self.stretch(line, from, middle, halvings + 1);
                if !self.ended {
                    self.stretch(line, middle, to, halvings + 1);
                }
                return;
            }
        }
        self.certain &= model.certain;
        self.cut(&model);
        let cuts = std::mem::take(&mut self.cuts);
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let whole = cuts.len() == 2;
        for pair in cuts.windows(2) {
            if self.ended {
                break;
            }
            let part = if whole { model } else { model.restricted(pair[0], pair[1]) };
            let s = middle + half * pair[0];
            self.part(&part, s, 0.5 * half * (pair[1] - pair[0]), 0, None);
        }
        self.cuts = cuts;
    }

    /// How steep κ and the emission are at most, per unit of value, where the field may be (1 − α is kept off 0 by its error).
    fn steepness(&self, low: f64, high: f64) -> f64 {
        let t = self.optics.transfer;
        let unit = t.unit_distance();
        let in_range =
            t.segments().iter().filter(|s| s.to >= low && s.from <= high && s.from.is_finite() && s.to.is_finite());
        in_range
            .map(|s| {
                let span = s.to - s.from;
                let alpha = (s.end.opacity - s.start.opacity).abs() / span;
                let least =
                    if self.optics.has_walls() { (1.0 - s.start.opacity.max(s.end.opacity)).max(1e-3) } else { 1.0 };
                let shine = (0..3).map(|c| (s.end.emission[c] - s.start.emission[c]).abs()).fold(0.0, f64::max) / span;
                (alpha / (unit * least)).max(shine)
            })
            .fold(0.0, f64::max)
    }

    /// Fills `cuts` with the ends of the smooth parts of [−1, 1].
    fn cut(&mut self, model: &LineModel) {
        self.cuts.clear();
        self.values.clear();
        self.values.extend_from_slice(&self.optics.kinks);
        if !self.optics.jumps.is_empty() {
            // The field's error makes the place of a jump uncertain: the part between is looked at on its own.
            let band = band(model);
            self.values.extend(self.optics.jumps.iter().flat_map(|&v| [v - band, v + band]));
            self.values.sort_by(f64::total_cmp);
        }
        crossings(&model.field, &self.values, &mut self.cuts);
        if let (Some((shading, ray)), Some(g)) = (&self.optics.shading, &model.gradient) {
            for light in &ray.lights {
                for v in [light.to_light, light.half] {
                    let towards: Poly = g[0] * v[0] + g[1] * v[1] + g[2] * v[2];
                    crossings(&towards, &[0.0], &mut self.cuts);
                }
            }
            if !shading.gradient_opacity.is_empty() {
                let square = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
                let knots: Vec<f64> = shading.gradient_opacity.iter().map(|p| p.0 * p.0).collect();
                crossings(&square, &knots, &mut self.cuts);
            }
        }
        self.cuts.push(-1.0);
        self.cuts.push(1.0);
        self.cuts.sort_by(f64::total_cmp);
        self.cuts.dedup();
    }

    /// A part in one segment of the transfer function, starting at `s`.
    fn part(&mut self, model: &LineModel, s: f64, half: f64, halvings: u32, whole: Option<Whole>) {
        let value = model.field.at(0.0);
        let in_front = libm::exp(-self.result.depth);
        let optics = self.optics;
        let mut segment = optics.transfer.segment_at(value);
        // Between the two sides of a jump nobody knows which one holds.
        let band = band(model);
        let jump = optics.jumps.iter().copied().find(|v| band > 0.0 && (v - value).abs() <= band);
        if let Some(v) = jump {
            let below = optics.transfer.segment_at(v - 2.0 * band - f64::MIN_POSITIVE);
            let above = optics.transfer.segment_at(v + 2.0 * band);
            segment = self.doubtful(model, below, above, half, in_front);
        }
        // A constant field on a value where α only touches 1 has α = 1 over a length, too.
        let opaque = segment.is_opaque() || model.field.is_constant() && segment.at(value).opacity == 1.0;
        let is_wall = opaque && optics.has_walls() && !self.is_modulated();
        if jump.is_none() && !is_wall {
            self.touched_wall();
        }
        if segment.is_clear() {
            return;
        }
        if is_wall {
            self.wall(model, segment, s, in_front);
            return;
        }
        let scale = self.result.radiance.into_iter().fold(1.0, f64::max);
        let budget = self.tolerance * scale / in_front.max(1e-300);
        let share = budget * (2.0 * half / self.length);
        let light = self.surface.max(self.emission * (self.end - s)).max(1.0);
        let leaf = Leaf::new(optics, segment, model, half);
        let (light_share, depth_share) = (0.25 * share, 0.25 * share / light);
        let Some(choice) = leaf.choose(light_share, depth_share) else {
            let whole = whole.unwrap_or_else(|| Whole { half, clearest: leaf.clearest() });
            let gain = leaf.enclosed(whole);
            // Where the field's own error covers all of 1 − α, halving does not help.
            let lost = leaf.is_lost() || halvings >= MOST_HALVINGS || self.splits >= MOST_SPLITS;
            if lost || gain.light_error + gain.depth_error * light <= 1e-3 * budget {
                self.add(gain, in_front);
                return;
            }
            self.halve(model, s, half, halvings, Some(whole));
            return;
        };
        let (gain, rule, tau) = leaf.integrate(&choice);
        if self.result.depth + gain.depth > self.deepest {
            // The level is reached in here: the end is found by halving.
            if gain.depth <= 1e-15 * (1.0 + self.deepest) || halvings >= MOST_HALVINGS {
                self.ended = true;
            } else {
                self.halve(model, s, half, halvings, whole);
            }
            return;
        }
        if self.result.half_way == f64::INFINITY && self.result.depth + gain.depth >= HALF_DEPTH {
            let wanted = HALF_DEPTH - self.result.depth;
            let (mut a, mut b) = (-1.0, 1.0);
            for _ in 0..52 {
                let t = 0.5 * (a + b);
                if rule.interpolate(&tau, t) < wanted { a = t } else { b = t }
            }
            self.result.half_way = s + half * (1.0 + a);
        }
        self.add(gain, in_front);
        // What lies behind cannot be seen any more.
        let rest = libm::exp(-self.result.depth) * self.surface.max(1.0).max(self.emission * (self.end - s));
        if rest <= 0.02 * self.tolerance * scale {
            self.light_error += rest;
            self.ended = true;
        }
    }

    fn is_modulated(&self) -> bool {
        self.optics.shading.as_ref().is_some_and(|(s, _)| !s.gradient_opacity.is_empty())
    }

    fn halve(&mut self, model: &LineModel, s: f64, half: f64, halvings: u32, whole: Option<Whole>) {
        self.splits += 1;
        self.part(&model.restricted(-1.0, 0.0), s, 0.5 * half, halvings + 1, whole);
        if !self.ended {
            self.part(&model.restricted(0.0, 1.0), s + half, 0.5 * half, halvings + 1, whole);
        }
    }

    /// A part on which it is not known which side of a jump holds: takes one that is no wall, and notes what that may cost.
    fn doubtful<'s>(
        &mut self,
        model: &LineModel,
        below: &'s Segment,
        above: &'s Segment,
        half: f64,
        in_front: f64,
    ) -> &'s Segment {
        let wall = |s: &Segment| s.is_opaque() && self.optics.has_walls();
        let (a, b) = (wall(below), wall(above));
        let bright = self.surface.max(self.emission * (self.end.max(0.0) + self.length)).max(1.0);
        if a != b {
            self.pending_wall = 2.0 * in_front * bright;
        }
        let taken = if a { above } else { below };
        let value = model.field.at(0.0);
        let kappa = |s: &Segment| self.optics.transfer.extinction(s.at(value).opacity.min(1.0 - 1e-12));
        let shine = |s: &Segment| s.at(value).emission.into_iter().fold(0.0, f64::max);
        let other = if a { below } else { above };
        let depth = 2.0 * half * if wall(other) { kappa(taken) } else { (kappa(below) - kappa(above)).abs() };
        self.depth_error += depth;
        let color = (0..3).map(|c| (below.at(value).color[c] - above.at(value).color[c]).abs()).fold(0.0, f64::max);
        let deep = 2.0 * half * kappa(below).max(kappa(above));
        self.light_error +=
            in_front * (bright * depth + color * deep.min(1.0) + 2.0 * half * (shine(below) - shine(above)).abs());
        taken
    }

    /// A wall was touched within the field's error, and not entered: it may or may not be there.
    fn touched_wall(&mut self) {
        if self.pending_wall > 0.0 {
            self.light_error += self.pending_wall;
            self.depth_error = f64::INFINITY;
            self.pending_wall = 0.0;
        }
    }

    /// Opacity 1 over a length: the colour at the point of entry, and the ray ends.
    fn wall(&mut self, model: &LineModel, segment: &Segment, s: f64, in_front: f64) {
        self.pending_wall = 0.0;
        let value = model.field.at(-1.0);
        let transfer = self.optics.transfer;
        // Up to the level, if there is one.
        let share = if self.deepest.is_finite() { (in_front - libm::exp(-self.deepest)).max(0.0) } else { in_front };
        let mut light = [0.0; 3];
        let mut off = 0.0;
        if !transfer.has_emission() {
            light = segment.at(value).color;
            let slope = if segment.to.is_finite() && segment.from.is_finite() {
                (0..3).map(|c| (segment.end.color[c] - segment.start.color[c]).abs()).fold(0.0, f64::max)
                    / (segment.to - segment.from)
            } else {
                0.0
            };
            off = slope * model.field_error;
            if let (Some((shading, ray)), Some(g)) = (&self.optics.shading, &model.gradient) {
                let gradient = g.map(|p| p.at(-1.0));
                let (factor, added) = ray.reflect(gradient);
                light = std::array::from_fn(|c| light[c] * factor[c] + added[c]);
                let size = gradient.iter().map(|x| x * x).sum::<f64>().sqrt();
                if size > 0.0 {
                    let sensitivity = shading.diffuse + shading.specular * shading.power;
                    let turn = 2.0
                        * (model.gradient_error + 4.0 * f64::EPSILON * g.iter().map(|p| p.spread(1.0)).sum::<f64>())
                        / size;
                    off += sensitivity.max(1.0) * turn.min(1.0) * self.surface;
                }
            }
        }
        for c in 0..3 {
            self.result.radiance[c] += share * light[c];
        }
        self.light_error += share * (off + self.surface * self.doubt());
        if self.result.half_way == f64::INFINITY {
            self.result.half_way = s;
        }
        self.result.depth = f64::INFINITY;
        self.result.pieces += 1;
        // The depth is infinite whatever was in front; what was doubtful there is in the light's error.
        self.depth_error = if self.depth_error == f64::INFINITY { f64::INFINITY } else { 0.0 };
        self.ended = true;
    }

    /// How far the transmittance in front may be off, relative to itself (at most all of it).
    fn doubt(&self) -> f64 {
        if self.depth_error < 1.0 { libm::expm1(self.depth_error) } else { self.depth_error }.min(1e3)
    }

    fn add(&mut self, gain: Gain, in_front: f64) {
        let doubt = self.doubt();
        let mut brightest = 0.0f64;
        for c in 0..3 {
            let light = in_front * gain.light[c];
            self.result.radiance[c] += light;
            brightest = brightest.max(light.abs());
        }
        let radiance = self.result.radiance.into_iter().fold(0.0, f64::max);
        self.light_error += in_front * gain.light_error + brightest * doubt + f64::EPSILON * (radiance + brightest);
        self.result.depth += gain.depth;
        self.depth_error += gain.depth_error + f64::EPSILON * self.result.depth;
        self.result.pieces += 1;
    }

    fn finish(mut self, level: f64) -> Transport {
        self.touched_wall();
        let reached = self.result.depth == f64::INFINITY
            || (self.ended && self.deepest.is_finite() && self.result.depth >= self.deepest * (1.0 - 1e-9));
        if level < 1.0 && reached {
            self.result.depth = self.deepest;
        }
        let transmittance = self.result.transmittance();
        let mut opacity_error = transmittance * self.doubt();
        if self.depth_error == f64::INFINITY {
            opacity_error = 1.0;
        }
        if self.ended && level >= 1.0 {
            // Whatever was left out behind can only have darkened.
            opacity_error = opacity_error.max(transmittance);
        }
        let error = self.light_error.max(opacity_error.min(1.0)) + 2.0 * f64::EPSILON;
        self.result.certainty = Certainty::new(error, self.certain);
        self.result
    }
}

/// Half the width in value within which a jump's place is uncertain.
fn band(model: &LineModel) -> f64 {
    if model.field.is_constant() && model.field_error == 0.0 {
        return 0.0;
    }
    4.0 * model.field_error + 8.0 * f64::EPSILON * (model.field.coefficients()[0].abs() + model.field.spread(1.0))
}
