//! One frame of an animation.

use std::sync::Arc;

use vr_core::{Camera, Clip, ControlPoint, ParameterError, Scene, TransferFunction, View};

/// Changes of a frame to the scene and the view of the animation, the volume apart.
#[derive(Clone, Debug)]
pub struct Shot {
    /// The camera.
    pub camera: Camera,
    /// Control points in place of the scene's.
    pub points: Option<Vec<ControlPoint>>,
    /// Crop box and planes in place of the view's.
    pub clip: Option<Clip>,
}

impl Shot {
    /// A frame that only the camera makes.
    pub fn of(camera: Camera) -> Self {
        Self { camera, points: None, clip: None }
    }

    /// Returns the view.
    pub fn view(&self, view: &View) -> View {
        View { camera: self.camera, clip: self.clip.clone().unwrap_or_else(|| view.clip.clone()), ..view.clone() }
    }

    /// Changes the scene of the frame before into that of this one; returns true if that is another. `own` is the animation's.
    ///
    /// # Errors
    /// Points that make no transfer function.
    pub fn change(&self, scene: &mut Scene, own: &Scene) -> Result<bool, ParameterError> {
        let transfer = match &self.points {
            None => Arc::clone(&own.transfer),
            Some(points) if points == scene.transfer.points() && !scene.transfer.has_rows() => return Ok(false),
            Some(points) => {
                let (rule, unit_distance) = (own.transfer.rule(), own.transfer.unit_distance());
                Arc::new(TransferFunction::new(points.clone(), rule, unit_distance)?)
            }
        };
        let is_other = !Arc::ptr_eq(&transfer, &scene.transfer);
        scene.transfer = transfer;
        Ok(is_other)
    }
}
