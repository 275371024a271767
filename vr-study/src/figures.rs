//! Figures of errors in results.

use serde::{Deserialize, Serialize};
use vr_physics::{Certainty, Metrics};

use crate::reference::ReferencePixels;

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
}

impl ErrorFigures {
    /// Makes the figures of metrics and the reference that they were measured against.
    pub fn new(metrics: &Metrics, reference: &ReferencePixels) -> Self {
        let (reference_error, word) = match reference.certainty {
            Certainty::Bound(e) => (e, "bound"),
            Certainty::Estimate(e) => (e, "estimate"),
        };
        let &Metrics { max, rmse, bias, p99, psnr, pixels, .. } = metrics;
        let psnr = psnr.is_finite().then_some(psnr);
        Self { max, rmse, bias, p99, psnr, pixels, reference_error, reference_error_is: word.to_owned() }
    }
}
