//! Mean of the field.

use std::ops::ControlFlow;
use std::sync::Arc;

use vr_core::{Calibration, Real, TransferFunction};

use super::{Needs, Operator};
use crate::chord::Chord;
use crate::ray_value::RayValue;
use crate::run::Run;

/// Operator that classifies the mean ∫ f ds / ∫ ds over the part of the chord that is not vacuum, without length correction; where voxels have
/// colours, by the mean of those.
///
/// It lies nowhere in particular: the depth is +∞.
#[derive(Clone, Debug)]
pub(crate) struct Average {
    pub(crate) transfer: Arc<TransferFunction>,
    pub(crate) calibration: Calibration,
    /// Integrals ∫ f ds and ∫ ds so far.
    integral: f64,
    length: f64,
    /// Integral of the colours of the places, where voxels have any.
    color: Option<[f64; 3]>,
}

impl Average {
    pub(crate) fn new(transfer: Arc<TransferFunction>, calibration: Calibration) -> Self {
        Self { transfer, calibration, integral: 0.0, length: 0.0, color: None }
    }
}

impl<R: Real> Operator<R> for Average {
    fn needs(&self) -> Needs {
        Needs { colors: true, ..Needs::VALUES }
    }

    fn begin(&mut self, chord: &Chord<'_>) {
        (self.integral, self.length) = (0.0, 0.0);
        self.color = chord.colors.map(|_| [0.0; 3]);
    }

    fn take(&mut self, run: &Run<R>, _: &Chord<'_>) -> ControlFlow<()> {
        for (j, (&value, &length)) in run.value[..run.len()].iter().zip(&run.steps.length).enumerate() {
            if !value.is_nan() {
                self.integral += length * value.to_f64();
                self.length += length;
                if let Some(color) = &mut self.color {
                    (0..3).for_each(|c| color[c] += length * run.color[j][c].to_f64());
                }
            }
        }
        ControlFlow::Continue(())
    }

    fn finish(&mut self, _: &Chord<'_>) -> RayValue {
        if self.length == 0.0 {
            return RayValue::NOTHING;
        }
        let mut rgba = self.transfer.at(self.calibration.value(self.integral / self.length)).pixel();
        if let Some(color) = self.color {
            (0..3).for_each(|c| rgba[c] *= color[c] / self.length);
        }
        RayValue { rgba, ..RayValue::NOTHING }
    }
}
