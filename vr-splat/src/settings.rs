//! The settings that a study of speed against error should try, and the orders that the documentation claims.

use vr_core::{NamedSetting, OrderClaim, Orders};

use crate::kernel::{Shape, SplatKernel};
use crate::options::to_options;
use crate::splatting::{Buffers, Classification, Splatting};

/// Rounding of f32 kernels, tables and early termination together, on smooth scenes.
const FLOOR: f64 = 3e-4;

/// Every way to gather splats, from coarse to fine.
pub(crate) fn settings() -> Vec<NamedSetting> {
    let named = |name: String, renderer: &Splatting, order| NamedSetting {
        name,
        options: to_options(renderer),
        order,
        error_floor: FLOOR,
    };
    let image = |slice_distance: f64| Splatting { slice_distance, ..Splatting::default() };
    let voxels = |buffers, shape| Splatting {
        buffers,
        classification: Classification::Voxels,
        kernel: SplatKernel::new(shape),
        ..Splatting::default()
    };
    let mut all: Vec<NamedSetting> =
        [2.0, 1.0, 0.5, 0.25].map(|d| named(format!("image {d}"), &image(d), Some(2.0))).into();
    let gaussian = Splatting { kernel: SplatKernel::new(Shape::Gaussian), ..image(1.0) };
    // Kernels that smooth come near a field of their own: no order.
    all.push(named("image 1 gaussian".to_owned(), &gaussian, None));
    all.push(named("image 1 voxels".to_owned(), &voxels(Buffers::Image, Shape::Gaussian), None));
    let axis = Splatting { buffers: Buffers::Axis, kernel: SplatKernel::new(Shape::Gaussian), ..Splatting::default() };
    all.push(named("axis".to_owned(), &axis, None));
    all.push(named("axis voxels".to_owned(), &voxels(Buffers::Axis, Shape::Gaussian), None));
    all.push(named("samples".to_owned(), &voxels(Buffers::Samples, Shape::Gaussian), None));
    // These for scattered points, too, which have kernels of their own.
    all.push(named("image 1 voxels bilinear".to_owned(), &voxels(Buffers::Image, Shape::Bilinear), None));
    all.push(named("samples bilinear".to_owned(), &voxels(Buffers::Samples, Shape::Bilinear), None));
    all
}

/// The order of sheets parallel to the image, in their distance: each takes the value in its middle.
pub(crate) fn orders() -> Vec<OrderClaim> {
    let mut options = to_options(&Splatting { termination: 1.0, ..Splatting::default() });
    options.0.remove("slice-distance");
    let orders = Orders { smooth: 2.0, jumps: 1.0, grid: 2.0, pixels: 2.0 };
    vec![OrderClaim {
        name: "image sheets".to_owned(),
        options,
        key: "slice-distance",
        coarsest: 1.0,
        floor: FLOOR_OF_ORDERS,
        orders,
    }]
}

/// Rounding in f32: of smooth transfer functions tables leave less.
const FLOOR_OF_ORDERS: f64 = 3e-7;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::configure;

    #[test]
    fn settings_are_distinct_and_can_be_set() {
        let all = settings();
        for (i, a) in all.iter().enumerate() {
            assert!(configure(&Splatting::default(), &a.options).is_ok(), "{}", a.name);
            assert!(all[..i].iter().all(|b| b.name != a.name && b.options != a.options), "{}", a.name);
        }
    }

    #[test]
    fn what_is_claimed_can_be_refined() {
        for claim in orders() {
            for halvings in 0..5 {
                let at = claim.coarsest / f64::from(1 << halvings);
                assert!(configure(&Splatting::default(), &claim.options.clone().with(claim.key, at)).is_ok());
            }
            assert!(!claim.options.0.contains_key(claim.key));
        }
    }
}
