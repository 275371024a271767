//! Documentation of the renderer for a study of speed against error.

use vr_core::{ConvergenceClaim, ConvergenceOrders, Documented, HardCaseErrors, NamedSetting};

use crate::hard_cases::ERRORS;
use crate::options::TEXEL;
use crate::shear_warp::{EmptySpace, ShearWarp};
use crate::warp::WarpFilter;

/// Tables take the nearest of their entries, and floats are rounded to 65536 levels.
const FLOOR: f64 = 1e-4;
/// Rounding to the nearest entry of tables and to the levels of codes.
const FLOOR_OF_ORDERS: f64 = 2e-5;

impl Documented for ShearWarp {
    /// From the classic to finer and finer slices and texels.
    fn settings(&self) -> Vec<NamedSetting> {
        let named = |name: &str, renderer: &Self| NamedSetting::new(name, renderer, None, FLOOR);
        let values =
            |spacing: f64, texel, warp| Self { slice_distance: spacing / texel, texel, warp, ..Self::default() };
        let (bilinear, cubic) = (WarpFilter::Bilinear, WarpFilter::Cubic);
        let octree = Self { empty_space: EmptySpace::Octree, ..values(1.0, 1.0, bilinear) };
        vec![
            named("voxels 1", &Self::classic()),
            named("values 1", &values(1.0, 1.0, bilinear)),
            named("values 1 octree", &octree),
            named("values 1 cubic", &values(1.0, 1.0, cubic)),
            named("values 1/2", &values(0.5, 1.0, bilinear)),
            named("values 1/2 cubic", &values(0.5, 1.0, cubic)),
            named("values 1/2 texel 1/2", &values(0.5, 0.5, bilinear)),
            named("values 1/2 texel 1/2 cubic", &values(0.5, 0.5, cubic)),
            named("values 1/4 texel 1/2 cubic", &values(0.25, 0.5, cubic)),
            named("values 1/8 texel 1/4 cubic", &values(0.125, 0.25, cubic)),
        ]
    }

    /// Texels as they get smaller, slices being half a texel apart.
    ///
    /// Both resamplings have order 2 where the picture is smooth. Fields that are linear between voxels have kinks there, and from texels
    /// of a voxel to those of an eighth errors fall a little slower.
    fn convergence(&self) -> Vec<ConvergenceClaim> {
        let orders = ConvergenceOrders { smooth: 1.75, jumps: 1.2, grid: 1.8, pixels: 2.0 };
        let whole_rays = Self { termination: 1.0, ..Self::default() };
        vec![ConvergenceClaim::new("texels", &whole_rays, TEXEL, FLOOR_OF_ORDERS, orders)]
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
        documents_what_can_be_set(&ShearWarp::default(), 3).unwrap();
    }
}
