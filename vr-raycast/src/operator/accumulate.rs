//! Emission and absorption, cut where opacity reaches a level.

use std::ops::ControlFlow;

use vr_core::Real;

use super::{HALF, Needs, Operator, distance_of_opacity, end_of_opacity, steps_of};
use crate::chord::Chord;
use crate::ray_value::RayValue;
use crate::run::Run;

/// The over integral up to the point where 1 − e^(−τ) reaches `level`.
///
/// That point lies inside a step, and only the step's part before it counts: the part of opacity (level − A)/(1 − A), with
/// light in proportion to it. The sum is kept in f64 step by step, since where it ends must not hang on a rounding.
#[derive(Clone, Debug)]
pub(crate) struct Accumulate {
    level: f64,
    rgba: [f64; 4],
    depth: f64,
}

impl Accumulate {
    pub(crate) fn new(level: f64) -> Self {
        Self { level, rgba: [0.0; 4], depth: f64::INFINITY }
    }
}

impl<R: Real> Operator<R> for Accumulate {
    fn needs(&self) -> Needs {
        Needs::LIGHT
    }

    fn begin(&mut self, _: &Chord<'_>) {
        self.rgba = [0.0; 4];
        self.depth = f64::INFINITY;
    }

    fn take(&mut self, run: &Run<R>, _: &Chord<'_>) -> ControlFlow<()> {
        let before = self.rgba[3];
        let mut flow = ControlFlow::Continue(());
        for light in &run.light[..run.len()] {
            let light = light.map(R::to_f64);
            let clear = 1.0 - self.rgba[3];
            let reached = self.rgba[3] + clear * light[3] >= self.level;
            // A step of no opacity reaches nothing: the quotient is finite.
            let share = if reached { (self.level - self.rgba[3]) / (clear * light[3]) } else { 1.0 };
            for c in 0..3 {
                self.rgba[c] += clear * share * light[c];
            }
            self.rgba[3] = if reached { self.level } else { self.rgba[3] + clear * light[3] };
            if reached {
                flow = ControlFlow::Break(());
                break;
            }
        }
        if before < HALF && self.rgba[3] >= HALF {
            self.depth = distance_of_opacity(HALF, before, steps_of(run)).unwrap_or(end_of_opacity(run));
        }
        flow
    }

    fn finish(&mut self, chord: &Chord<'_>) -> RayValue {
        RayValue { rgba: self.rgba, depth: self.depth + chord.ray.offset }
    }
}
