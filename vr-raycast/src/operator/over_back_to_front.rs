//! Emission and absorption, back to front.

use std::ops::ControlFlow;

use vr_core::Real;

use super::{HALF, Needs, Operator, distance_of_opacity, steps_of};
use crate::chord::Chord;
use crate::ray_value::RayValue;
use crate::run::Run;

/// Operator over, from the last step to the first: C ← c + (1 − α)·C, A ← α + (1 − α)·A.
///
/// Runs are summed in the kernel's precision and joined in f64, as in [`super::OverFrontToBack`].
#[derive(Clone, Debug, Default)]
pub(crate) struct OverBackToFront {
    rgba: [f64; 4],
    /// Opacity, begin and length of all steps, last first: the depth follows from the whole ray alone.
    steps: Vec<(f64, f64, f64)>,
}

impl<R: Real> Operator<R> for OverBackToFront {
    fn needs(&self) -> Needs {
        Needs { backwards: true, ..Needs::LIGHT }
    }

    fn begin(&mut self, _: &Chord<'_>) {
        self.rgba = [0.0; 4];
        self.steps.clear();
    }

    fn take(&mut self, run: &Run<R>, _: &Chord<'_>) -> ControlFlow<()> {
        let mut sum = [R::ZERO; 4];
        for light in run.light[..run.len()].iter().rev() {
            let clear = R::ONE - light[3];
            for c in 0..4 {
                sum[c] = light[c] + clear * sum[c];
            }
        }
        self.steps.extend(steps_of(run).rev());
        let clear = 1.0 - sum[3].to_f64();
        for c in 0..4 {
            self.rgba[c] = sum[c].to_f64() + clear * self.rgba[c];
        }
        ControlFlow::Continue(())
    }

    fn finish(&mut self, chord: &Chord<'_>) -> RayValue {
        let depth = distance_of_opacity(HALF, 0.0, self.steps.iter().rev().copied());
        RayValue { rgba: self.rgba, depth: depth.map_or(f64::INFINITY, |s| s + chord.ray.offset) }
    }
}
