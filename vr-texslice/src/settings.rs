//! The settings that a study of speed against error should try, and the orders that the documentation claims.

use vr_core::{NamedSetting, OrderClaim, Orders};

use crate::options::to_options;
use crate::tex_slice::{Format, Proxy, TexSlice};

/// Rounding of f32 kernels, tables and early termination together, on smooth scenes.
const FLOOR: f64 = 3e-4;

/// Every kind of slice and texture, from coarse to fine.
pub(crate) fn settings() -> Vec<NamedSetting> {
    let named = |name: String, renderer: &TexSlice, order| NamedSetting {
        name,
        options: to_options(renderer),
        order,
        error_floor: FLOOR,
    };
    let plain = |slice_distance: f64| TexSlice { slice_distance, ..TexSlice::default() };
    let mut all: Vec<NamedSetting> =
        [2.0, 1.0, 0.5, 0.2].map(|d| named(format!("planes {d}"), &plain(d), Some(2.0))).into();
    all.extend([2.0, 1.0, 0.5].map(|d| {
        named(format!("pre-integrated {d}"), &TexSlice { format: Format::PreIntegrated, ..plain(d) }, Some(2.0))
    }));
    all.push(named("shells 1".to_owned(), &TexSlice { proxy: Proxy::Shells, ..plain(1.0) }, Some(2.0)));
    // What lies between the slices of a stack comes near the field, not the truth nearer: no order.
    all.extend([1.0, 0.5].map(|d| named(format!("stacks {d}"), &TexSlice { proxy: Proxy::Stacks, ..plain(d) }, None)));
    all.push(named("rgba 1".to_owned(), &TexSlice { format: Format::Rgba, ..plain(1.0) }, None));
    all.push(named("paletted 1".to_owned(), &TexSlice { format: Format::Paletted, ..plain(1.0) }, None));
    all.push(named("compressed 1".to_owned(), &TexSlice { format: Format::Compressed, ..plain(1.0) }, None));
    all.push(named(
        "brute force 1".to_owned(),
        &TexSlice { slice_distance: 1.0, ..TexSlice::brute_force() },
        Some(2.0),
    ));
    all
}

/// The orders of classification after interpolation and of pre-integration, in the distance of slices.
///
/// Segments across a jump are exact where the value goes linearly from end to end, and 2 is their order; but where a ray only just passes a jump, they
/// may miss it, and from a voxel to a sixteenth 1.4 to 1.6 was measured.
pub(crate) fn orders() -> Vec<OrderClaim> {
    let claim = |name: &str, renderer: TexSlice, jumps: f64| {
        let mut options = to_options(&renderer);
        options.0.remove("slice-distance");
        let orders = Orders { smooth: 2.0, jumps, grid: 2.0, pixels: 2.0 };
        OrderClaim {
            name: name.to_owned(),
            options,
            key: "slice-distance",
            coarsest: 1.0,
            floor: FLOOR_OF_ORDERS,
            orders,
        }
    };
    let brute = TexSlice::brute_force;
    vec![
        claim("planes", brute(), 1.0),
        claim("shells", TexSlice { proxy: Proxy::Shells, ..brute() }, 1.0),
        claim("pre-integrated", TexSlice { format: Format::PreIntegrated, ..brute() }, 1.7),
    ]
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
            let renderer = configure(&TexSlice::default(), &a.options).unwrap();
            assert!(renderer.validate().is_ok(), "{}", a.name);
            assert!(all[..i].iter().all(|b| b.name != a.name && b.options != a.options), "{}", a.name);
        }
    }

    #[test]
    fn what_is_claimed_can_be_refined() {
        for claim in orders() {
            for halvings in 0..6 {
                let at = claim.coarsest / f64::from(1 << halvings);
                let set = claim.options.clone().with(claim.key, at);
                assert!(configure(&TexSlice::default(), &set).unwrap().validate().is_ok(), "{}", claim.name);
            }
            assert!(!claim.options.0.contains_key(claim.key));
        }
    }
}
