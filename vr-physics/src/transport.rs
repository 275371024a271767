//! The equation of transfer along one ray: emission and absorption, with a bound on the result's own error.
//!
//! The ray is cut where the field is not smooth (cell faces), where it crosses a knot of the transfer function, and, shaded,
//! where a light goes behind the horizon. Each piece is a [`Leaf`]: integrated if its a-priori bound fits its share of the
//! tolerance, else halved.

use vr_core::bound::{Bound, largest};
use vr_core::cancel::{self, SparsePoll};
use vr_core::field::{FieldLine, LineColor, LineModel, Poly};
use vr_core::transfer::Segment;

use crate::crossings::crossings;
use crate::leaf::{Gain, Leaf, Whole};
use crate::optics::Optics;

/// Light that leaves a ray at its front, and how deep the ray is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transport {
    /// Radiance ∫ q e^(−τ) ds.
    pub radiance: [f64; 3],
    /// Optical depth τ; +∞ behind a wall.
    pub depth: f64,
    /// Distance along the ray at which 1 − e^(−τ) reaches ½; +∞ if it does not.
    pub half_way: f64,
    /// Bound or estimate of the error of radiance and opacity.
    pub certainty: Certainty,
    /// Stretches integrated.
    pub pieces: u64,
}

/// The error of a number: a bound, or an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Certainty {
    /// The error is at most this.
    Bound(f64),
    /// The error is about this: a field or a model has no bound to offer.
    Estimate(f64),
}

impl Certainty {
    /// The number, bound or not.
    pub fn value(self) -> f64 {
        match self {
            Self::Bound(e) | Self::Estimate(e) => e,
        }
    }

    /// Makes it of an error, never NaN: an unknown error is infinite.
    pub(crate) fn new(error: impl Into<Bound>, certain: bool) -> Self {
        let error = error.into().value();
        if certain { Self::Bound(error) } else { Self::Estimate(error) }
    }

    /// The certainty of a sum or a mean of two results, the error being at most `error`.
    pub(crate) fn and(self, other: Self, error: impl Into<Bound>) -> Self {
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
pub fn transport(line: &dyn FieldLine, optics: &Optics<'_>, tolerance: f64, level: f64) -> Transport {
    // Short rays make few turns, and there may be many of them.
    cancel::poll();
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
        light_error: Bound::ZERO,
        depth_error: Bound::ZERO,
        certain: true,
        pending_wall: Bound::ZERO,
        splits: 0,
        ended: false,
        level_reached: false,
        cuts: Vec::new(),
        values: Vec::new(),
    };
    let mut poll = SparsePoll::default();
    for (i, pair) in breakpoints.windows(2).enumerate() {
        if walk.ended {
            break;
        }
        poll.turn();
        walk.edge(line, &breakpoints, i);
        if pair[1] > pair[0] {
            walk.stretch(line, pair[0], pair[1], 0);
        }
    }
    if !walk.ended {
        walk.edge(line, &breakpoints, breakpoints.len().saturating_sub(1));
    }
    walk.finish(level)
}

/// ln 2: the depth of opacity ½.
pub(crate) const HALF_DEPTH: f64 = std::f64::consts::LN_2;
/// Number of halvings after which a stretch is enclosed crudely instead: 2⁻⁶⁰ of a cell.
const MAX_HALVINGS: u32 = 60;
/// A stretch shorter than this part of the ray is a sliver.
const SLIVER: f64 = 1e-6;
/// Largest number of halvings of a stretch for the sake of its rounding: errors fall with its length.
const MAX_GRADED: u32 = 20;
/// Largest number of halvings of all stretches of one ray together: no scene may hang the reference.
const MAX_SPLITS: u64 = 1 << 18;
/// Largest number of halvings that are spent on a field which is only known roughly.
const FIELD_HALVINGS: u32 = 8;

/// The field on a part of a ray, and the colour of its places where they have one.
pub(crate) type Place<'a> = (&'a LineModel, Option<&'a LineColor>);

/// The light of a ray so far.
pub(crate) struct Walk<'a> {
    pub(crate) optics: &'a Optics<'a>,
    tolerance: f64,
    pub(crate) length: f64,
    pub(crate) end: f64,
    /// Largest light of a surface, and largest emission per unit.
    pub(crate) surface: f64,
    pub(crate) emission: f64,
    /// Optical depth to stop at.
    pub(crate) deepest: f64,
    pub(crate) result: Transport,
    pub(crate) light_error: Bound,
    pub(crate) depth_error: Bound,
    certain: bool,
    /// Error that it makes if the value of a wall, just passed within the field's error, was reached unseen.
    pub(crate) pending_wall: Bound,
    /// Halvings so far.
    splits: u64,
    pub(crate) ended: bool,
    /// True once the opacity to stop at is reached.
    pub(crate) level_reached: bool,
    cuts: Vec<f64>,
    values: Vec<f64>,
}

