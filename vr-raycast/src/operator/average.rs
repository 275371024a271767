//! Mean of the field.

use std::ops::ControlFlow;
use std::sync::Arc;

use vr_core::{Calibration, Real, TransferFunction};

use super::{Needs, Operator};
use crate::chord::Chord;
use crate::ray_value::RayValue;
use crate::run::Run;

/// Operator that classifies the mean ∫ f ds / ∫ ds over the part of the chord that is not vacuum, without length correction.
///
/// It lies nowhere in particular: the depth is +∞.
#[derive(Clone, Debug)]
pub(crate) struct Average {
    pub(crate) transfer: Arc<TransferFunction>,
    pub(crate) calibration: Calibration,
    /// Integrals ∫ f ds and ∫ ds so far.
    integral: f64,
    length: f64,
}

impl Average {
    pub(crate) fn new(transfer: Arc<TransferFunction>, calibration: Calibration) -> Self {
        Self { transfer, calibration, integral: 0.0, length: 0.0 }
    }
}

impl<R: Real> Operator<R> for Average {
    fn needs(&self) -> Needs {
        Needs::VALUES
    }

    fn begin(&mut self, _: &Chord<'_>) {
        (self.integral, self.length) = (0.0, 0.0);
    }

    fn take(&mut self, run: &Run<R>, _: &Chord<'_>) -> ControlFlow<()> {
        for (&value, &length) in run.value[..run.len()].iter().zip(&run.steps.length) {
            if !value.is_nan() {
                self.integral += length * value.to_f64();
                self.length += length;
            }
        }
        ControlFlow::Continue(())
    }

    fn finish(&mut self, _: &Chord<'_>) -> RayValue {
        if self.length == 0.0 {
            return RayValue::NOTHING;
        }
        let rgba = self.transfer.at(self.calibration.value(self.integral / self.length)).pixel();
        RayValue { rgba, ..RayValue::NOTHING }
    }
}
