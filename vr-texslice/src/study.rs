//! Documentation of the renderer for a study of speed against error.

use vr_core::{ConvergenceClaim, ConvergenceOrders, Documented, HardCaseErrors, NamedSetting};

use crate::hard_cases::ERRORS;
use crate::options::SLICE_DISTANCE;
use crate::texture_slicer::{Format, Proxy, TextureSlicer};

/// Rounding of f32 kernels, tables and early termination together, on smooth scenes.
const FLOOR: f64 = 3e-4;
/// Rounding in f32: of smooth transfer functions tables leave less.
const FLOOR_OF_ORDERS: f64 = 3e-7;
/// Order in the distance of slices, of values classified after interpolation and of pre-integrated segments, where nothing jumps.
const ORDER: f64 = 2.0;

impl Documented for TextureSlicer {
    /// Every kind of slice and texture, from coarse to fine.
    fn settings(&self) -> Vec<NamedSetting> {
        let named = |name: String, renderer: &Self, order| NamedSetting::new(name, renderer, order, FLOOR);
        let plain = |slice_spacing: f64| Self { slice_spacing, ..Self::default() };
        let mut all: Vec<NamedSetting> =
            [2.0, 1.0, 0.5, 0.2].map(|d| named(format!("planes {d}"), &plain(d), Some(ORDER))).into();
        all.extend([2.0, 1.0, 0.5].map(|d| {
            let renderer = Self { format: Format::PreIntegrated, ..plain(d) };
            named(format!("pre-integrated {d}"), &renderer, Some(ORDER))
        }));
        all.push(named("shells 1".to_owned(), &Self { proxy: Proxy::Shells, ..plain(1.0) }, Some(ORDER)));
        // What lies between the slices of a stack comes near the field, not the truth nearer: no order.
        all.extend([1.0, 0.5].map(|d| named(format!("stacks {d}"), &Self { proxy: Proxy::Stacks, ..plain(d) }, None)));
        for (name, format) in
            [("rgba", Format::Rgba), ("paletted", Format::Paletted), ("compressed", Format::Compressed)]
        {
            all.push(named(format!("{name} 1"), &Self { format, ..plain(1.0) }, None));
        }
        let brute_force = Self { slice_spacing: 1.0, ..Self::brute_force() };
        all.push(named("brute force 1".to_owned(), &brute_force, Some(ORDER)));
        all
    }

    /// Classification after interpolation, and pre-integration, as slices come closer together.
    ///
    /// Segments across a jump are exact where the value goes linearly from end to end, and 2 is their order; but where a ray only just
    /// passes a jump, they may miss it, and from a voxel to a sixteenth 1.4 to 1.6 was measured.
    fn convergence(&self) -> Vec<ConvergenceClaim> {
        let claim = |name: &str, renderer: Self, jumps: f64| {
            let orders = ConvergenceOrders { smooth: ORDER, jumps, grid: 2.0, pixels: 2.0 };
            ConvergenceClaim::new(name, &renderer, SLICE_DISTANCE, FLOOR_OF_ORDERS, orders)
        };
        let brute = Self::brute_force;
        vec![
            claim("planes", brute(), 1.0),
            claim("shells", Self { proxy: Proxy::Shells, ..brute() }, 1.0),
            claim("pre-integrated", Self { format: Format::PreIntegrated, ..brute() }, 1.7),
        ]
    }

    fn hard_case_errors(&self) -> HardCaseErrors {
        HardCaseErrors::of_default(self, ERRORS)
    }
}

#[cfg(test)]
mod tests {
    use vr_physics::check::documents_what_can_be_set;

    use super::*;

    #[test]
    fn what_is_documented_can_be_set() {
        documents_what_can_be_set(&TextureSlicer::default(), 5).unwrap();
    }
}
