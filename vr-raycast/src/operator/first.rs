//! First point where the field reaches a value.

use std::ops::ControlFlow;
use std::sync::Arc;

use vr_core::{Calibration, Real, TransferFunction};

use super::{Needs, Operator};
use crate::chord::{Chord, Crossing};
use crate::ray_value::RayValue;
use crate::run::Run;

/// Operator that shows the first point where the field reaches a threshold: found between two samples, or at the entry point, then refined on the
/// field itself by bisection. The pixel is (c, 1), c the transfer function's colour of the field there: that of the threshold,
/// or of what lies above it where the field jumps or the ray enters.
///
/// A crossing is missed where the field reaches the threshold and falls below it again between two samples.
#[derive(Clone, Debug)]
pub(crate) struct First {
    transfer: Arc<TransferFunction>,
    calibration: Calibration,
    /// Threshold in stored units.
    threshold: f64,
    /// Sign of the calibration's slope: −1 where larger values have smaller stored numbers.
    sign: f64,
    /// Distance of the last sample that was below, or vacuum.
    below: Option<f64>,
    hit: Option<Crossing>,
}

impl First {
    pub(crate) fn new(transfer: Arc<TransferFunction>, calibration: Calibration, threshold: f64) -> Self {
        let sign = calibration.slope.signum();
        let threshold = calibration.stored(threshold);
        Self { transfer, calibration, threshold, sign, below: None, hit: None }
    }
}

impl<R: Real> Operator<R> for First {
    fn needs(&self) -> Needs {
        Needs { ends: true, brackets: true, surface: true, ..Needs::VALUES }
    }

    fn begin(&mut self, _: &Chord<'_>) {
        (self.below, self.hit) = (None, None);
    }

    fn take(&mut self, run: &Run<R>, chord: &Chord<'_>) -> ControlFlow<()> {
        let (sign, threshold) = (R::from_f64(self.sign), R::from_f64(self.sign * self.threshold));
        // False for NaN: vacuum is below everything.
        let reached = run.value[..run.len()].iter().position(|&value| sign * value >= threshold);
        let Some(j) = reached else {
            self.below = Some(run.distance(run.len() - 1));
            return ControlFlow::Continue(());
        };
        let here = Crossing { distance: run.distance(j), stored: run.value[j].to_f64() };
        let below = if j > 0 { Some(run.distance(j - 1)) } else { self.below };
        self.hit = Some(below.map_or(here, |below| chord.crossing(below, here, self.sign, self.threshold)));
        ControlFlow::Break(())
    }

    fn finish(&mut self, chord: &Chord<'_>) -> RayValue {
        let pixel = |hit: Crossing| {
            let [r, g, b] = self.transfer.at(self.calibration.value(hit.stored)).color;
            RayValue { rgba: [r, g, b, 1.0], depth: hit.distance + chord.ray.offset }
        };
        self.hit.map_or(RayValue::NOTHING, pixel)
    }
}
