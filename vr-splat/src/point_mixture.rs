//! Values and colours of points that are averaged: sheets sum their weights as well, and other sums are divided by these.

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

/// Places of a mixture's sums among the channels of a sheet. The first three are those of every sheet of points: the sum of values, and what is covered.
#[derive(Clone, Copy)]
pub(crate) struct MixtureChannels {
    /// Gradient of the sum of values (3), where light depends on it.
    pub(crate) slope: usize,
    /// Sum of weights.
    pub(crate) weight: usize,
    /// Sums of red, green and blue.
    pub(crate) color: usize,
    /// Gradient of the sum of weights (3), where light depends on that of a mean.
    pub(crate) thinning: usize,
    /// Value that those of a mean are differences from, where light depends on its gradient.
    pub(crate) base: usize,
    /// Number of channels.
    pub(crate) count: usize,
}

impl MixtureChannels {
    /// Number of channels where no light depends on gradients.
    pub(crate) const PLAIN: usize = Self::new(false, false).count;
    /// Number of channels of a mean where light depends on its gradient.
    pub(crate) const SLOPED_MEAN: usize = Self::new(true, true).count;

    /// Channels with gradients, or without, of a mean or a sum.
    #[inline(always)]
    pub(crate) const fn new(sloped: bool, is_mean: bool) -> Self {
        let weight = if sloped { 6 } else { 3 };
        let thinning = weight + 4;
        // Gradient of weights, base, and the largest weight so far.
        let count = if sloped && is_mean { thinning + 5 } else { thinning };
        Self { slope: 3, weight, color: weight + 1, thinning, base: thinning + 3, count }
    }
}

/// Kernel that points have at least in their supports, as a part of its integral: where f32 loses a section at the edge of a support, the mean is still one.
pub(crate) const MIN_KERNEL: f32 = 1e-6;

/// The same of the cubic spline, whose sections keep their digits there: its value where f32 no longer tells a place from the edge.
pub(crate) const MIN_RIM_KERNEL: f32 = 1e-20;

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
