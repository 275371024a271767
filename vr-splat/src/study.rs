//! Documentation of the renderer for a study of speed against error.

use vr_core::{Classification, ConvergenceClaim, ConvergenceOrders, Documented, HardCaseErrors, NamedSetting};

use crate::hard_cases::ERRORS;
use crate::kernel::{Shape, SplatKernel};
use crate::options::SLICE_DISTANCE;
use crate::splatter::{Buffers, Splatter};

/// Rounding of f32 kernels, tables and early termination together, on smooth scenes.
const FLOOR: f64 = 3e-4;
/// Rounding in f32: of smooth transfer functions tables leave less.
const FLOOR_OF_ORDERS: f64 = 3e-7;
/// Order in the distance of sheets parallel to the image, where nothing jumps: each takes the value in its middle.
const ORDER: f64 = 2.0;

impl Documented for Splatter {
    /// Every way to gather splats, from coarse to fine.
    fn settings(&self) -> Vec<NamedSetting> {
        let named = |name: String, renderer: &Self, order| NamedSetting::new(name, renderer, order, FLOOR);
        let image = |slice_spacing: f64| Self { slice_spacing, ..Self::default() };
        let voxels = |buffers, shape| Self {
            buffers,
            classification: Classification::Pre,
            kernel: SplatKernel::new(shape),
            ..Self::default()
        };
        let mut all: Vec<NamedSetting> =
            [2.0, 1.0, 0.5, 0.25].map(|d| named(format!("image {d}"), &image(d), Some(ORDER))).into();
        let gaussian = SplatKernel::new(Shape::Gaussian);
        // Kernels that smooth come near a field of their own: no order.
        let others = [
            ("image 1 gaussian", Self { kernel: gaussian, ..image(1.0) }),
            ("image 1 voxels", voxels(Buffers::Image, Shape::Gaussian)),
            ("axis", Self { buffers: Buffers::Axis, kernel: gaussian, ..Self::default() }),
            ("axis voxels", voxels(Buffers::Axis, Shape::Gaussian)),
            ("samples", voxels(Buffers::Samples, Shape::Gaussian)),
            // These for scattered points, too, which have kernels of their own.
            ("image 1 voxels bilinear", voxels(Buffers::Image, Shape::Bilinear)),
            ("samples bilinear", voxels(Buffers::Samples, Shape::Bilinear)),
        ];
        all.extend(others.map(|(name, renderer)| named(name.to_owned(), &renderer, None)));
        all
    }

    /// Sheets parallel to the image as they come closer together.
    fn convergence(&self) -> Vec<ConvergenceClaim> {
        let orders = ConvergenceOrders { smooth: ORDER, jumps: 1.0, grid: 2.0, pixels: 2.0 };
        let whole_rays = Self { termination: 1.0, ..Self::default() };
        vec![ConvergenceClaim::new("image sheets", &whole_rays, SLICE_DISTANCE, FLOOR_OF_ORDERS, orders)]
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
        documents_what_can_be_set(&Splatter::default(), 4).unwrap();
    }
}
