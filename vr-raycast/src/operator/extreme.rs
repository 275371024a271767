//! Largest or smallest value of the field.

use std::ops::ControlFlow;
use std::sync::Arc;

use vr_core::{Calibration, Real, TransferFunction};

use super::{Needs, Operator};
use crate::chord::Chord;
use crate::ray_value::RayValue;
use crate::run::Run;

/// Operator that classifies the extreme of the samples and of the two ends of the chord, without length correction; its depth is where it lies.
///
/// Between samples the field can go further: by max|f″|·h²/8, where it is smooth.
#[derive(Clone, Debug)]
pub(crate) struct Extreme {
    transfer: Arc<TransferFunction>,
    calibration: Calibration,
    /// Sign of the search: 1 for the largest stored number, −1 for the smallest.
    sign: f64,
    /// Largest sign·stored so far; −∞ before the first sample.
    best: f64,
    distance: f64,
}

impl Extreme {
    /// Makes the operator of the largest calibrated value (`largest`) or of the smallest.
    pub(crate) fn new(transfer: Arc<TransferFunction>, calibration: Calibration, largest: bool) -> Self {
        // A negative slope turns the order of the stored numbers round.
        let sign = if largest == (calibration.slope > 0.0) { 1.0 } else { -1.0 };
        Self { transfer, calibration, sign, best: f64::NEG_INFINITY, distance: f64::INFINITY }
    }
}

impl<R: Real> Operator<R> for Extreme {
    fn needs(&self) -> Needs {
        Needs { ends: true, ..Needs::VALUES }
    }

    fn begin(&mut self, _: &Chord<'_>) {
        (self.best, self.distance) = (f64::NEG_INFINITY, f64::INFINITY);
    }

    fn take(&mut self, run: &Run<R>, _: &Chord<'_>) -> ControlFlow<()> {
        let sign = R::from_f64(self.sign);
        let (mut best, mut found) = (R::from_f64(self.best), None);
        for (j, &value) in run.value[..run.len()].iter().enumerate() {
            // False for NaN.
            if sign * value > best {
                (best, found) = (sign * value, Some(j));
            }
        }
        if let Some(j) = found {
            (self.best, self.distance) = (best.to_f64(), run.distance(j));
        }
        ControlFlow::Continue(())
    }

    fn finish(&mut self, chord: &Chord<'_>) -> RayValue {
        if self.best == f64::NEG_INFINITY {
            return RayValue::NOTHING;
        }
        let rgba = self.transfer.at(self.calibration.value(self.sign * self.best)).pixel();
        RayValue { rgba, depth: self.distance + chord.ray.offset }
    }
}
