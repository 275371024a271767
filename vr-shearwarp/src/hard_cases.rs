//! What the hard cases of `vr-physics` may cost: the largest errors that the documentation allows itself.

use vr_core::DocumentedError;

use crate::shear_warp::ShearWarp;

impl ShearWarp {
    /// See [`vr_core::Renderer::hard_case_error`]: measured errors of the default settings, and half as much again. Most of the cases are
    /// small volumes, of which a texel as large as a voxel is a large part.
    pub(crate) fn documented_error(&self, case: &str) -> Option<DocumentedError> {
        if *self != Self::default() {
            return None;
        }
        Some(DocumentedError::Max(match case {
            // Where a ray just passes a wall or just not, all of it is at stake, and between two texels that disagree half of it.
            "opaque-wall" => return Some(DocumentedError::Rmse(0.12)),
            "thin-shell" => return Some(DocumentedError::Rmse(5.7e-2)),
            // Ten or so ramps in a cell: light between two texels has no more to do with that at them.
            "full-u16" => 0.94,
            // 33³ samples under a transfer function that is crossed in half a voxel, and a texel is one.
            "marschner-lobb" => 0.33,
            "far-origin" => 0.31,
            // The whole picture is one outline: half of a texel inside it is missing, half outside is too much.
            "axis-aligned" | "constant" | "bright" | "missing-voxels" => 0.19,
            "two-samples" => 0.15,
            // What bends within a voxel is interpolated between texels of that size, and outlines are as soft as one is wide.
            "anisotropy" | "grazing-rays" | "camera-inside" | "faint" => 0.076,
            // Nothing but the nearest entry of a table.
            "many-faint-steps" => 1.1e-05,
            _ => return None,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_belong_to_the_default() {
        assert!(ShearWarp::default().documented_error("opaque-wall").is_some());
        assert_eq!(ShearWarp::classic().documented_error("opaque-wall"), None);
        assert_eq!(ShearWarp::default().documented_error("easy"), None);
    }
}
