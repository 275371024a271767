//! Pixels with their errors.

use vr_core::image_order::PixelValue;

/// Light of a ray, or of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightPixel {
    /// Premultiplied linear light, and opacity.
    pub rgba: [f64; 4],
    /// Bound or estimate of the error of a component.
    pub error: f64,
    /// World distance to where half of the light behind is gone; +∞ where less is.
    pub depth: f64,
}

impl PixelValue for LightPixel {
    fn mean(values: &[Self]) -> Self {
        let mean = |of: &dyn Fn(&Self) -> f64| values.iter().map(of).sum::<f64>() / values.len() as f64;
        Self {
            rgba: std::array::from_fn(|c| mean(&|v| v.rgba[c])),
            error: mean(&|v| v.error),
            depth: values.iter().map(|v| v.depth).fold(f64::INFINITY, f64::min),
        }
    }
}
