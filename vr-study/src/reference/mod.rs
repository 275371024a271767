//! Reference pixels, and the distance of a picture from them.

mod cache;
mod fingerprint;
mod noise_account;
mod scattered;

use std::sync::Arc;
use std::time::Duration;

use vr_core::clock::Instant;
use vr_core::phantom::Phantom;
use vr_core::{Control, Frame, Model, RenderError, Scene, Uncertainty, View};
use vr_physics::metrics::Metrics;
use vr_physics::{Certainty, Reference, Solution, spread};

use crate::error_colors;

pub use cache::ReferenceCache;
pub(crate) use fingerprint::fingerprint;
pub use fingerprint::frame_fingerprint;
pub use noise_account::NoiseAccount;

/// Number of parts along each side of a picture, of each of which a pixel is compared, where not every pixel is.
pub const SUBGRID: u32 = 64;

/// Number of standard errors given as the error of a reference by random paths.
const LIKELY_ERRORS: f64 = 4.0;
/// Number of standard errors above which a difference is significant.
const SIGNIFICANT_ERRORS: f64 = 3.0;

/// Reference of some pixels of a view.
#[derive(Clone, Debug)]
pub struct ReferencePixels {
    pixels: Vec<[u32; 2]>,
    rgba: Vec<[f64; 4]>,
    /// Standard errors of means over random paths; `None` for a deterministic solution.
    noise: Option<Vec<[f64; 4]>>,
    /// Largest error of the reference itself, proven or estimated.
    pub certainty: Certainty,
    /// Time that it took to solve them, or to read them.
    pub time: Duration,
}

impl ReferencePixels {
    /// Solves pixels of a view in f64. The correct pixels of a scene that scatters are means over random paths, with noise that is known.
    ///
    /// # Errors
    /// A view that makes no sense, a scene that the renderer `light` refuses if it scatters, or cancellation.
    pub fn solve(
        (scene, view): (&Scene, &View),
        model: &Model,
        pixels: Vec<[u32; 2]>,
        control: &Control,
    ) -> Result<Self, RenderError> {
        Self::solve_by(&Reference::default(), (scene, view), model, pixels, control)
    }

    /// Does what [`Self::solve`] does, by a reference of a tolerance of its own.
    ///
    /// # Errors
    /// Those of [`Self::solve`].
    pub fn solve_by(
        reference: &Reference,
        (scene, view): (&Scene, &View),
        model: &Model,
        pixels: Vec<[u32; 2]>,
        control: &Control,
    ) -> Result<Self, RenderError> {
        if scene.scattering.is_some() && matches!(model, Model::Canonical) {
            return scattered::solve((scene, view), pixels, control);
        }
        let start = Instant::now();
        let solution = reference.solve_pixels(scene, view, model, &pixels, control)?;
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
            noise: None,
            certainty: solution.certainty(),
            pixels,
            time: start.elapsed(),
        }
    }

    /// Reference of pixels from means over random paths and their standard errors.
    ///
    /// # Panics
    /// Panics if the lists have different lengths.
    pub fn of_means(
        pixels: Vec<[u32; 2]>,
        rgba: Vec<[f64; 4]>,
        standard_errors: Vec<[f64; 4]>,
        time: Duration,
    ) -> Self {
        assert!(
            pixels.len() == rgba.len() && pixels.len() == standard_errors.len(),
            "a mean and an error for each pixel"
        );
        let largest = standard_errors.iter().flatten().fold(0.0, |max: f64, &e| max.max(e));
        let certainty = Certainty::Estimate(LIKELY_ERRORS * largest);
        Self { pixels, rgba, noise: Some(standard_errors), certainty, time }
    }

    /// Returns the error of a frame of the same view. RMSE and PSNR are free of the noise of a reference by random paths
    /// ([`NoiseAccount`]); the largest error, its percentile and the bias are those of differences as they are.
    pub fn judge(&self, frame: &Frame) -> Metrics {
        self.judge_with_noise(frame).0
    }

    /// Returns the error of a frame of the same view, and its parts where the reference has noise.
    pub(crate) fn judge_with_noise(&self, frame: &Frame) -> (Metrics, Option<NoiseAccount>) {
        let drawn: Vec<[f32; 4]> = self.pixels.iter().map(|&[x, y]| frame.pixel(x, y)).collect();
        let metrics = Metrics::of(&self.rgba, &drawn);
        match self.noise_account(frame) {
            Some(account) => {
                let rmse = account.rmse;
                (Metrics { rmse, psnr: -20.0 * libm::log10(rmse), ..metrics }, Some(account))
            }
            None => (metrics, None),
        }
    }

    /// Splits the error of a frame of the same view into noise and bias; `None` for a reference without noise.
    pub fn noise_account(&self, frame: &Frame) -> Option<NoiseAccount> {
        NoiseAccount::new(self, frame)
    }

    /// Returns the [errors](Self::errors) of pixels, and NaN where no component differs by more than three standard errors of the reference and
    /// the frame together: chance alone makes such differences.
    pub fn significant_errors(&self, frame: &Frame) -> Vec<f64> {
        let errors = self.errors(frame);
        let Some(noise) = &self.noise else { return errors };
        let own = standard_errors(frame);
        let (scale, width) = (self.scale(), frame.size()[0] as usize);
        let signed = self.signed(frame);
        let significant = |i: usize| {
            let [x, y] = self.pixels[i];
            let own = own.map_or([0.0; 4], |own| own[y as usize * width + x as usize].map(f64::from));
            let together: [f64; 4] = std::array::from_fn(|c| noise[i][c].hypot(own[c]) / scale);
            let limit = |c: usize| SIGNIFICANT_ERRORS * together[c] + f64::from(f32::EPSILON);
            // What is no number is significant, and so is everything where there is no noise.
            together == [0.0; 4] || (0..4).any(|c| signed[i][c].is_nan() || signed[i][c].abs() > limit(c))
        };
        errors.into_iter().enumerate().map(|(i, e)| if significant(i) { e } else { f64::NAN }).collect()
    }

    /// True if it is made of means over random paths.
    pub fn has_noise(&self) -> bool {
        self.noise.is_some()
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

    /// Returns the [significant error](Self::significant_errors) of every pixel, row by row, where one pixel of each part of the [`subgrid`](vr_physics::metrics::subgrid) of `parts` was
    /// solved: interpolated on the logarithmic scale that errors are drawn in.
    pub fn error_map(&self, frame: &Frame, parts: u32) -> Vec<f64> {
        let (low, high) = error_colors::DECADES;
        // Beyond the scale there is one colour.
        let exponent = |error: f64| [error.log10().clamp(low.into(), high.into())];
        let exponents: Vec<[f64; 1]> = self.significant_errors(frame).into_iter().map(exponent).collect();
        spread(parts, frame.size(), &exponents).into_iter().map(|[e]| 10f64.powf(e)).collect()
    }

    /// Returns the certainty in words: `within 1e-10`, or that it is an estimate.
    pub fn certainty_text(&self) -> String {
        if let Some(noise) = &self.noise {
            let squares: f64 = noise.iter().flatten().map(|e| e * e).sum();
            let rms = (squares / (4 * noise.len()).max(1) as f64).sqrt();
            return format!("random paths with a standard error of {rms:.2e}, subtracted from RMSE");
        }
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

/// Returns the standard errors of a frame drawn by random paths, pixel by pixel; `None` of any other.
fn standard_errors(frame: &Frame) -> Option<&[[f32; 4]]> {
    match frame.uncertainty() {
        Some(Uncertainty::StandardError(errors)) => Some(errors),
        _ => None,
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
