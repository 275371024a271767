//! Largest errors that the documentation allows itself on the hard cases of `vr-physics`.

use vr_core::DocumentedError::{self, Max};

/// Measured errors of the default settings, and half as much again.
pub(crate) const ERRORS: [(&str, DocumentedError); 15] = [
    // Where a ray just passes a wall or just not, all of it is at stake, and a spike a hundredth of a slab wide is met or missed.
    ("opaque-wall", Max(0.82)),
    ("thin-shell", Max(0.82)),
    // Ten or so ramps in a cell, and two samples of it.
    ("full-u16", Max(9.7e-2)),
    // Holes are known to a slab.
    ("missing-voxels", Max(9.5e-2)),
    // 33³ samples under a transfer function that a ray crosses in half a voxel.
    ("marschner-lobb", Max(5.6e-2)),
    ("bright", Max(4.7e-2)),
    // Shading turns fast where the gradient is nearly 0.
    ("two-samples", Max(3.3e-2)),
    // Smooth fields: what the square of half a voxel leaves.
    ("axis-aligned", Max(3.6e-3)),
    ("camera-inside", Max(3.6e-3)),
    ("anisotropy", Max(1.6e-3)),
    ("grazing-rays", Max(1.6e-3)),
    ("far-origin", Max(1.6e-3)),
    ("faint", Max(4.9e-4)),
    // Values that alternate from voxel to voxel, met equally often but for the ends.
    ("many-faint-steps", Max(4.7e-6)),
    // Rounding alone.
    ("constant", Max(3e-7)),
];

#[cfg(test)]
mod tests {
    use vr_core::Documented;

    use crate::texture_slicer::TextureSlicer;

    #[test]
    fn bounds_belong_to_the_default() {
        assert!(TextureSlicer::default().hard_case_errors().for_case("opaque-wall").is_some());
        assert_eq!(TextureSlicer::brute_force().hard_case_errors().for_case("opaque-wall"), None);
        assert_eq!(TextureSlicer::default().hard_case_errors().for_case("easy"), None);
    }
}
