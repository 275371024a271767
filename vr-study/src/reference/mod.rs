//! Reference pixels, and the distance of a picture from them.

mod cache;
mod fingerprint;

use std::sync::Arc;
use std::time::{Duration, Instant};

use vr_core::phantom::Phantom;
use vr_core::{Control, Frame, Model, RenderError, Scene, View};
use vr_physics::metrics::Metrics;
use vr_physics::{Certainty, Reference, Solution, spread};

use crate::error_colors;

pub use cache::ReferenceCache;
pub(crate) use fingerprint::fingerprint;
pub use fingerprint::frame_fingerprint;

/// Number of parts along each side of a picture, of each of which a pixel is compared, where not every pixel is.
pub const SUBGRID: u32 = 64;

/// Reference of some pixels of a view.
#[derive(Clone, Debug)]
pub struct ReferencePixels {
    pixels: Vec<[u32; 2]>,
    rgba: Vec<[f64; 4]>,
    /// Largest error of the reference itself, proven or estimated.
    pub certainty: Certainty,
    /// Time that it took to solve them, or to read them.
    pub time: Duration,
}

impl ReferencePixels {
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
        Ok(Self::new(pixels, &solution, start))
    }

    /// Solves pixels of a phantom as the function that it is, under the transfer function of a scene of its voxels.
    ///
    /// # Errors
    /// Same as for [`Reference::solve_phantom`].
    pub fn solve_phantom(
        phantom: &Arc<dyn Phantom>,
        (scene, view): (&Scene, &View),
        pixels: Vec<[u32; 2]>,
        control: &Control,
    ) -> Result<Self, RenderError> {
        /// Tolerance of the reference: ten thousand times below what can be seen.
        const TOLERANCE: f64 = 1e-7;
        let start = Instant::now();
        let solution = Reference::new(TOLERANCE).solve_phantom(phantom, (scene, view), &pixels, control)?;
        Ok(Self::new(pixels, &solution, start))
    }

    fn new(pixels: Vec<[u32; 2]>, solution: &Solution, start: Instant) -> Self {
        Self {
            rgba: solution.pixels.iter().map(|p| p.rgba).collect(),
            certainty: solution.certainty(),
            pixels,
            time: start.elapsed(),
        }
    }

    /// Returns the error of a frame of the same view.
    pub fn judge(&self, frame: &Frame) -> Metrics {
        let drawn: Vec<[f32; 4]> = self.pixels.iter().map(|&[x, y]| frame.pixel(x, y)).collect();
        Metrics::of(&self.rgba, &drawn)
    }

    /// Returns the divisor of errors: max(1, largest magnitude of the reference).
    pub fn scale(&self) -> f64 {
        self.rgba.iter().flatten().fold(1.0, |peak, c| peak.max(c.abs()))
    }

    /// Returns frame − reference per component of each pixel, in units of [`scale`](Self::scale).
    pub fn signed(&self, frame: &Frame) -> Vec<[f64; 4]> {
        let scale = self.scale();
        let error = |(&[x, y], exact): (&[u32; 2], &[f64; 4])| {
            let drawn = frame.pixel(x, y);
            std::array::from_fn(|c| (f64::from(drawn[c]) - exact[c]) / scale)
        };
        self.pixels.iter().zip(&self.rgba).map(error).collect()
    }

    /// Returns the largest error of any component of each pixel, in the same units; infinite where the frame has no number.
    pub fn errors(&self, frame: &Frame) -> Vec<f64> {
        let size = |e: f64| if e.is_nan() { f64::INFINITY } else { e.abs() };
        self.signed(frame).into_iter().map(|e| e.into_iter().map(size).fold(0.0, f64::max)).collect()
    }

    /// Returns the error of every pixel, row by row, where one pixel of each part of the [`subgrid`](vr_physics::metrics::subgrid) of `parts` was
    /// solved: interpolated on the logarithmic scale that errors are drawn in.
    pub fn error_map(&self, frame: &Frame, parts: u32) -> Vec<f64> {
        let (low, high) = error_colors::DECADES;
        // Beyond the scale there is one colour.
        let exponent = |error: f64| [error.log10().clamp(low.into(), high.into())];
        let exponents: Vec<[f64; 1]> = self.errors(frame).into_iter().map(exponent).collect();
        spread(parts, frame.size(), &exponents).into_iter().map(|[e]| 10f64.powf(e)).collect()
    }

    /// Returns the certainty in words: `within 1e-10`, or that it is an estimate.
    pub fn certainty_text(&self) -> String {
        match self.certainty {
            Certainty::Bound(e) => format!("itself proven within {e:.2e}"),
            Certainty::Estimate(e) => format!("itself within an estimated {e:.2e}"),
        }
    }

    /// Returns the pixels that were solved.
    pub fn pixels(&self) -> &[[u32; 2]] {
        &self.pixels
    }

    /// Returns their premultiplied linear RGBA, in the same order.
    pub fn rgba(&self) -> &[[f64; 4]] {
        &self.rgba
    }

    /// Returns the number of pixels that were solved.
    pub fn count(&self) -> usize {
        self.pixels.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subject::phantom_subject;

    #[test]
    fn what_is_no_number_is_infinitely_wrong() {
        let subject = phantom_subject("fog", 4, [2, 1]).unwrap();
        let view = (&subject.scene, &subject.view);
        let exact = ReferencePixels::solve(view, &Model::Canonical, vec![[0, 0], [1, 0]], &Control::default()).unwrap();
        let [r, g, b, a] = exact.rgba()[1].map(|x| x as f32);
        let frame = Frame::new([2, 1], vec![[f32::NAN, 0.0, 0.0, 0.0], [r, g - 0.25, b, a]], None);
        let errors = exact.errors(&frame);
        assert_eq!(errors[0], f64::INFINITY);
        assert!((errors[1] - 0.25).abs() < 1e-6 && (exact.signed(&frame)[1][1] + 0.25).abs() < 1e-6);
    }
}
