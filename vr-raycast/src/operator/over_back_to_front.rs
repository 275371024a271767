//! Emission and absorption, from the depth to the eye.

use std::ops::ControlFlow;

use vr_core::Real;

use super::{HALF, Operator, distance_of_opacity};
use crate::chord::Chord;
use crate::ray_value::RayValue;
use crate::run::Run;

/// C ← c + (1 − α)·C, A ← α + (1 − α)·A, from the last step to the first.
///
/// Runs are summed in the kernel's precision and joined in f64, as in [`super::OverFrontToBack`].
#[derive(Clone, Debug, Default)]
pub(crate) struct OverBackToFront {
    rgba: [f64; 4],
    /// Opacities of all steps, last first: only the whole ray tells how deep the eye sees.
    opacity: Vec<f32>,
}

impl<R: Real> Operator<R> for OverBackToFront {
    const LIGHT: bool = true;
    const BACKWARDS: bool = true;

    fn begin(&mut self, _: &Chord<'_>) {
        self.rgba = [0.0; 4];
        self.opacity.clear();
    }

    fn take(&mut self, run: &Run<R>, _: &Chord<'_>) -> ControlFlow<()> {
        let mut sum = [R::ZERO; 4];
        for light in run.light[..run.len].iter().rev() {
            let clear = R::ONE - light[3];
            for c in 0..4 {
                sum[c] = light[c] + clear * sum[c];
            }
            // A depth is kept as f32, and so its opacities may be.
            self.opacity.push(light[3].to_f64() as f32);
        }
        let clear = 1.0 - sum[3].to_f64();
        for c in 0..4 {
            self.rgba[c] = sum[c].to_f64() + clear * self.rgba[c];
        }
        ControlFlow::Continue(())
    }

    fn finish(&mut self, chord: &Chord<'_>) -> RayValue {
        let steps = &chord.steps;
        let length = |k: usize| if k + 1 == steps.count { steps.last } else { steps.length };
        let front_to_back = self.opacity.iter().rev().enumerate();
        let depth =
            distance_of_opacity(HALF, 0.0, front_to_back.map(|(k, &a)| (f64::from(a), steps.begin(k), length(k))));
        RayValue { rgba: self.rgba, depth: depth.map_or(f64::INFINITY, |s| s + chord.ray.offset) }
    }
}
