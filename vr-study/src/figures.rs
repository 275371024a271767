//! Errors as results hold them.

use serde::{Deserialize, Serialize};
use vr_physics::{Certainty, Metrics};

use crate::exact::Exact;

/// The error of a picture, and how exact the solution is that it was measured against.
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
    /// In dB; `None` for an exact picture: JSON has no infinity.
    pub psnr: Option<f64>,
    /// Pixels compared.
    pub pixels: usize,
    /// Largest error of the solution.
    pub reference_error: f64,
    /// `bound` or `estimate`.
    pub reference_error_is: String,
}

impl ErrorFigures {
    /// An error, and how exact the solution is that it was measured against.
    pub fn new(metrics: &Metrics, exact: &Exact) -> Self {
        let (reference_error, word) = match exact.certainty {
            Certainty::Bound(e) => (e, "bound"),
            Certainty::Estimate(e) => (e, "estimate"),
        };
        let &Metrics { max, rmse, bias, p99, psnr, pixels, .. } = metrics;
        let psnr = psnr.is_finite().then_some(psnr);
        Self { max, rmse, bias, p99, psnr, pixels, reference_error, reference_error_is: word.to_owned() }
    }
}
