//! What the hard cases of `vr-physics` may cost: the largest errors that the documentation allows itself.

use crate::tex_slice::TexSlice;

impl TexSlice {
    /// See [`vr_core::Renderer::hard_case_error`]: measured errors of the default settings, and half as much again.
    pub(crate) fn documented_error(&self, case: &str) -> Option<f64> {
        if *self != Self::default() {
            return None;
        }
        Some(match case {
            // Where a ray just passes a wall or just not, all of it is at stake, and a spike a hundredth of a slab wide is met or missed.
            "opaque-wall" | "thin-shell" => 0.82,
            // Ten or so ramps in a cell, and two samples of it.
            "full-u16" => 9.7e-2,
            // Holes are known to a slab.
            "missing-voxels" => 9.5e-2,
            // 33³ samples under a transfer function that a ray crosses in half a voxel.
            "marschner-lobb" => 5.6e-2,
            "bright" => 4.7e-2,
            // Shading turns fast where the gradient is nearly 0.
            "two-samples" => 3.3e-2,
            // Smooth fields: what the square of half a voxel leaves.
            "axis-aligned" | "camera-inside" => 3.6e-3,
            "anisotropy" | "grazing-rays" | "far-origin" => 1.6e-3,
            "faint" => 4.9e-4,
            // Values that alternate from voxel to voxel, met equally often but for the ends.
            "many-faint-steps" => 4.7e-6,
            // Rounding alone.
            "constant" => 3e-7,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_belong_to_the_default() {
        assert!(TexSlice::default().documented_error("opaque-wall").is_some());
        assert_eq!(TexSlice::brute_force().documented_error("opaque-wall"), None);
        assert_eq!(TexSlice::default().documented_error("easy"), None);
    }
}
