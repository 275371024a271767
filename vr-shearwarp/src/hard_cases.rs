//! Largest errors that the documentation allows itself on the hard cases of `vr-physics`.

use vr_core::DocumentedError::{self, Max, Rmse};

/// Measured errors of the default settings, and half as much again. Most of the cases are
/// small volumes, of which a texel as large as a voxel is a large part.
pub(crate) const ERRORS: [(&str, DocumentedError); 15] = [
    // Where a ray just passes a wall or just not, all of it is at stake, and between two texels that disagree half of it.
    ("opaque-wall", Rmse(0.12)),
    ("thin-shell", Rmse(5.7e-2)),
    // Ten or so ramps in a cell: light between two texels has no more to do with that at them.
    ("full-u16", Max(0.94)),
    // 33³ samples under a transfer function that is crossed in half a voxel, and a texel is one.
    ("marschner-lobb", Max(0.33)),
    ("far-origin", Max(0.31)),
    // The whole picture is one outline: half of a texel inside it is missing, half outside is too much.
    ("axis-aligned", Max(0.19)),
    ("constant", Max(0.19)),
    ("bright", Max(0.19)),
    ("missing-voxels", Max(0.19)),
    ("two-samples", Max(0.15)),
    // What bends within a voxel is interpolated between texels of that size, and outlines are as soft as one is wide.
    ("anisotropy", Max(0.076)),
    ("grazing-rays", Max(0.076)),
    ("camera-inside", Max(0.076)),
    ("faint", Max(0.076)),
    // Nothing but the nearest entry of a table.
    ("many-faint-steps", Max(1.1e-05)),
];

#[cfg(test)]
mod tests {
    use vr_core::Documented;

    use crate::shear_warp::ShearWarp;

    #[test]
    fn bounds_belong_to_the_default() {
        assert!(ShearWarp::default().hard_case_errors().for_case("opaque-wall").is_some());
        assert_eq!(ShearWarp::classic().hard_case_errors().for_case("opaque-wall"), None);
        assert_eq!(ShearWarp::default().hard_case_errors().for_case("easy"), None);
    }
}
