//! Pixels with their errors.

use vr_core::image_order::PixelValue;

/// Light of a ray, or of a pixel, with the error of each component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightPixel {
    /// Premultiplied linear light, and opacity.
    pub rgba: [f64; 4],
    /// Standard error of each component, or a bound of its error.
    pub error: [f64; 4],
    /// True if the errors are those of random numbers, which grow less in a mean.
    pub random: bool,
    /// World distance to where half of the light behind is gone; +∞ where less is.
    pub depth: f64,
}

impl PixelValue for LightPixel {
    fn mean(values: &[Self]) -> Self {
        let n = values.len() as f64;
        let mean = |of: &dyn Fn(&Self) -> f64| values.iter().map(of).sum::<f64>() / n;
        let random = values[0].random;
        let error = |c: usize| match random {
            true => (mean(&|v| v.error[c] * v.error[c]) / n).sqrt(),
            false => mean(&|v| v.error[c]),
        };
        Self {
            rgba: std::array::from_fn(|c| mean(&|v| v.rgba[c])),
            error: std::array::from_fn(error),
            random,
            depth: values.iter().map(|v| v.depth).fold(f64::INFINITY, f64::min),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_falls_in_a_mean_and_bounds_do_not() {
        let pixel = |random| LightPixel { rgba: [1.0; 4], error: [0.2; 4], random, depth: 1.0 };
        assert!((LightPixel::mean(&[pixel(true); 4]).error[0] - 0.1).abs() < 1e-15);
        assert!((LightPixel::mean(&[pixel(false); 4]).error[0] - 0.2).abs() < 1e-15);
    }
}