impl Walk<'_> {
    /// A stretch between breakpoints.
    fn stretch(&mut self, line: &dyn FieldLine, from: f64, to: f64, halvings: u32) {
        let Some(model) = line.between(from, to) else { return };
        if !model.field.coefficients().iter().all(|c| c.is_finite()) {
            // Overflow: nothing is known of this ray any more.
            self.light_error = Bound::UNKNOWN;
            self.depth_error = Bound::UNKNOWN;
            return;
        }
        let [low, high] = model.range();
        // Most of a typical scan is air: nothing to do there.
        let touched = self.optics.touching(low, high);
        if touched.iter().all(Segment::is_clear) {
            return;
        }
        // A field known only roughly is asked again for halves, as long as that helps and its error matters.
        let value = model.field.coefficients()[0];
        let rough = 1e3 * f64::EPSILON * (value.abs() + model.field.spread(1.0));
        if !model.error().within(rough) && halvings < FIELD_HALVINGS {
            let share = self.tolerance * (to - from) / self.length;
            let costs = self.steepness(touched) * model.error() * (to - from);
            // Beside a jump the error decides which side holds, however flat both are.
            let jumps = touched.windows(2).any(|s| s[0].end != s[1].start)
                || self.optics.transfer.has_rows() && self.optics.jumps.iter().any(|v| (low..=high).contains(v));
            if jumps || !costs.within(share) {
                let middle = 0.5 * (from + to);
                self.stretch(line, from, middle, halvings + 1);
                if !self.ended {
                    self.stretch(line, middle, to, halvings + 1);
                }
                return;
            }
        }
        self.certain &= model.certain;
        let color = line.color(from, to);
        self.find_cuts(&model);
        let cuts = std::mem::take(&mut self.cuts);
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let whole = cuts.len() == 2;
        // A sliver between two faces says nothing of where its polynomial goes: on a longer way that can be told.
        let longer = (SLIVER * self.length / half).max(1.0);
        let around = if longer > 1.0 { model.field.restricted(-longer, longer) } else { model.field };
        for pair in cuts.windows(2) {
            if self.ended {
                break;
            }
            let part = if whole { model } else { model.restricted(pair[0], pair[1]) };
            let color = if whole { color } else { color.map(|color| color.restricted(pair[0], pair[1])) };
            let s = middle + half * pair[0];
            self.part(
                (&part, color.as_ref()),
                s,
                0.5 * half * (pair[1] - pair[0]),
                0,
                Whole { half: half * longer, field: &around },
            );
        }
        self.cuts = cuts;
    }

    /// Largest slope of κ and of the emission, per unit of value, in some segments (1 − α is kept off 0 by the field's error).
    fn steepness(&self, segments: &[Segment]) -> Bound {
        let unit = self.optics.transfer.unit_distance();
        let finite = self.optics.of_rows(segments).filter(|s| s.from.is_finite() && s.to.is_finite());
        let slopes = finite.map(|s| {
            let span = s.to - s.from;
            let alpha = (s.end.opacity - s.start.opacity).abs() / span;
            let min = if self.optics.has_walls() { (1.0 - s.start.opacity.max(s.end.opacity)).max(1e-3) } else { 1.0 };
            let shine = largest((0..3).map(|c| s.end.emission[c] - s.start.emission[c])) / span;
            Bound::new(alpha / (unit * min)).max(shine)
        });
        slopes.fold(Bound::ZERO, Bound::max)
    }

    /// Fills `cuts` with the ends of the smooth parts of [−1, 1].
    fn find_cuts(&mut self, model: &LineModel) {
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
        if let (Some((_, ray)), Some(g)) = (&self.optics.shading, &model.gradient) {
            for light in &ray.lights {
                for v in [light.to_light, light.half] {
                    let towards: Poly = g[0] * v[0] + g[1] * v[1] + g[2] * v[2];
                    crossings(&towards, &[0.0], &mut self.cuts);
                }
            }
            if !self.optics.magnitudes.is_empty() {
                let square = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
                let knots: Vec<f64> = self.optics.magnitudes.iter().map(|m| m * m).collect();
                crossings(&square, &knots, &mut self.cuts);
            }
        }
        self.cuts.push(-1.0);
        self.cuts.push(1.0);
        self.cuts.sort_by(f64::total_cmp);
        self.cuts.dedup();
    }

    /// A part in one segment of the transfer function, starting at `s`.
    fn part(&mut self, (model, color): Place<'_>, s: f64, half: f64, halvings: u32, whole: Whole<'_>) {
        // The segment of the transfer function that holds.
        let value = model.field.at(0.0);
        let in_front = libm::exp(-self.result.depth);
        let optics = self.optics;
        let mut segment = optics.segment_of(model, value);
        // Between the two sides of a jump the value does not tell which one holds.
        let band = band(model);
        let near = |v: f64| band > 0.0 && Bound::new(band) >= Bound::new(v - value);
        let doubtful = optics.jumps.iter().any(|&v| model.may_be(v) && near(v));
        if doubtful {
            segment = self.doubtful(model, band, half, in_front);
        }
        // A constant field on a value where α only touches 1 has α = 1 over a length, too.
        let opaque = segment.is_opaque() || model.field.is_constant() && segment.at(value).opacity == 1.0;
        let [min, max] = self.modulation(model);
        let is_wall = opaque && optics.has_walls() && min > 0.0;
        if !doubtful && !is_wall {
            self.touched_wall();
        }
        if segment.is_clear() || max == 0.0 && segment.start.emission == [0.0; 3] && segment.end.emission == [0.0; 3] {
            return;
        }
        if optics.transfer.has_rows() && self.rows_are_clear(model, segment) {
            return;
        }
        if is_wall {
            let reach = model.field.spread(1.0);
            if band > 0.0 && [segment.from, segment.to].iter().any(|edge| (edge - value).abs() + reach <= band) {
                // No farther in than the field's error: there may be no wall. If there is one, it goes on in the next part.
                self.pending_wall = self.pending_wall.max(2.0 * in_front * self.brightest());
            } else {
                self.wall((model, color), segment, s, in_front);
            }
            return;
        }
        if opaque && optics.has_walls() && max > 0.0 {
            // The factor on κ may vanish in here: a wall begins where it does not.
            if halvings < MAX_HALVINGS && self.splits < MAX_SPLITS {
                self.halve((model, color), s, half, halvings, whole);
            } else {
                self.pending_wall = self.pending_wall.max(2.0 * in_front * self.brightest());
            }
            return;
        }
        // Integrate if a rule fits the share of the tolerance; else enclose, or halve.
        let scale = self.result.radiance.into_iter().fold(1.0, f64::max);
        let budget = self.tolerance * scale / in_front.max(1e-300);
        let share = budget * (2.0 * half / self.length);
        let light = self.surface.max(self.emission * (self.end - s)).max(1.0);
        let leaf = Leaf::new(optics, segment, (model, color), half);
        let (light_share, depth_share) = (0.25 * share, 0.25 * share / light);
        let Some(choice) = leaf.choose(light_share, depth_share) else {
            let gain = leaf.enclosed(whole);
            // Where the field's own error covers all of 1 − α, halving does not help.
            let lost = leaf.is_lost() || halvings >= MAX_HALVINGS || self.splits >= MAX_SPLITS;
            if lost || (gain.light_error + gain.depth_error * light).within(1e-3 * budget) {
                self.add(gain, in_front, s);
                return;
            }
            self.halve((model, color), s, half, halvings, whole);
            return;
        };
        let (gain, rule, tau) = leaf.integrate(&choice);
        // The value's error is charged as if 1 − α were small throughout: shorter stretches know better where it is.
        let heavy = !gain.light_error.within(share) || !gain.depth_error.within(share / light);
        if heavy && leaf.is_graded() && halvings < MAX_GRADED && self.splits < MAX_SPLITS {
            self.halve((model, color), s, half, halvings, whole);
            return;
        }
        if self.result.depth + gain.depth > self.deepest {
            // The level is reached in here: the end is found by halving.
            if gain.depth <= 1e-15 * (1.0 + self.deepest) || halvings >= MAX_HALVINGS {
                self.reach_level(&gain, s, 2.0 * half, in_front);
            } else {
                self.halve((model, color), s, half, halvings, whole);
            }
            return;
        }
        if self.result.half_way == f64::INFINITY && self.result.depth + gain.depth >= HALF_DEPTH {
            // Opacity ½ is reached in here: bisect for its place.
            let wanted = HALF_DEPTH - self.result.depth;
            let (mut a, mut b) = (-1.0, 1.0);
            for _ in 0..52 {
                let t = 0.5 * (a + b);
                if rule.interpolate(&tau, t) < wanted { a = t } else { b = t }
            }
            self.result.half_way = s + half * (1.0 + a);
        }
        self.add(gain, in_front, s);
        // What lies behind cannot be seen any more.
        let rest = libm::exp(-self.result.depth) * self.surface.max(1.0).max(self.emission * (self.end - s));
        if rest <= 0.02 * self.tolerance * scale {
            self.light_error += rest;
            self.ended = true;
        }
    }

    /// The opacity to stop at is reached at `s`, within a part of hardly any depth.
    fn reach_level(&mut self, gain: &Gain, s: f64, length: f64, in_front: f64) {
        self.level_reached = true;
        self.ended = true;
        self.light_error += in_front * self.surface * gain.depth.min(1.0);
        if self.emission > 0.0 {
            // The place is off by the depth's error over κ, and emission is lost or won on the way there.
            let kappa = gain.depth / length;
            let off = (self.depth_error + gain.depth + self.deepest * f64::EPSILON) * 2.0 / kappa;
            self.light_error += off.min(self.end - s) * (in_front * self.emission);
        }
        // Where the level is ½ itself, that is half way.
        if self.deepest >= HALF_DEPTH * (1.0 - 4.0 * f64::EPSILON) && self.result.half_way == f64::INFINITY {
            self.result.half_way = s;
        }
    }

    /// Largest light that can still come.
    pub(crate) fn brightest(&self) -> f64 {
        self.surface.max(self.emission * (self.end.max(0.0) + self.length)).max(1.0)
    }

    fn halve(&mut self, (model, color): Place<'_>, s: f64, half: f64, halvings: u32, whole: Whole<'_>) {
        self.splits += 1;
        cancel::poll();
        let [near, far] = [(-1.0, 0.0), (0.0, 1.0)].map(|(a, b)| color.map(|color| color.restricted(a, b)));
        self.part((&model.restricted(-1.0, 0.0), near.as_ref()), s, 0.5 * half, halvings + 1, whole);
        if !self.ended {
            self.part((&model.restricted(0.0, 1.0), far.as_ref()), s + half, 0.5 * half, halvings + 1, whole);
        }
    }

    /// Bound on the error of the transmittance in front.
    pub(crate) fn front_error(&self) -> Bound {
        let min = (self.result.depth - self.depth_error.value()).max(0.0);
        let (here, clearest) = (self.result.transmittance(), libm::exp(-min));
        Bound::new(clearest - here)
    }

    fn add(&mut self, gain: Gain, in_front: f64, s: f64) {
        let brightest = largest(gain.light);
        for c in 0..3 {
            self.result.radiance[c] += in_front * gain.light[c];
        }
        let radiance = largest(self.result.radiance);
        let dimmed = if brightest == 0.0 { Bound::ZERO } else { self.front_error() * brightest };
        self.light_error += gain.light_error * (in_front + self.front_error().value()) + dimmed;
        self.light_error += f64::EPSILON * (radiance + in_front * brightest);
        self.result.depth += gain.depth;
        self.depth_error += gain.depth_error + f64::EPSILON * self.result.depth;
        self.result.pieces += 1;
        if self.result.half_way == f64::INFINITY && self.result.depth >= HALF_DEPTH && self.deepest >= HALF_DEPTH {
            self.result.half_way = s;
        }
    }

    fn finish(mut self, level: f64) -> Transport {
        self.touched_wall();
        if !self.level_reached && self.emission > 0.0 && level < 1.0 {
            // The level may have been reached before the end, to what the depth is off by.
            let [min, max] = [-1.0, 1.0].map(|sign| self.result.depth + sign * self.depth_error.value());
            if max >= self.deepest && min < self.deepest {
                self.light_error += self.emission * self.length * self.result.transmittance();
            }
        }
        let reached = self.result.depth == f64::INFINITY || self.level_reached || self.result.depth > self.deepest;
        if level < 1.0 && reached {
            self.result.depth = self.deepest;
        }
        let transmittance = self.result.transmittance();
        let mut opacity_error = self.front_error();
        if level < 1.0 {
            // No more than the level is ever drawn.
            opacity_error += f64::EPSILON;
        }
        if !self.depth_error.is_finite() {
            opacity_error = Bound::new(1.0);
        }
        if self.ended && !reached {
            // Whatever was left out behind can only have darkened.
            opacity_error = opacity_error.max(transmittance);
        }
        let mut error = self.light_error.max(opacity_error.min(1.0)) + 2.0 * f64::EPSILON;
        if !self.result.radiance.iter().all(|x| x.is_finite()) || self.result.depth.is_nan() {
            error = Bound::UNKNOWN;
        }
        self.result.certainty = Certainty::new(error, self.certain);
        self.result
    }
}

/// Half the width in value within which a jump's place is uncertain.
pub(crate) fn band(model: &LineModel) -> f64 {
    if model.field.is_constant() && model.error() == Bound::ZERO {
        return 0.0;
    }
    4.0 * model.error().value() + 8.0 * f64::EPSILON * (model.field.coefficients()[0].abs() + model.field.spread(1.0))
}
