//! Steps by the range of values around, where no map tells them.

use vr_core::Scene;

use super::classes::{LEVELS, LevelVariations, class_of, step_of};

/// Steps as long as what is around allows, by the rule of [`StepMap`](super::StepMap): for fields whose parts, of any size, tell the range of their values.
/// A step ends with its part; so that none leads into another, shorter or not.
pub(crate) struct RangeSteps {
    variations: LevelVariations,
    /// Variation over each range of levels, negative where nothing can be seen.
    table: Vec<f32>,
    low: f64,
    levels_per_value: f64,
    error: f64,
}

impl std::fmt::Debug for RangeSteps {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RangeSteps").field("error", &self.error).finish_non_exhaustive()
    }
}

impl RangeSteps {
    /// Makes the steps for a scene whose values lie between two, for an error of the picture to aim at.
    pub(crate) fn new(scene: &Scene, (low, high): (f64, f64), error: f64) -> Self {
        let last = (LEVELS - 1) as f64;
        let span = if high > low { high - low } else { 1.0 };
        let variations = LevelVariations::new(scene, None, |level| low + span * (level as f64 / last));
        let mut table = vec![-1.0; LEVELS * LEVELS];
        variations.each_range(
            |_, _| true,
            |low, high, variation| {
                table[low * LEVELS + high] = variation.map_or(-1.0, |variation| variation as f32);
            },
        );
        Self { variations, table, low, levels_per_value: last / span, error }
    }

    /// Returns the world length of a step in a part of so many cells along an edge, each of a world length, between two values.
    pub(crate) fn length(&self, range: [f32; 2], spacing: f64, edge: f64) -> f64 {
        let level = |value: f32| (f64::from(value) - self.low) * self.levels_per_value;
        // `as` saturates.
        let (low, high) = (level(range[0]).floor() as usize, level(range[1]).ceil() as usize);
        let (low, high) = (low.min(LEVELS - 1), high.clamp(low.min(LEVELS - 1), LEVELS - 1));
        let variation = f64::from(self.table[low * LEVELS + high].max(0.0));
        let voxels = self.variations.longest_step(variation, [low, high], (spacing, edge), self.error);
        spacing * step_of(usize::from(class_of(voxels)))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vr_core::field::FunctionField;
    use vr_core::{ControlPoint, OpacityRule, TransferFunction, Volume};

    use super::*;

    #[test]
    fn steps_are_short_where_the_medium_changes() {
        let field = FunctionField::new((glam::DVec3::ZERO, glam::DVec3::ONE), |p| p.x).unwrap();
        let point = |value, opacity| ControlPoint::new(value, [1.0; 3], opacity);
        let points = vec![point(0.0, 0.0), point(0.5, 0.0), point(1.0, 0.9)];
        let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        let scene = Scene::new(Volume::Field(Arc::new(field)), transfer);
        let steps = RangeSteps::new(&scene, (0.0, 1.0), 5e-4);
        let length = |range: [f32; 2], spacing: f64| steps.length(range, spacing, 8.0);
        assert!(
            length([0.6, 0.7], 1.0) < length([0.6, 0.62], 1.0) && length([0.6, 0.62], 1.0) < length([0.1, 0.4], 1.0)
        );
        assert!(length([0.5, 1.0], 2.0) > length([0.5, 1.0], 1.0), "saturated");
        // Beyond the levels, and the wrong way round: some length, and no panic.
        assert!(length([f32::NEG_INFINITY, f32::INFINITY], 1.0) > 0.0 && length([2.0, -1.0], 1.0) > 0.0);
    }
}
