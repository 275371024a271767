//! What the hard cases of `vr-physics` may cost: the largest errors that the documentation allows itself.

use vr_core::DocumentedError;

use crate::splatting::Splatting;

impl Splatting {
    /// See [`vr_core::Renderer::hard_case_error`]: measured errors of the default settings, and half as much again.
    pub(crate) fn documented_error(&self, case: &str) -> Option<DocumentedError> {
        if *self != Self::default() {
            return None;
        }
        Some(DocumentedError::Max(match case {
            // Where a ray just passes a wall or just not, all of it is at stake, and a spike a hundredth of a sheet wide is met or missed.
            "opaque-wall" => return Some(DocumentedError::Rmse(6.2e-2)),
            "thin-shell" => return Some(DocumentedError::Rmse(5.4e-2)),
            // 33³ samples under a transfer function that a ray crosses in half a voxel.
            "marschner-lobb" => 0.24,
            // Ten or so ramps in a cell; and emission that is met once in a sheet.
            "full-u16" | "bright" => 0.21,
            // Holes are known to a sheet.
            "missing-voxels" => 0.16,
            // Shading turns fast where the gradient is nearly 0.
            "two-samples" => 7.2e-2,
            // Smooth fields: what the square of a voxel leaves.
            "camera-inside" | "axis-aligned" => 1.1e-2,
            "anisotropy" | "grazing-rays" | "far-origin" => 7.4e-3,
            "faint" => 1.6e-3,
            // Values that alternate from voxel to voxel, met equally often but for the ends.
            "many-faint-steps" => 1.2e-4,
            // Rounding alone.
            "constant" => 3e-7,
            _ => return None,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_belong_to_the_default() {
        assert!(Splatting::default().documented_error("opaque-wall").is_some());
        assert_eq!(Splatting { low_pass: 1.0, ..Splatting::default() }.documented_error("opaque-wall"), None);
        assert_eq!(Splatting::default().documented_error("easy"), None);
    }
}
