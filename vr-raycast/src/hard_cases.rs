//! Documented errors of the caster on the hard cases of `vr-physics`.

use vr_core::{DocumentedError, Filter, HardCaseErrors};

use crate::caster::{ImageSampling, RayCaster, Rule, Step};

/// Longest uniform steps of which every error is documented; shorter ones are no worse.
const FINE: f64 = 0.2;

/// Measured errors, and half as much again: of uniform steps of ⅕, and of local steps that aim at an RMSE of 10⁻³.
const ERRORS: [(&str, f64, f64); 18] = [
    // The wall's place is known to a step of ⅕, and where a ray just passes it or just not, all of it is at stake; parabolas find it.
    ("opaque-wall", 0.8, 1.7e-6),
    // A hundredth of a step wide: most rays that cross it at a right angle never see it in steps of one sample.
    ("thin-shell", 0.75, 4.6e-2),
    // 33³ samples under a transfer function that a ray crosses in half a voxel.
    ("marschner-lobb", 2e-2, 6.3e-3),
    // Faces of vacuum are known to a step.
    ("missing-voxels", 4e-2, 1e-3),
    // Ten or so ramps in a cell.
    ("full-u16", 6e-2, 1e-1),
    // Shading turns fast where the gradient is nearly 0.
    ("two-samples", 1.3e-2, 1.45e-2),
    ("bright", 1e-2, 9.3e-3),
    // Smooth fields: what the square of a step of ⅕ leaves; and a few times the error aimed at, in the worst pixel.
    ("anisotropy", 6e-4, 4.6e-3),
    ("grazing-rays", 6e-4, 3.5e-3),
    ("axis-aligned", 6e-4, 1.4e-3),
    ("camera-inside", 6e-4, 1e-3),
    ("far-origin", 6e-4, 1.9e-3),
    ("faint", 1e-4, 1.4e-3),
    // Nothing but rounding; but the field alternates from voxel to voxel, faster than long steps can see: they meet both values
    // equally often.
    ("many-faint-steps", 3e-7, 3.6e-4),
    ("constant", 3e-7, 3e-7),
    // A front that is a coarse cell thick, five samples of which carry all of the light.
    ("level-boundary", 7.5e-2, 1.5e-1),
    // Steps follow the cells: each decade has as many.
    ("uneven-axes", 4.5e-3, 1.4e-2),
    // A jump, in effect: its place is known to a step.
    ("slivers", 8e-2, 8.1e-2),
];

impl RayCaster {
    /// Returns the errors of steps that keep an error bound, and of trilinear fields under the midpoint rule; nothing is documented of other settings.
    pub(crate) fn documented_errors(&self) -> HardCaseErrors {
        let plain = Self { step: self.step, precision: self.precision, ..Self::default() };
        let comparable = Self {
            order: plain.order,
            empty_space: plain.empty_space,
            transfer_lookup: plain.transfer_lookup,
            vector: plain.vector,
            filter: self.filter.filter(|&f| f != Filter::Trilinear),
            rule: match (self.rule, self.step) {
                (Rule::Midpoint, Step::Uniform(_)) => Rule::Auto,
                (rule, _) => rule,
            },
            // The pictures of the hard cases are too small for any but the rays of every pixel.
            image_sampling: match self.image_sampling {
                ImageSampling::EveryPixel => ImageSampling::Auto,
                other => other,
            },
            ..self.clone()
        };
        let midpoint = comparable == plain;
        let by_case = match self.step {
            Step::ErrorBound(error)
                if matches!(self.image_sampling, ImageSampling::Auto | ImageSampling::EveryPixel) =>
            {
                return HardCaseErrors { otherwise: Some(error.into()), ..HardCaseErrors::default() };
            }
            Step::Uniform(step) if midpoint && step <= FINE => ERRORS.map(|(case, fine, _)| (case, fine)),
            Step::Auto | Step::Local { error: Step::ERROR } if midpoint => {
                ERRORS.map(|(case, _, default)| (case, default))
            }
            _ => return HardCaseErrors::default(),
        };
        HardCaseErrors {
            by_case: by_case.map(|(case, error)| (case, DocumentedError::Max(error))).into(),
            otherwise: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_belong_to_settings() {
        let bound = |caster: RayCaster| caster.documented_errors().for_case("far-origin").map(DocumentedError::value);
        assert_eq!(bound(RayCaster::default()), Some(1.9e-3));
        assert_eq!(bound(RayCaster::uniform(0.2)), Some(6e-4));
        assert_eq!(bound(RayCaster::exact(0.1)), Some(6e-4));
        assert_eq!(bound(RayCaster::uniform(0.5)), None);
        assert_eq!(bound(RayCaster { step: Step::ErrorBound(1e-3), ..RayCaster::default() }), Some(1e-3));
        assert_eq!(bound(RayCaster { filter: Some(Filter::Nearest), ..RayCaster::default() }), None);
        assert_eq!(RayCaster::default().documented_errors().for_case("easy"), None);
    }
}
