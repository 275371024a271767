//! Emission and absorption, front to back.

use std::ops::ControlFlow;

use vr_core::{MaxRadiance, Real};

use super::{HALF, Needs, Operator, distance_of_opacity, end_of_opacity, steps_of};
use crate::chord::Chord;
use crate::ray_value::RayValue;
use crate::run::Run;

/// Operator over, from the first step to the last: C ← C + (1 − A)·c, A ← A + (1 − A)·α.
///
/// A run is summed in the kernel's precision, starting from zero, and joins the ray's sum in f64. So thousands of steps of
/// α = 10⁻⁷ add up: none is ever added to a sum large enough to swallow it.
#[derive(Clone, Debug)]
pub(crate) struct OverFrontToBack {
    /// Amount at which the ray ends: no more than this could be added to any component.
    negligible: f64,
    max_radiance: MaxRadiance,
    // The ray:
    /// Largest component that the medium can add.
    max_light: f64,
    rgba: [f64; 4],
    depth: f64,
}

impl OverFrontToBack {
    pub(crate) fn new(termination: f64, max_radiance: MaxRadiance) -> Self {
        Self { negligible: 1.0 - termination, max_radiance, max_light: 1.0, rgba: [0.0; 4], depth: f64::INFINITY }
    }
}

impl<R: Real> Operator<R> for OverFrontToBack {
    fn needs(&self) -> Needs {
        Needs::LIGHT
    }

    fn begin(&mut self, chord: &Chord<'_>) {
        self.max_light = self.max_radiance.over(chord.ray.length());
        self.rgba = [0.0; 4];
        self.depth = f64::INFINITY;
    }

    fn take(&mut self, run: &Run<R>, _: &Chord<'_>) -> ControlFlow<()> {
        let mut sum = [R::ZERO; 4];
        for light in &run.light[..run.len()] {
            let clear = R::ONE - sum[3];
            for c in 0..4 {
                sum[c] += clear * light[c];
            }
        }
        let before = self.rgba[3];
        for c in 0..4 {
            self.rgba[c] += (1.0 - before) * sum[c].to_f64();
        }
        let now = self.rgba[3];
        if before < HALF && now >= HALF {
            // Summed again in f64, the level may lie a rounding further: at the end of the run then.
            self.depth = distance_of_opacity(HALF, before, steps_of(run)).unwrap_or(end_of_opacity(run));
        }
        if (1.0 - now) * self.max_light <= self.negligible { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn finish(&mut self, chord: &Chord<'_>) -> RayValue {
        RayValue { rgba: self.rgba, depth: self.depth + chord.ray.offset }
    }
}
