//! How far a picture is from the exact solution.

use std::time::{Duration, Instant};

use serde::Serialize;
use vr_core::{Control, Frame, Model, RenderError, Scene, View};
use vr_physics::metrics::Metrics;
use vr_physics::{Certainty, Reference};

use crate::number;

/// Rows and columns of the subgrid of pixels on which a picture's error is measured where not every pixel is.
pub const SUBGRID: u32 = 64;

/// The exact solution of some pixels.
pub struct Exact {
    pixels: Vec<[u32; 2]>,
    rgba: Vec<[f64; 4]>,
    /// Largest error of the solution itself, and whether that is proven or estimated.
    pub certainty: Certainty,
    /// What it took.
    pub time: Duration,
}

impl Exact {
    /// Solves pixels of a view in f64.
    ///
    /// # Errors
    /// A view that makes no sense, or cancellation.
    pub fn solve(
        (scene, view): (&Scene, &View),
        model: &Model,
        pixels: Vec<[u32; 2]>,
        control: &Control,
    ) -> Result<Self, RenderError> {
        let start = Instant::now();
        let solution = Reference::default().solve_pixels(scene, view, model, &pixels, control)?;
        Ok(Self {
            rgba: solution.pixels.iter().map(|p| p.rgba).collect(),
            certainty: solution.pixels.iter().map(|p| p.certainty).fold(Certainty::Bound(0.0), least),
            pixels,
            time: start.elapsed(),
        })
    }

    /// The error of a frame of the same view.
    pub fn judge(&self, frame: &Frame) -> Metrics {
        let drawn: Vec<[f32; 4]> = self.pixels.iter().map(|&[x, y]| frame.pixel(x, y)).collect();
        Metrics::of(&self.rgba, &drawn)
    }

    /// Largest error of any component of each pixel, in units of max(1, largest magnitude of the solution).
    pub fn errors(&self, frame: &Frame) -> Vec<f64> {
        let scale = self.rgba.iter().flatten().fold(1.0f64, |peak, c| peak.max(c.abs()));
        let error = |(&[x, y], exact): (&[u32; 2], &[f64; 4])| {
            let drawn = frame.pixel(x, y);
            (0..4).map(|c| (f64::from(drawn[c]) - exact[c]).abs() / scale).fold(0.0, f64::max)
        };
        self.pixels.iter().zip(&self.rgba).map(error).collect()
    }

    /// `within 1e-10`, or that it is an estimate.
    pub fn certainty_text(&self) -> String {
        match self.certainty {
            Certainty::Bound(e) => format!("itself proven within {}", number::small(e)),
            Certainty::Estimate(e) => format!("itself within an estimated {}", number::small(e)),
        }
    }

    /// How many pixels were solved.
    pub fn count(&self) -> usize {
        self.pixels.len()
    }
}

/// What is certain of both: the larger error, and an estimate as soon as one is.
fn least(a: Certainty, b: Certainty) -> Certainty {
    match (a, b) {
        (Certainty::Bound(a), Certainty::Bound(b)) => Certainty::Bound(a.max(b)),
        (Certainty::Bound(a) | Certainty::Estimate(a), Certainty::Bound(b) | Certainty::Estimate(b)) => {
            Certainty::Estimate(a.max(b))
        }
    }
}

/// An error as `--json` prints it.
#[derive(Debug, Serialize)]
pub struct ErrorJson {
    max: f64,
    rmse: f64,
    bias: f64,
    p99: f64,
    /// `null` for an exact picture: JSON has no infinity.
    psnr: Option<f64>,
    pixels: usize,
    reference_error: f64,
    reference_error_is: &'static str,
}

impl ErrorJson {
    /// An error, and how exact the solution is that it was measured against.
    pub fn new(metrics: &Metrics, exact: &Exact) -> Self {
        let (reference_error, reference_error_is) = match exact.certainty {
            Certainty::Bound(e) => (e, "bound"),
            Certainty::Estimate(e) => (e, "estimate"),
        };
        let &Metrics { max, rmse, bias, p99, psnr, pixels, .. } = metrics;
        let psnr = psnr.is_finite().then_some(psnr);
        Self { max, rmse, bias, p99, psnr, pixels, reference_error, reference_error_is }
    }
}
