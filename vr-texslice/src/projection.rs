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
        let arm = point - self.eye;
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

    /// The slabs of planes so far apart that a box is cut into, front to back, each by where it begins and ends along [`Self::forward`] in the world; what
    /// is behind the eye is left out. Slices are counted from the box's middle.
    pub(crate) fn slabs(&self, corners: &[DVec3; 8], distance: f64) -> impl Iterator<Item = [f64; 2]> {
        let middle = self.frame.z_axis.dot(0.5 * (corners[0] + corners[7]));
        let along = corners.map(|c| self.frame.z_axis.dot(c) - middle);
        let reach = along.into_iter().fold(0.0, |max: f64, d| max.max(d.abs()));
        let last = (reach / distance + 0.5).floor() as i64;
        let eye = self.frame.z_axis.dot(self.eye);
        // In perspective, what is in the plane through the eye is nowhere on the screen.
        let near = eye + if self.perspective { 1e-9 * (reach + distance) } else { 0.0 };
        let slab = move |k: i64| [-0.5, 0.5].map(|side| (middle + (k as f64 + side) * distance).max(near));
        (-last..=last).map(slab).filter(|[low, high]| low < high)
    }
}
