//! RMSE of a picture, and an upper bound of it.

use vr_core::Frame;

use crate::reference::ReferencePixels;

/// RMSE of a picture, known or estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RmseEstimate {
    /// RMSE of the pixels that were compared, weighted so that it stands for all.
    pub rmse: f64,
    /// Largest RMSE that the whole picture may have: proven, or with a confidence of [`CONFIDENCE`](super::CONFIDENCE).
    pub upper: f64,
    /// Number of pixels that were compared.
    pub pixels: usize,
    /// True if `upper` is proven: every pixel was compared with one of which the error is bounded.
    pub proven: bool,
}

/// Quantile of the normal distribution for a confidence of 95 %.
pub(super) const QUANTILE: f64 = 1.645;

impl RmseEstimate {
    /// Estimates the RMSE from the reference at a sample of a frame's pixels that is spread evenly, by the normal distribution of means: good enough to
    /// choose what is worth a closer look. Errors in a few pixels alone, none of them in the sample, go unseen. If the sample holds all pixels, the
    /// bound is proven.
    pub fn of_sample(reference: &ReferencePixels, frame: &Frame) -> Self {
        let squares = squares(reference, frame);
        let [mean, variance] = mean_and_variance(&squares);
        let n = squares.len() as f64;
        let all = f64::from(frame.size()[0]) * f64::from(frame.size()[1]);
        let left = (1.0 - n / all).max(0.0);
        let spread = if left > 0.0 { QUANTILE * (variance / n * left).sqrt() } else { 0.0 };
        Self { proven: left == 0.0, ..Self::of_reference([mean, mean + spread], reference) }
    }

    /// Makes the estimate from a mean of squares and an upper bound of that mean, by pixels of the reference.
    pub(super) fn of_reference(means: [f64; 2], reference: &ReferencePixels) -> Self {
        let error = reference.certainty.value() / reference.scale();
        Self::of_means(means, (1.0, error), reference.count())
    }

    /// Makes the estimate from a mean of squares and an upper bound of that mean, by so many pixels. Their errors are in units of `1 / scale`, and they are known to within `error`.
    pub(super) fn of_means([mean, upper]: [f64; 2], (scale, error): (f64, f64), pixels: usize) -> Self {
        let upper = upper.sqrt() / scale + error;
        // Infinite errors leave no mean of squares.
        let upper = if upper.is_nan() { f64::INFINITY } else { upper };
        Self { rmse: mean.sqrt() / scale, upper, pixels, proven: false }
    }

    /// Estimates the RMSE from a picture of the same view of which every pixel is within `error` of the correct one, in units of max(1, the largest
    /// magnitude): the triangle inequality of root mean squares, over all pixels.
    pub fn against(frame: &Frame, proven: &Frame, error: f64) -> Self {
        let scale = scale_of(proven.pixels(), error);
        let pairs = frame.pixels().iter().zip(proven.pixels());
        let square =
            |(a, b): (&[f32; 4], &[f32; 4])| mean_square(std::array::from_fn(|c| f64::from(a[c]) - f64::from(b[c])));
        let pixels = frame.pixels().len();
        let rmse = (pairs.map(square).sum::<f64>() / pixels as f64).sqrt() / scale;
        Self { rmse, upper: rmse + error, pixels, proven: true }
    }
}

/// Returns the mean of a sample, and the variance of what it is drawn from; 0 where one number tells none.
pub(super) fn mean_and_variance(sample: &[f64]) -> [f64; 2] {
    let n = sample.len() as f64;
    let mean = sample.iter().sum::<f64>() / n;
    [mean, sample.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0)]
}

/// Returns the unit of a picture's errors, of which some pixels are known to within `error`: its largest magnitude is at least this, or 1.
pub(super) fn scale_of(pixels: &[[f32; 4]], error: f64) -> f64 {
    let peak = pixels.iter().flatten().map(|c| f64::from(c.abs())).fold(1.0, f64::max);
    (peak * (1.0 - error)).max(1.0)
}

/// Returns the mean square of the components' errors, for each pixel that was solved.
pub(super) fn squares(reference: &ReferencePixels, frame: &Frame) -> Vec<f64> {
    reference.signed(frame).into_iter().map(mean_square).collect()
}

/// Returns the mean square of a pixel's errors; infinite if one is NaN.
pub(super) fn mean_square(errors: [f64; 4]) -> f64 {
    let square = errors.iter().map(|c| c * c).sum::<f64>() / 4.0;
    if square.is_nan() { f64::INFINITY } else { square }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subject::phantom_subject;
    use vr_core::{Control, Model};
    use vr_physics::metrics::subgrid;

    #[test]
    fn all_pixels_leave_nothing_to_guess() {
        let subject = phantom_subject("fog", 8, [6, 5]).unwrap();
        let all = subgrid(u32::MAX, subject.view.size);
        let view = (&subject.scene, &subject.view);
        let reference = ReferencePixels::solve(view, &Model::Canonical, all, &Control::default()).unwrap();
        let frame = Frame::new([6, 5], vec![[0.5; 4]; 30], None);
        let estimate = RmseEstimate::of_sample(&reference, &frame);
        assert!((estimate.rmse - reference.judge(&frame).rmse).abs() < 1e-12 && estimate.upper - estimate.rmse < 1e-9);
        assert!(estimate.proven);
    }

    #[test]
    fn a_proven_picture_bounds_every_pixel() {
        let proven = Frame::new([10, 10], vec![[0.25; 4]; 100], None);
        let mut pixels = vec![[0.25; 4]; 100];
        assert_eq!(RmseEstimate::against(&Frame::new([10, 10], pixels.clone(), None), &proven, 1e-4).upper, 1e-4);
        // One pixel in a hundred, wherever it is.
        pixels[37] = [0.75; 4];
        let estimate = RmseEstimate::against(&Frame::new([10, 10], pixels.clone(), None), &proven, 1e-4);
        assert!((estimate.rmse - 0.05).abs() < 1e-12 && (estimate.upper - 0.0501).abs() < 1e-12, "{estimate:?}");
        pixels[3] = [f32::NAN; 4];
        assert_eq!(RmseEstimate::against(&Frame::new([10, 10], pixels, None), &proven, 1e-4).upper, f64::INFINITY);
    }
}
