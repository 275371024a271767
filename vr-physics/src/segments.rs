//! The reference's own account of one ray: cut at every change of the medium, each part solved by itself and the ray up to its end.

use crate::crossings::crossings;
use crate::optics::Optics;
use crate::transport::{Certainty, Transport, transport};
use vr_core::bound::{Bound, largest};
use vr_core::field::{Chord, Cut, FieldLine, LineColor, LineModel};

/// A part of a ray between two cuts, on which the field is smooth and the transfer function has no knot.
#[derive(Clone, Debug, PartialEq)]
pub struct RaySegment {
    /// World distance along the ray at which it begins.
    pub from: f64,
    /// World distance along the ray at which it ends; above `from`.
    pub to: f64,
    /// The cuts at its front: several if the ray goes through an edge or a corner there.
    pub front: Vec<Cut>,
    /// The field's calibrated values where it begins and where it ends; NaN in vacuum.
    pub values: [f64; 2],
    /// Its light; `None` where the compositing picks a value and integrates no light.
    pub light: Option<SegmentLight>,
}

/// The exact light of a segment, and of the ray up to its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentLight {
    /// Transparency θ = e^(−τ) of the segment.
    pub transparency: f64,
    /// Light b that it sends out at its front: ∫ q e^(−τ) ds, τ counted from there.
    pub light: [f64; 3],
    /// Bound or estimate of the error of each of these.
    pub certainty: Certainty,
    /// Radiance of the ray from its front to the segment's end, as if nothing came after.
    pub radiance: [f64; 3],
    /// Optical depth τ of the ray from its front to the segment's end; +∞ behind a wall.
    pub depth: f64,
    /// Bound or estimate of the error of `radiance`, and of the opacity 1 − e^(−τ).
    pub running: Certainty,
}

impl SegmentLight {
    /// Opacity 1 − e^(−τ) of the ray from its front to the segment's end.
    pub fn opacity(&self) -> f64 {
        -libm::expm1(-self.depth)
    }
}

/// Cuts nearer to each other than this part of the chord are one: rounding.
const SLIVER: f64 = 1e-12;

/// Cuts a ray, and solves each part. `level` ends the light where opacity reaches it (1: never); `None`: no light is asked for.
pub(crate) fn segments(
    line: &dyn FieldLine,
    optics: &Optics<'_>,
    tolerance: f64,
    level: Option<f64>,
    asked: &[f64],
) -> Vec<RaySegment> {
    let chord = line.chord();
    let mut running = level.map(|level| Running::new(level, tolerance, chord.length()));
    let knots = knots(optics);
    let mut breakpoints = Vec::new();
    line.breakpoints(&mut breakpoints);
    let cuts = cuts(line, &chord, &breakpoints, &knots, asked);
    let ends: Vec<f64> = cuts.iter().skip(1).map(|cut| cut.0).chain([chord.end]).collect();
    let mut all: Vec<RaySegment> = Vec::with_capacity(cuts.len());
    let mut before = f64::NAN;
    for ((from, mut front), to) in cuts.into_iter().zip(ends) {
        let part = Part::new(line, from, to, &breakpoints, SLIVER * chord.length());
        let [[first, early], [late, last]] = part.values();
        // At a face the value may jump over a knot, or have it just there.
        let crossed = knots.iter().filter(|&&v| (before < v && early >= v) || (before >= v && early < v));
        for &value in crossed {
            let knot = Cut::Knot { value };
            if !front.contains(&knot) {
                front.insert(front.iter().take_while(|&&cut| cut != Cut::Asked).count(), knot);
            }
        }
        before = late;
        let light = running.as_mut().map(|running| running.add(&part, optics));
        all.push(RaySegment { from: from + chord.offset, to: to + chord.offset, front, values: [first, last], light });
    }
    all
}

/// Values at which the transfer function has a kink or jumps, sorted.
fn knots(optics: &Optics<'_>) -> Vec<f64> {
    let mut knots: Vec<f64> = optics.kinks.iter().chain(&optics.jumps).copied().collect();
    knots.sort_by(f64::total_cmp);
    knots
}

/// Every place where the ray is cut, and its cuts; the first is its entry.
fn cuts(
    line: &dyn FieldLine,
    chord: &Chord,
    breakpoints: &[f64],
    knots: &[f64],
    asked: &[f64],
) -> Vec<(f64, Vec<Cut>)> {
    let mut cuts = Vec::new();
    line.cuts(&mut cuts);
    let mut found = Vec::new();
    for ends in breakpoints.windows(2).filter(|ends| ends[1] > ends[0]) {
        let Some(LineModel { field, .. }) = line.between(ends[0], ends[1]) else { continue };
        let (value, reach) = (field.coefficients()[0], field.spread(1.0));
        // A little more, for rounding: what is not crossed is not found.
        let reach = reach + 1e-12 * (value.abs() + reach);
        let near = knots.partition_point(|&v| v < value - reach)..knots.partition_point(|&v| v <= value + reach);
        for &value in &knots[near] {
            found.clear();
            crossings(&field, &[value], &mut found);
            let place = |t: &f64| 0.5 * (ends[0] + ends[1]) + 0.5 * (ends[1] - ends[0]) * t;
            cuts.extend(found.iter().map(|t| (place(t), Cut::Knot { value })));
        }
    }
    cuts.extend(asked.iter().map(|s| (s - chord.offset, Cut::Asked)));
    let sliver = SLIVER * chord.length();
    cuts.retain(|cut| cut.0 >= chord.start && cut.0 < chord.end - sliver);
    // Stable: what is at one place keeps the order from above, in which what is asked for comes last.
    cuts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut merged: Vec<(f64, Vec<Cut>)> = Vec::with_capacity(cuts.len());
    for (s, cut) in cuts {
        match merged.last_mut() {
            Some((last, here)) if s - *last <= sliver => {
                if !here.contains(&cut) {
                    here.push(cut);
                }
            }
            _ => merged.push((s, vec![cut])),
        }
    }
    merged
}

