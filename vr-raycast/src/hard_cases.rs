//! What the hard cases of `vr-physics` may cost: the largest errors that the caster's documentation allows itself.

use vr_core::Filter;

use crate::caster::{RayCaster, Rule, Screen, Step, Traversal};

/// Steps of which every bound is known; shorter ones are no worse.
const FINE: f64 = 0.2;

impl RayCaster {
    /// See [`vr_core::Renderer::hard_case_error`]: measured errors, and half as much again. What is promised is known, and so are the
    /// errors of trilinear fields under the midpoint rule; nothing is documented of other settings.
    pub(crate) fn documented_error(&self, case: &str) -> Option<f64> {
        let plain = Self { step: self.step, precision: self.precision, ..Self::default() };
        let comparable = Self {
            order: plain.order,
            leaping: plain.leaping,
            classification: plain.classification,
            vector: plain.vector,
            filter: self.filter.filter(|&f| f != Filter::Trilinear),
            ..self.clone()
        };
        let midpoint = comparable == plain && self.rule == Rule::Midpoint && self.traversal == Traversal::Samples;
        match self.step {
            Step::Tolerance(error) if self.screen == Screen::EveryPixel => Some(error),
            Step::Uniform(step) if midpoint && step <= FINE => of_fine_steps(case),
            Step::Auto | Step::Local { error: Step::ERROR } if midpoint => of_default_steps(case),
            _ => None,
        }
    }
}

/// Uniform steps of ⅕.
fn of_fine_steps(case: &str) -> Option<f64> {
    Some(match case {
        // The wall's place is known to a step, and where a ray just passes it or just not, all of it is at stake.
        "opaque-wall" => 0.8,
        // A hundredth of a step wide: most rays that cross it at a right angle never see it.
        "thin-shell" => 0.75,
        // 33³ samples under a transfer function that a ray crosses in half a voxel.
        "marschner-lobb" => 2e-2,
        // Faces of vacuum are known to a step.
        "missing-voxels" => 4e-2,
        // Ten or so ramps in a cell.
        "full-u16" => 6e-2,
        // Shading turns fast where the gradient is nearly 0.
        "two-samples" => 1.3e-2,
        "bright" => 1e-2,
        // Smooth fields: what the square of a step of ⅕ leaves.
        "anisotropy" | "grazing-rays" | "axis-aligned" | "camera-inside" | "far-origin" => 6e-4,
        "faint" => 1e-4,
        // Nothing but rounding.
        "many-faint-steps" | "constant" => 3e-7,
        _ => return None,
    })
}

/// Local steps that aim at an RMSE of 5·10⁻⁴.
fn of_default_steps(case: &str) -> Option<f64> {
    match case {
        "opaque-wall" | "thin-shell" => Some(0.85),
        // Walls, holes and ramps much narrower than a step are found as well or as badly as by steps of ⅕.
        "missing-voxels" => Some(6e-2),
        "two-samples" => Some(2.2e-2),
        // Twice the error aimed at, in the worst pixel of a smooth field.
        "anisotropy" | "grazing-rays" | "axis-aligned" | "camera-inside" | "far-origin" | "faint" => Some(1.2e-3),
        // The field alternates from voxel to voxel, faster than long steps can see: they meet both values equally often.
        "many-faint-steps" => Some(4e-4),
        _ => of_fine_steps(case),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_belong_to_settings() {
        let bound = |caster: RayCaster| caster.documented_error("far-origin");
        assert_eq!(bound(RayCaster::default()), Some(1.2e-3));
        assert_eq!(bound(RayCaster::uniform(0.2)), Some(6e-4));
        assert_eq!(bound(RayCaster::exact(0.1)), Some(6e-4));
        assert_eq!(bound(RayCaster::uniform(0.5)), None);
        assert_eq!(bound(RayCaster { step: Step::Tolerance(1e-3), ..RayCaster::default() }), Some(1e-3));
        assert_eq!(bound(RayCaster { filter: Some(Filter::Nearest), ..RayCaster::default() }), None);
        assert_eq!(RayCaster::default().documented_error("easy"), None);
    }
}
