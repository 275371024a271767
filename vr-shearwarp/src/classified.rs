//! Tables that follow from the transfer function.

use vr_core::optics::{depth_of_opacity, opacity_of_depth};
use vr_core::{Classification, Compositing, Filter, GridVolume, OpacityRule, Scene};
use vr_kernels::ranges::VisibleValues;

use crate::codes::Codes;
use crate::encode::{Rule, VisibleLevels};
use crate::optics::Optics;
use crate::shear_warp::ShearWarp;
use crate::steepness::{Steepness, optics};

/// Tables that follow from the transfer function.
pub(crate) struct Classified {
    pub(crate) visibility: VisibleLevels,
    /// Light and opacity by the value alone; where opacity follows the gradient, an upper bound of it.
    pub(crate) optics: Optics,
    /// The medium by the length of the gradient.
    pub(crate) media: Steepness,
}

impl Classified {
    pub(crate) fn new(renderer: &ShearWarp, scene: &Scene, volume: &GridVolume, codes: &Codes) -> Self {
        let calibration = volume.calibration();
        let transfer = &scene.transfer;
        // A code stands for what rounds to it.
        let around = if volume.voxel_type().is_integer() { 0.0 } else { 0.5 * codes.spacing };
        // The opacity of a unit distance at which a voxel has that of the threshold.
        let voxels = transfer.unit_distance() / scene.volume.mean_spacing();
        // A factor on the extinction may be larger than 1.
        let factor = scene.shading.as_ref().map_or(1.0, |shading| shading.largest_modulation());
        let depth = depth_of_opacity(renderer.opacity_threshold) * voxels / factor.max(1.0);
        let opacity = if transfer.rule() == OpacityRule::Power { opacity_of_depth(depth) } else { depth };
        let values = VisibleValues::above(transfer, opacity);
        let visible = |from: f64, to: f64| {
            let ends = [calibration.value(from - around), calibration.value(to + around)];
            match scene.compositing {
                Compositing::First { threshold } => ends[0].max(ends[1]) >= threshold,
                _ => values.shows(ends[0], ends[1]),
            }
        };
        let (low, high) = volume.value_stats().range.unwrap_or_default();
        let visibility = VisibleLevels::new((low.into(), high.into()), volume.voxel_type().is_integer(), visible);
        let optics = optics(transfer, calibration, codes, renderer.classification);
        let media = Steepness::new(scene, volume, codes, renderer.classification);
        Self { visibility, optics, media }
    }
}

impl Classified {
    /// Rule for the cells that a scene shows.
    pub(crate) fn rule(&self, renderer: &ShearWarp, scene: &Scene, filter: Filter) -> Rule<'_> {
        match (scene.compositing, renderer.classification) {
            (Compositing::Maximum | Compositing::Minimum | Compositing::Average, _) => Rule::Everything,
            // Values of the nearest voxels are those of corners.
            _ if filter == Filter::Nearest => Rule::Classified(&self.visibility),
            (Compositing::First { .. }, _) | (_, Classification::Post) => Rule::Interpolated(&self.visibility),
            (_, Classification::Pre) => Rule::Classified(&self.visibility),
        }
    }
}
