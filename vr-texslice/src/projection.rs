//! From the world to the screen.

use glam::{DMat3, DVec2, DVec3};
use vr_core::{ParameterError, View};

/// Projection of points of the world onto a view's screen, in pixels from its top left corner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScreenProjection {
    eye: DVec3,
    frame: DMat3,
    size: [f64; 2],
    /// World size of a pixel: on the plane through the eye, or at distance 1 in perspective.
    pixel: f64,
    perspective: bool,
}

impl ScreenProjection {
    /// # Errors
    /// A camera that makes no sense.
    pub(crate) fn new(view: &View) -> Result<Self, ParameterError> {
        let projection = view.camera.projection;
        let size = view.size.map(f64::from);
        Ok(Self {
            eye: view.camera.eye,
            frame: view.camera.frame()?,
            size,
            pixel: projection.height() / size[1],
            perspective: projection.is_perspective(),
        })
    }

    /// Distance of a point along the view.
    pub(crate) fn depth(&self, point: DVec3) -> f64 {
        self.frame.z_axis.dot(point - self.eye)
    }

    /// Position of a point on the screen; in perspective it must lie before the eye.
    pub(crate) fn at(&self, point: DVec3) -> DVec2 {
        self.at_arm(point - self.eye)
    }

    /// The same of a point given from the eye.
    pub(crate) fn at_arm(&self, arm: DVec3) -> DVec2 {
        let depth = if self.perspective { self.frame.z_axis.dot(arm) } else { 1.0 };
        let scale = 1.0 / (self.pixel * depth);
        let (right, up) = (self.frame.x_axis.dot(arm) * scale, self.frame.y_axis.dot(arm) * scale);
        DVec2::new(0.5 * self.size[0] + right, 0.5 * self.size[1] - up)
    }

    /// The smallest box of the screen around points, a pixel added on all sides; all of it where one of them is not before the eye.
    pub(crate) fn bounds(&self, points: &[DVec3]) -> [DVec2; 2] {
        let near = 1e-9 * points.iter().map(|&p| self.depth(p).abs()).fold(0.0, f64::max);
        if self.perspective && points.iter().any(|&p| self.depth(p) <= near) {
            return [DVec2::NEG_INFINITY, DVec2::INFINITY];
        }
        let (low, high) = points
            .iter()
            .map(|&p| self.at(p))
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        [low - 1.0, high + 1.0]
    }

    /// A unit vector straight ahead.
    pub(crate) fn forward(&self) -> DVec3 {
        self.frame.z_axis
    }

    /// The eye.
    pub(crate) fn eye(&self) -> DVec3 {
        self.eye
    }

    /// World size of a pixel at a depth.
    pub(crate) fn pixel_at(&self, depth: f64) -> f64 {
        self.pixel * if self.perspective { depth } else { 1.0 }
    }

    /// The smallest cosine of the angle between a pixel's ray and the view.
    pub(crate) fn smallest_cosine(&self) -> f64 {
        let corner = 0.5 * self.pixel * DVec2::from_array(self.size);
        if self.perspective { 1.0 / (1.0 + corner.length_squared()).sqrt() } else { 1.0 }
    }

    /// The direction, of any length, of the ray through a point given from the eye.
    pub(crate) fn along(&self, arm: DVec3) -> DVec3 {
        if self.perspective { arm } else { self.frame.z_axis }
    }
}