/// A part of a line.
struct Part<'a> {
    line: &'a dyn FieldLine,
    /// Its ends, and the line's breakpoints between that are no cuts.
    breakpoints: Vec<f64>,
}

impl<'a> Part<'a> {
    fn new(line: &'a dyn FieldLine, from: f64, to: f64, all: &[f64], sliver: f64) -> Self {
        // Cuts so near to each other are one: a breakpoint beside an end is that end.
        let inner = all.iter().copied().filter(|&s| s > from + 2.0 * sliver && s < to - 2.0 * sliver);
        Self { line, breakpoints: [from].into_iter().chain(inner).chain([to]).collect() }
    }

    /// The field at the front and in the middle of the first stretch, then in the middle of the last one and at its end.
    fn values(&self) -> [[f64; 2]; 2] {
        let b = &self.breakpoints;
        let at = |i: usize, places: [f64; 2]| {
            let model = self.line.between(b[i], b[i + 1]);
            model.map_or([f64::NAN; 2], |model| places.map(|t| model.field.at(t)))
        };
        [at(0, [-1.0, 0.0]), at(b.len() - 2, [0.0, 1.0])]
    }
}

impl FieldLine for Part<'_> {
    fn chord(&self) -> Chord {
        let ends = &self.breakpoints;
        Chord { start: ends[0], end: ends[ends.len() - 1], ..self.line.chord() }
    }

    fn breakpoints(&self, out: &mut Vec<f64>) {
        out.extend_from_slice(&self.breakpoints);
    }

    fn between(&self, from: f64, to: f64) -> Option<LineModel> {
        self.line.between(from, to)
    }

    fn color(&self, from: f64, to: f64) -> Option<LineColor> {
        self.line.color(from, to)
    }

    fn misplaced(&self, at: f64) -> f64 {
        self.line.misplaced(at)
    }
}

/// The light of a ray so far.
///
/// C ← C + T b and T ← T θ. Each of b and θ is off by at most e, C by E and T by δ: then E ← E + T e + δ (b + e) and
/// δ ← T e + δ (θ + e), and a rounding each.
struct Running {
    level: f64,
    tolerance: f64,
    length: f64,
    radiance: [f64; 3],
    depth: f64,
    radiance_error: Bound,
    transmittance_error: Bound,
    certain: bool,
    ended: bool,
}

impl Running {
    fn new(level: f64, tolerance: f64, length: f64) -> Self {
        Self {
            level,
            tolerance,
            length,
            radiance: [0.0; 3],
            depth: 0.0,
            radiance_error: Bound::ZERO,
            transmittance_error: Bound::ZERO,
            certain: true,
            ended: false,
        }
    }

    /// Solves a part, and adds it.
    fn add(&mut self, part: &Part<'_>, optics: &Optics<'_>) -> SegmentLight {
        // Each part has its share of what the whole ray may be off by.
        let ends = &part.breakpoints;
        let tolerance = self.tolerance * ((ends[ends.len() - 1] - ends[0]) / self.length).max(1e-6);
        let own = transport(part, optics, tolerance, 1.0);
        if !self.ended {
            // The level is reached in here if what is left up to it is less than what is here.
            let left = -libm::log1p(-self.level) - self.depth;
            self.ended = self.level < 1.0 && own.depth >= left;
            let cut = if self.ended { transport(part, optics, tolerance, -libm::expm1(-left)) } else { own };
            self.join(&cut);
            if self.ended {
                self.depth = -libm::log1p(-self.level);
            }
        }
        let opacity_error = self.transmittance_error.min(1.0);
        SegmentLight {
            transparency: own.transmittance(),
            light: own.radiance,
            certainty: own.certainty,
            radiance: self.radiance,
            depth: self.depth,
            running: Certainty::new(self.radiance_error.max(opacity_error), self.certain),
        }
    }

    fn join(&mut self, part: &Transport) {
        let in_front = libm::exp(-self.depth);
        let error = Bound::new(part.certainty.value());
        let brightest = largest(part.radiance);
        for c in 0..3 {
            self.radiance[c] += in_front * part.radiance[c];
        }
        let size = largest(self.radiance);
        let doubt = self.transmittance_error;
        self.radiance_error += error * in_front + doubt * (error + brightest).value() + 4.0 * f64::EPSILON * size;
        self.transmittance_error =
            error * in_front + doubt * (error + part.transmittance()).value() + 2.0 * f64::EPSILON;
        self.depth += part.depth;
        self.certain &= matches!(part.certainty, Certainty::Bound(_));
    }
}
