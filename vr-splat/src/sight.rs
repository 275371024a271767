//! Directions in which voxels and points are seen.

use glam::DVec3;
use vr_core::{ParameterError, Projection, View};

/// Directions in which voxels or points are seen.
#[derive(Clone, Copy)]
pub(crate) enum Sight {
    /// The same for all.
    Along(DVec3),
    /// From the eye.
    From(DVec3),
}

impl Sight {
    pub(crate) fn new(view: &View) -> Result<Self, ParameterError> {
        Ok(match view.camera.projection {
            Projection::Perspective { .. } => Self::From(view.camera.eye),
            Projection::Orthographic { .. } => Self::Along(view.camera.frame()?.z_axis),
        })
    }

    /// Unit vector from the eye to a place in the world.
    pub(crate) fn towards(self, place: DVec3) -> DVec3 {
        match self {
            Self::Along(direction) => direction,
            Self::From(eye) => (place - eye).normalize_or_zero(),
        }
    }
}
