//! The settings that a study of speed against error should try, and the orders that the documentation claims.

use vr_core::{NamedSetting, Options, OrderClaim, Orders};

use crate::options::to_options;
use crate::shear_warp::{Encoding, ShearWarp};
use crate::warp::WarpFilter;

/// Tables take the nearest of their entries, and floats are rounded to 65536 levels.
const FLOOR: f64 = 1e-4;

/// From the classic to finer and finer slices and texels.
pub(crate) fn settings() -> Vec<NamedSetting> {
    let named = |name: &str, renderer: &ShearWarp, order| NamedSetting {
        name: name.to_owned(),
        options: to_options(renderer),
        order,
        error_floor: FLOOR,
    };
    let values =
        |spacing: f64, texel, warp| ShearWarp { slice_distance: spacing / texel, texel, warp, ..ShearWarp::default() };
    let (bilinear, cubic) = (WarpFilter::Bilinear, WarpFilter::Cubic);
    let octree = ShearWarp { encoding: Encoding::Octree, ..values(1.0, 1.0, bilinear) };
    vec![
        named("voxels 1", &ShearWarp::classic(), None),
        named("values 1", &values(1.0, 1.0, bilinear), None),
        named("values 1 octree", &octree, None),
        named("values 1 cubic", &values(1.0, 1.0, cubic), None),
        named("values 1/2", &values(0.5, 1.0, bilinear), None),
        named("values 1/2 cubic", &values(0.5, 1.0, cubic), None),
        named("values 1/2 texel 1/2", &values(0.5, 0.5, bilinear), None),
        named("values 1/2 texel 1/2 cubic", &values(0.5, 0.5, cubic), None),
        named("values 1/4 texel 1/2 cubic", &values(0.25, 0.5, cubic), None),
        named("values 1/8 texel 1/4 cubic", &values(0.125, 0.25, cubic), None),
    ]
}

/// The order in the size of texels, slices being half a texel apart.
///
/// Both resamplings have order 2 where the picture is smooth. Fields that are linear between voxels have kinks there, and from texels of a
/// voxel to those of an eighth errors fall a little slower.
pub(crate) fn orders() -> Vec<OrderClaim> {
    let mut options: Options = to_options(&ShearWarp { termination: 1.0, ..ShearWarp::default() });
    options.0.remove("texel");
    let orders = Orders { smooth: 1.75, jumps: 1.2, grid: 1.8, pixels: 2.0 };
    vec![OrderClaim { name: "texels".to_owned(), options, key: "texel", coarsest: 1.0, floor: FLOOR_OF_ORDERS, orders }]
}

/// Rounding to the nearest entry of tables and to the levels of codes.
const FLOOR_OF_ORDERS: f64 = 2e-5;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::configure;

    #[test]
    fn settings_are_distinct_and_can_be_set() {
        let all = settings();
        for (i, a) in all.iter().enumerate() {
            let renderer = configure(&ShearWarp::default(), &a.options).unwrap();
            assert!(renderer.validate().is_ok(), "{}", a.name);
            assert!(all[..i].iter().all(|b| b.name != a.name && b.options != a.options), "{}", a.name);
        }
    }

    #[test]
    fn what_is_claimed_can_be_refined() {
        for claim in orders() {
            for halvings in 0..4 {
                let at = claim.coarsest / f64::from(1 << halvings);
                let set = claim.options.clone().with(claim.key, at);
                assert!(configure(&ShearWarp::default(), &set).unwrap().validate().is_ok(), "{}", claim.name);
            }
            assert!(!claim.options.0.contains_key(claim.key));
        }
    }
}
