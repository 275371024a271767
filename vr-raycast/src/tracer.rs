//! Interface between the choice of rays and the engines that trace them.

use vr_core::image_order::ImageSample;
use vr_core::{Counts, Layer};

use crate::ray_value::RayValue;

/// Engine that traces rays: the plain one, the vector one, or the one with an error bound.
pub(crate) trait Tracer: Sync {
    /// Traces the rays through `spots`, in any number and order (neighbours in blocks of 4×4 run fastest), and appends one value for each.
    ///
    /// `starts`, where given, has for each ray a step of its lattice before which nothing is visible.
    fn trace(&self, spots: &[ImageSample], starts: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts);

    /// True if rays through the pixels from `low` to `high`, both included, are known to show nothing.
    fn is_clear(&self, _low: [u32; 2], _high: [u32; 2]) -> bool {
        false
    }
}

/// Result of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RaySample {
    /// Premultiplied linear RGBA.
    pub(crate) rgba: [f32; 4],
    /// World distance from the ray's origin to what is seen; +∞ if nothing is.
    pub(crate) depth: f32,
}

impl RaySample {
    /// Result of a ray that meets nothing.
    pub(crate) const NOTHING: Self = Self { rgba: [0.0; 4], depth: f32::INFINITY };

    /// Puts the ray before an opaque layer: the layer fills the light that it leaves, and its depth is the layer's at most.
    pub(crate) fn over(self, layer: &Layer, pixel: usize) -> Self {
        let rgba = layer.under(pixel, self.rgba.map(f64::from)).map(|x| x as f32);
        Self { rgba, depth: self.depth.min(layer.depth(pixel) as f32) }
    }

    /// Returns the mean colour of at least one value, and the smallest depth.
    pub(crate) fn mean(values: &[Self]) -> Self {
        if let [one] = values {
            return *one;
        }
        let share = 1.0 / values.len() as f64;
        let sum = |c: usize| values.iter().map(|v| f64::from(v.rgba[c])).sum::<f64>() * share;
        let depth = values.iter().map(|v| v.depth).fold(f32::INFINITY, f32::min);
        Self { rgba: std::array::from_fn(|c| sum(c) as f32), depth }
    }
}

impl From<RayValue> for RaySample {
    fn from(value: RayValue) -> Self {
        Self { rgba: value.rgba.map(|x| x as f32), depth: value.depth as f32 }
    }
}
