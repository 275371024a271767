//! Error of a picture against a reference that has noise of its own.

use std::fmt;

use serde::{Deserialize, Serialize};
use vr_core::Frame;

use super::{ReferencePixels, standard_errors};

/// Quantile of the normal distribution for intervals of 95 %.
const QUANTILE: f64 = 1.959_964;

/// Error of a picture against means over random paths, and the parts of it: noise of the picture, and bias.
///
/// A mean t̂ with the variance s² about the correct value t has E[(a − t̂)²] = (a − t)² + s² for every picture a that is independent of it: s² is
/// subtracted. All numbers are in units of [`ReferencePixels::scale`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseAccount {
    /// Root mean square error, less the noise of the reference; 0 where the noise hides it.
    pub rmse: f64,
    /// Interval that holds it with a confidence of 95 %.
    pub interval: [f64; 2],
    /// Noise of the reference: RMS of its standard errors.
    pub reference_noise: f64,
    /// Noise of the picture, where it is drawn by random paths: RMS of its standard errors, part of its error.
    pub picture_noise: Option<f64>,
    /// Largest RMS error that is not noise of the picture, with the same confidence.
    pub bias_bound: f64,
}

impl NoiseAccount {
    /// Splits the error of a frame; `None` for a reference without noise.
    pub fn new(reference: &ReferencePixels, frame: &Frame) -> Option<Self> {
        let noise = reference.noise.as_ref()?;
        let scale = reference.scale();
        let own = standard_errors(frame);
        let width = frame.size()[0] as usize;
        // Components of a pixel share paths; pixels have paths of their own, and are the independent samples.
        let count = reference.pixels.len().max(1) as f64;
        let (mut reference_squares, mut own_squares) = (0.0, 0.0);
        // Unbiased estimates of the squared error of each pixel, whole and without the picture's own noise.
        let mut whole = Vec::with_capacity(reference.pixels.len());
        let mut biases = Vec::with_capacity(reference.pixels.len());
        for ((&[x, y], signed), errors) in reference.pixels.iter().zip(reference.signed(frame)).zip(noise) {
            let square = |e: &f64| e * e / 4.0;
            let variance: f64 = errors.iter().map(|s| square(&(s / scale))).sum();
            let pixel = y as usize * width + x as usize;
            let own: f64 = own.map_or(0.0, |own| own[pixel].iter().map(|&s| square(&(f64::from(s) / scale))).sum());
            let error = signed.iter().map(square).sum::<f64>() - variance;
            reference_squares += variance;
            own_squares += own;
            whole.push(error);
            biases.push(error - own);
        }
        let [low, middle, high] = mean_interval(&whole);
        let [_, _, bias] = mean_interval(&biases);
        let root = |square: f64| if square.is_nan() { f64::INFINITY } else { square.max(0.0).sqrt() };
        Some(Self {
            rmse: root(middle),
            interval: [root(low), root(high)],
            reference_noise: root(reference_squares / count),
            picture_noise: own.map(|_| root(own_squares / count)),
            bias_bound: root(bias),
        })
    }
}

impl NoiseAccount {
    /// RMS error that is not noise of the picture: an estimate, 0 where noise hides it.
    pub fn bias(&self) -> f64 {
        let own = self.picture_noise.unwrap_or(0.0);
        (self.rmse * self.rmse - own * own).max(0.0).sqrt()
    }
}

impl fmt::Display for NoiseAccount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rmse, interval: [low, high], reference_noise, picture_noise, bias_bound } = self;
        write!(f, "RMSE {rmse:.2e} (95 %: {low:.2e} to {high:.2e}), ")?;
        match picture_noise {
            Some(noise) => write!(f, "noise {noise:.2e}, ")?,
            None => f.write_str("no noise, ")?,
        }
        write!(f, "bias at most {bias_bound:.2e}; noise of the reference {reference_noise:.2e}")
    }
}

/// Returns the lower end of the 95 % interval of a mean, the mean, and the upper end. Differences between pixels count as noise, too, which makes the
/// interval wider, never narrower.
fn mean_interval(samples: &[f64]) -> [f64; 3] {
    let count = samples.len().max(1) as f64;
    let mean = samples.iter().sum::<f64>() / count;
    let squares: f64 = samples.iter().map(|x| (x - mean).powi(2)).sum();
    // One sample tells nothing of the spread.
    let half = if samples.len() < 2 { f64::INFINITY } else { QUANTILE * (squares / (count - 1.0) / count).sqrt() };
    [mean - half, mean, mean + half]
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use vr_core::Uncertainty;

    use super::*;

    /// Sum of twelve uniform numbers less 6: mean 0, variance 1, nearly normal. Their bits are those of SplitMix64.
    fn normal(state: &mut u64) -> f64 {
        let mut unit = || {
            *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| unit()).sum::<f64>() - 6.0
    }

    #[test]
    fn intervals_hold_the_error_and_noise_is_no_bias() {
        let (size, mut random) = ([16, 16], 5);
        let (noise, own, bias) = (0.02, 0.03, 0.01);
        let pixels: Vec<[u32; 2]> = (0..256).map(|i| [i % 16, i / 16]).collect();
        let (mut held, mut bounded) = (0, 0);
        for _ in 0..400 {
            let rgba = pixels.iter().map(|_| [0; 4].map(|_| 0.5 + noise * normal(&mut random))).collect();
            let reference = ReferencePixels::of_means(pixels.clone(), rgba, vec![[noise; 4]; 256], Duration::ZERO);
            let drawn: Vec<[f32; 4]> =
                pixels.iter().map(|_| [0; 4].map(|_| (0.5 + bias + own * normal(&mut random)) as f32)).collect();
            // The error of this very picture, which the reference does not know.
            let squares: f64 = drawn.iter().flatten().map(|&c| (f64::from(c) - 0.5).powi(2)).sum();
            let rmse = (squares / 1024.0).sqrt();
            let frame =
                Frame::new(size, drawn, None).with_uncertainty(Uncertainty::StandardError(vec![[own as f32; 4]; 256]));
            let account = NoiseAccount::new(&reference, &frame).unwrap();
            held += usize::from((account.interval[0]..=account.interval[1]).contains(&rmse));
            bounded += usize::from(bias <= account.bias_bound);
            assert!((account.reference_noise - noise).abs() < 1e-9);
            assert!((account.picture_noise.unwrap() - own).abs() < 1e-7);
        }
        // 95 % of 400 are 380, with a standard deviation of 4.4: four of these below. The bound of the bias is one-sided, and holds in 97.5 %.
        assert!(held >= 362 && bounded >= 377, "{held} {bounded}");
    }

    #[test]
    fn one_pixel_tells_nothing_of_its_own_spread() {
        let frame = Frame::new([1, 1], vec![[0.0; 4]], None);
        let of = |errors| ReferencePixels::of_means(vec![[0, 0]], vec![[0.0; 4]], vec![errors], Duration::ZERO);
        let account = of([0.1; 4]).noise_account(&frame).unwrap();
        assert_eq!((account.rmse, account.interval, account.picture_noise), (0.0, [0.0, f64::INFINITY], None));
    }
}
