//! What points carry where their field is a mean, or they have colours: sheets hold the sums of weights besides, by which sums are divided.

use vr_core::{PointMixing, PointSet};

/// Values and colours of the points that can be seen, and the channels of sheets that they need.
pub(crate) struct PointMixture {
    /// Value, less the smallest of all where it is a mean's, and red, green and blue of each visible point.
    pub(crate) rows: Vec<[f32; 4]>,
    /// True if values are divided by weights.
    pub(crate) is_mean: bool,
    /// True if light is multiplied by the mean of colours.
    pub(crate) has_colors: bool,
}

/// Channels of a sheet of a mixture without gradients: the sum of values, what is covered (2), the sum of weights, those of colours (3).
pub(crate) const PLAIN_CHANNELS: usize = 7;
/// Channels with gradients: those of the values' sum come fourth (3), those of the weights' last (3).
pub(crate) const SLOPED_CHANNELS: usize = 13;

/// Kernel that points have at least in their supports, as a part of its integral: where f32 loses a section at the edge of a support, the mean is still one.
pub(crate) const MIN_KERNEL: f32 = 1e-6;

/// Gradient of a mean, as a part of the two that it is the difference of, below which it is one of rounding: there is none where one point reaches alone.
pub(crate) const MIN_SLOPE: f32 = 4e-6;

impl PointMixture {
    /// The mixture of visible points; `None` where the field is a sum and there are no colours.
    pub(crate) fn new(points: &PointSet, visible: &[u32]) -> Option<Self> {
        let (is_mean, colors) = (points.mixing() == PointMixing::Mean, points.colors());
        if !is_mean && colors.is_none() {
            return None;
        }
        let low = smallest_mean(points).unwrap_or(0.0);
        let row = |&k: &u32| {
            let [r, g, b] = colors.map_or([1.0; 3], |colors| colors[k as usize]);
            [(f64::from(points.values()[k as usize]) - low) as f32, r, g, b]
        };
        Some(Self { rows: visible.iter().map(row).collect(), is_mean, has_colors: colors.is_some() })
    }
}

/// Smallest value of a mean, from which values count: sums of small numbers round less, and a constant stays one. `None` of sums.
pub(crate) fn smallest_mean(points: &PointSet) -> Option<f64> {
    let low = || points.values().iter().fold(f32::INFINITY, |low, &v| low.min(v));
    (points.mixing() == PointMixing::Mean).then(|| f64::from(low()))
}
