//! Largest errors that the documentation allows itself on the hard cases of `vr-physics`.

use vr_core::DocumentedError::{self, Max, Rmse};

/// Measured errors of the default settings, and half as much again.
pub(crate) const ERRORS: [(&str, DocumentedError); 15] = [
    // Where a ray just passes a wall or just not, all of it is at stake, and a spike a hundredth of a sheet wide is met or missed.
    ("opaque-wall", Rmse(6.2e-2)),
    ("thin-shell", Rmse(5.4e-2)),
    // 33³ samples under a transfer function that a ray crosses in half a voxel.
    ("marschner-lobb", Max(0.24)),
    // Ten or so ramps in a cell; and emission that is met once in a sheet.
    ("full-u16", Max(0.21)),
    ("bright", Max(0.21)),
    // Holes are known to a sheet.
    ("missing-voxels", Max(0.16)),
    // Shading turns fast where the gradient is nearly 0.
    ("two-samples", Max(7.2e-2)),
    // Smooth fields: what the square of a voxel leaves.
    ("camera-inside", Max(1.1e-2)),
    ("axis-aligned", Max(1.1e-2)),
    ("anisotropy", Max(7.4e-3)),
    ("grazing-rays", Max(7.4e-3)),
    ("far-origin", Max(7.4e-3)),
    ("faint", Max(1.6e-3)),
    // Values that alternate from voxel to voxel, met equally often but for the ends.
    ("many-faint-steps", Max(1.2e-4)),
    // Rounding alone.
    ("constant", Max(3e-7)),
];

#[cfg(test)]
mod tests {
    use vr_core::Documented;

    use crate::splatter::Splatter;

    #[test]
    fn bounds_belong_to_the_default() {
        assert!(Splatter::default().hard_case_errors().for_case("opaque-wall").is_some());
        assert_eq!(Splatter { low_pass: 1.0, ..Splatter::default() }.hard_case_errors().for_case("opaque-wall"), None);
        assert_eq!(Splatter::default().hard_case_errors().for_case("easy"), None);
    }
}
