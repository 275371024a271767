//! The first point where the field reaches a value.

use std::ops::ControlFlow;

use vr_core::{Calibration, Real};

use super::Operator;
use crate::chord::Chord;
use crate::ray_value::RayValue;
use crate::run::Run;

/// The first point where the field reaches a threshold: found between two samples, or at the entry point, then refined on the
/// field itself by bisection. The pixel is (c, 1), c the transfer function's colour at the threshold.
///
/// Where the field reaches the threshold and falls below it again between two samples, it is missed.
#[derive(Clone, Debug)]
pub(crate) struct First {
    color: [f64; 3],
    /// In stored units.
    threshold: f64,
    /// −1 where larger values have smaller stored numbers.
    sign: f64,
    /// The last sample that was below, or vacuum.
    below: Option<f64>,
    hit: Option<f64>,
}

impl First {
    pub(crate) fn new(color: [f64; 3], threshold: f64, calibration: Calibration) -> Self {
        let sign = calibration.slope.signum();
        Self { color, threshold: calibration.stored(threshold), sign, below: None, hit: None }
    }
}

impl<R: Real> Operator<R> for First {
    const LIGHT: bool = false;
    const ENDS: bool = true;
    const SURFACE: bool = true;

    fn begin(&mut self, _: &Chord<'_>) {
        (self.below, self.hit) = (None, None);
    }

    fn take(&mut self, run: &Run<R>, chord: &Chord<'_>) -> ControlFlow<()> {
        let (sign, threshold) = (R::from_f64(self.sign), R::from_f64(self.sign * self.threshold));
        // False for NaN: vacuum is below everything.
        let reached = run.value[..run.len].iter().position(|&value| sign * value >= threshold);
        let Some(j) = reached else {
            self.below = Some(run.distance(run.len - 1));
            return ControlFlow::Continue(());
        };
        let here = run.distance(j);
        let below = if j > 0 { Some(run.distance(j - 1)) } else { self.below };
        let refine = |below| chord.crossing(below, here, self.sign, self.threshold);
        self.hit = Some(below.map_or(here, refine));
        ControlFlow::Break(())
    }

    fn finish(&mut self, chord: &Chord<'_>) -> RayValue {
        let [r, g, b] = self.color;
        self.hit.map_or(RayValue::NOTHING, |s| RayValue { rgba: [r, g, b, 1.0], depth: s + chord.ray.offset })
    }
}
