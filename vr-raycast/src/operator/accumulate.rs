//! Emission and absorption, cut where opacity reaches a level.

use std::ops::ControlFlow;

use vr_core::Real;
use vr_core::optics::add_up_to_level;

use super::{HALF, Needs, Operator, distance_of_opacity, end_of_opacity, steps_of};
use crate::chord::Chord;
use crate::ray_value::RayValue;
use crate::run::Run;

/// Operator of the over integral up to the point where 1 − e^(−τ) reaches `level`.
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
        let mut steps = run.light[..run.len()].iter().map(|light| light.map(R::to_f64));
        let reached = steps.any(|light| add_up_to_level(&mut self.rgba, light, self.level));
        if before < HALF && self.rgba[3] >= HALF {
            self.depth = distance_of_opacity(HALF, before, steps_of(run)).unwrap_or(end_of_opacity(run));
        }
        if reached { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn finish(&mut self, chord: &Chord<'_>) -> RayValue {
        RayValue { rgba: self.rgba, depth: self.depth + chord.ray.offset }
    }
}
