//! Classification: from values to light and opacity.

use std::sync::Arc;

use vr_core::optics::{depth_of_opacity, opacity_of_depth};
use vr_core::{Calibration, Real, TransferFunction};
use vr_kernels::step_with_extinction_times;
use vr_kernels::tables::BakedTransfer;

use crate::rule::Profile;
use crate::run::Run;

/// Transfer function as a kernel uses it.
#[derive(Clone, Debug)]
pub(crate) struct Classifier<R> {
    pub(crate) transfer: Arc<TransferFunction>,
    pub(crate) calibration: Calibration,
    /// Table, and the length of the steps that it is for; `None` where everything is evaluated exactly.
    pub(crate) table: Option<(Arc<BakedTransfer<R>>, f64)>,
    /// Rule that integrates over all values of a step; `None` where one sample stands for a step.
    pub(crate) profile: Option<Profile<R>>,
}

/// Largest opacity of a step from which its optical depth follows in f32 to better than 10⁻⁵; above, 1 − α has lost its digits.
const INVERTIBLE: f64 = 0.99;

impl<R: Real> Classifier<R> {
    /// Fills the light of a run from its values.
    ///
    /// A step of another length than the table's is evaluated exactly: an entry of a dense step says too little of a short one. On a
    /// lattice there is only one a ray, the last.
    pub(crate) fn classify(&self, run: &mut Run<R>) {
        if let Some(profile) = &self.profile {
            profile.classify(run);
            return;
        }
        let len = run.len();
        if let Some((table, step)) = &self.table {
            for (light, &value) in run.light[..len].iter_mut().zip(&run.value[..len]) {
                *light = table.step(value);
            }
            for j in 0..len {
                if run.steps.length[j] != *step {
                    run.light[j] = self.exact(run.value[j], run.steps.length[j]);
                }
            }
        } else {
            for j in 0..len {
                run.light[j] = self.exact(run.value[j], run.steps.length[j]);
            }
        }
    }

    /// Returns light and opacity of a step of any length; both are 0 in vacuum.
    fn exact(&self, stored: R, length: f64) -> [R; 4] {
        if stored.is_nan() {
            return [R::ZERO; 4];
        }
        self.transfer.step(self.calibration.value(stored.to_f64()), length).map(R::from_f64)
    }

    /// Returns light and opacity of a step by the rows of the transfer function, where the gradient has a magnitude.
    pub(crate) fn by_rows(&self, run: &Run<R>, j: usize, magnitude: f64) -> [R; 4] {
        let value = self.calibration.value(run.value[j].to_f64());
        self.transfer.mixture(value, magnitude).step(run.steps.length[j]).map(R::from_f64)
    }

    /// Returns light and opacity of a classified step whose extinction is multiplied by `factor`.
    pub(crate) fn with_extinction_times(&self, run: &Run<R>, j: usize, factor: f64) -> [R; 4] {
        if let Some(profile) = &self.profile {
            return profile.with_extinction_times(run, j, factor);
        }
        let (step, stored, length) = (run.light[j], run.value[j], run.steps.length[j]);
        let opacity = step[3].to_f64();
        let value = self.calibration.value(stored.to_f64());
        let emits = self.transfer.has_emission();
        if factor == 0.0 || opacity > INVERTIBLE || self.table.is_none() {
            return step_with_extinction_times(&self.transfer, value, length, factor).map(R::from_f64);
        }
        if opacity == 0.0 {
            return step;
        }
        let tau = depth_of_opacity(opacity);
        let modified = opacity_of_depth(tau * factor);
        // Light is c·α, or q·h·w(τ) with w(τ) = α/τ.
        let share = R::from_f64(if emits { modified / (opacity * factor) } else { modified / opacity });
        [step[0] * share, step[1] * share, step[2] * share, R::from_f64(modified)]
    }
}
