//! What a ray becomes.

use vr_core::Layer;
use vr_core::image_order::PixelValue;

/// Premultiplied RGBA, and the world distance from the ray's origin to what it shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RayValue {
    pub(crate) rgba: [f64; 4],
    /// +∞: nothing.
    pub(crate) depth: f64,
}

impl RayValue {
    /// A ray that meets nothing.
    pub(crate) const NOTHING: Self = Self { rgba: [0.0; 4], depth: f64::INFINITY };

    /// The volume before an opaque layer: what it leaves of the view is filled, and the eye rests at the layer at the latest.
    pub(crate) fn over(self, layer: &Layer, pixel: usize) -> Self {
        Self { rgba: layer.under(pixel, self.rgba), depth: self.depth.min(layer.depth(pixel)) }
    }
}

impl PixelValue for RayValue {
    /// The mean colour, the smallest depth.
    fn mean(values: &[Self]) -> Self {
        let share = 1.0 / values.len() as f64;
        let sum = |c: usize| values.iter().map(|v| v.rgba[c]).sum::<f64>() * share;
        let depth = values.iter().map(|v| v.depth).fold(f64::INFINITY, f64::min);
        Self { rgba: std::array::from_fn(sum), depth }
    }
}
