//! Figures of errors in results.

use serde::{Deserialize, Serialize};
use vr_core::Frame;
use vr_physics::{Certainty, Metrics};

use crate::reference::{NoiseAccount, ReferencePixels};

/// Error of a picture, and error of the reference that it was measured against.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorFigures {
    /// Largest |e|.
    pub max: f64,
    /// Root of the mean of e².
    pub rmse: f64,
    /// Mean of e with its sign.
    pub bias: f64,
    /// 99th percentile of |e|.
    pub p99: f64,
    /// Peak signal-to-noise ratio in dB; `None` for an exact picture: JSON has no infinity.
    pub psnr: Option<f64>,
    /// Pixels compared.
    pub pixels: usize,
    /// Largest error of the reference itself.
    pub reference_error: f64,
    /// Kind of the reference's error: `bound` or `estimate`.
    pub reference_error_is: String,
    /// Noise of the picture and of the reference, where that is a mean over random paths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<NoiseAccount>,
}

impl ErrorFigures {
    /// Judges a frame against the reference of the same view.
    pub fn new(reference: &ReferencePixels, frame: &Frame) -> Self {
        let (reference_error, word) = match reference.certainty {
            Certainty::Bound(e) => (e, "bound"),
            Certainty::Estimate(e) => (e, "estimate"),
        };
        let (Metrics { max, rmse, bias, p99, psnr, pixels, .. }, noise) = reference.judge_with_noise(frame);
        let psnr = psnr.is_finite().then_some(psnr);
        let reference_error_is = word.to_owned();
        Self { max, rmse, bias, p99, psnr, pixels, reference_error, reference_error_is, noise }
    }
}
