//! Cameras: position, direction and projection.

use glam::{DMat3, DQuat, DVec3};

use crate::error::ParameterError;
use crate::limits::{DIRECTION_LENGTHS, MAX_COORDINATE, MAX_HEIGHTS_AWAY, MIN_FOV};

/// Kind of projection, with the width of the view.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{Camera, Projection, Rays, View};
///
/// let parallel = Projection::Orthographic { height: 2.0 };
/// let camera = Camera { eye: 5.0 * DVec3::Z, target: DVec3::ZERO, up: DVec3::Y, projection: parallel };
/// let rays = Rays::new(&View::new(camera, [64, 64]))?;
/// assert_eq!(rays.at(0.0, 0.0).direction, rays.at(64.0, 64.0).direction);
///
/// let perspective = Camera { projection: Projection::Perspective { fov: 30.0 }, ..camera };
/// let rays = Rays::new(&View::new(perspective, [64, 64]))?;
/// assert_eq!(rays.at(0.0, 0.0).origin, rays.at(64.0, 64.0).origin);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Parallel rays, starting at the plane through the eye.
    Orthographic {
        /// World height of the image.
        height: f64,
    },
    /// Rays from the eye.
    Perspective {
        /// Vertical field of view in degrees.
        fov: f64,
    },
}

impl Projection {
    /// World height of the picture: of any plane across the view, or of the one at distance 1 in perspective.
    ///
    /// # Examples
    /// ```
    /// use vr_core::Projection;
    ///
    /// assert_eq!(Projection::Orthographic { height: 3.0 }.height(), 3.0);
    /// assert!((Projection::Perspective { fov: 90.0 }.height() - 2.0).abs() < 1e-15);
    /// ```
    pub fn height(self) -> f64 {
        match self {
            Self::Orthographic { height } => height,
            Self::Perspective { fov } => 2.0 * libm::tan(0.5 * fov.to_radians()),
        }
    }

    /// True if rays start at the eye.
    pub fn is_perspective(self) -> bool {
        matches!(self, Self::Perspective { .. })
    }
}

/// A camera in world space. Right = forward × up; row 0 of a picture is its top; pixels are square.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::Camera;
///
/// // From the front, with a field of view of 30°; then 90° around to the right.
/// let front = Camera::framing((DVec3::NEG_ONE, DVec3::ONE), 0.0, 0.0, Some(30.0));
/// assert!(front.eye.z > 0.0 && front.target == DVec3::ZERO);
/// let right = front.orbit(90.0, 0.0);
/// assert!((right.eye.normalize() - DVec3::X).length() < 1e-12);
///
/// let wrong = Camera { up: DVec3::Z, ..front };
/// assert_eq!(wrong.frame().unwrap_err().field, "camera.up");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the eye.
    pub eye: DVec3,
    /// The point that the image centre shows.
    pub target: DVec3,
    /// Direction that is up in the picture: any vector that is not parallel to the view.
    pub up: DVec3,
    /// Kind and width of the view.
    pub projection: Projection,
}

impl Camera {
    /// A camera that sees all of the world box `bounds`, from the direction of an azimuth and an elevation.
    ///
    /// At azimuth 0 and elevation 0 it looks along −z with y up. Azimuth turns the camera to the right about y, elevation
    /// raises it, both in degrees. With a perspective `fov` the bounding sphere fills the image's height; orthographic likewise.
    pub fn framing(bounds: (DVec3, DVec3), azimuth: f64, elevation: f64, fov: Option<f64>) -> Self {
        let centre = 0.5 * bounds.0 + 0.5 * bounds.1;
        let radius = 0.5 * (bounds.1 - bounds.0).length();
        let (distance, projection) = match fov {
            Some(fov) => {
                let half = 0.5 * fov.to_radians();
                (radius / libm::sin(half), Projection::Perspective { fov })
            }
            None => (2.0 * radius, Projection::Orthographic { height: 2.0 * radius }),
        };
        let camera = Self { eye: centre + DVec3::Z * distance, target: centre, up: DVec3::Y, projection };
        camera.orbit(azimuth, elevation)
    }

    /// The camera turned about its target: `azimuth` degrees to the right about its up vector, then `elevation` degrees up.
    /// The up vector is carried along.
    #[must_use]
    pub fn orbit(&self, azimuth: f64, elevation: f64) -> Self {
        let arm = self.eye - self.target;
        let around = turn(self.up.normalize(), azimuth);
        let arm = around * arm;
        let right = (-arm).cross(self.up).normalize();
        let raise = turn(right, -elevation);
        Self { eye: self.target + raise * arm, up: raise * self.up, ..*self }
    }

    /// The camera turned as a rigid whole about the line through `pivot` along `axis`, by degrees, counterclockwise to one who looks against
    /// the axis: about its up vector it moves to the right, as by [`Self::orbit`]. The axis is a vector of any length but 0.
    #[must_use]
    pub fn turned(&self, pivot: DVec3, axis: DVec3, degrees: f64) -> Self {
        let around = turn(axis.normalize(), degrees);
        let moved = |p: DVec3| pivot + around * (p - pivot);
        Self { eye: moved(self.eye), target: moved(self.target), up: around * self.up, ..*self }
    }

    /// Unit vectors (right, up, forward).
    ///
    /// # Errors
    /// Eye = target, up parallel to the view, a height or field of view out of range, numbers that are not finite, or a camera so far
    /// away that f64 does not tell its rays apart.
    pub fn frame(&self) -> Result<DMat3, ParameterError> {
        for (field, v) in [("camera.eye", self.eye), ("camera.target", self.target), ("camera.up", self.up)] {
            if !(v.abs().max_element() <= MAX_COORDINATE && v.is_finite()) {
                return Err(ParameterError::new(field, v.to_array(), "must be finite, coordinates 1e30 at most"));
            }
        }
        let view = self.target - self.eye;
        // Shorter, its square is 0.
        if !DIRECTION_LENGTHS.contains(&view.length()) {
            return Err(ParameterError::new("camera.eye", self.eye.to_array(), "must differ from camera.target"));
        }
        let forward = view.normalize();
        let right = forward.cross(self.up.normalize_or_zero());
        if right.length() < 1e-9 || !DIRECTION_LENGTHS.contains(&self.up.length()) {
            let allowed = "must be a vector that is not parallel to the view, its length 1e-100 or more";
            return Err(ParameterError::new("camera.up", self.up.to_array(), allowed));
        }
        let right = right.normalize();
        let height = match self.projection {
            Projection::Orthographic { height } if !(height > 0.0 && height <= MAX_COORDINATE) => {
                return Err(ParameterError::new("camera.height", height, "must be positive and finite, 1e30 at most"));
            }
            Projection::Perspective { fov } if !(MIN_FOV..180.0).contains(&fov) => {
                return Err(ParameterError::new("camera.fov", fov, "must be 1e-6 degrees at least, and below 180"));
            }
            Projection::Orthographic { height } => height,
            Projection::Perspective { fov } => 2.0 * view.length() * libm::tan(0.5 * fov.to_radians()),
        };
        for (field, v) in [("camera.eye", self.eye), ("camera.target", self.target)] {
            if v.length() > MAX_HEIGHTS_AWAY * height {
                let allowed = "must be within 1e10 heights of the picture (at the target) from the world's origin: f64 keeps no rays \
                               apart further out";
                return Err(ParameterError::new(field, v.to_array(), allowed));
            }
        }
        Ok(DMat3::from_cols(right, right.cross(forward), forward))
    }
}

/// A rotation about a unit vector. Not glam's, whose sine is the system's: pictures must not depend on the machine.
fn turn(axis: DVec3, degrees: f64) -> DQuat {
    let (sin, cos) = libm::sincos(0.5 * degrees.to_radians());
    DQuat::from_xyzw(axis.x * sin, axis.y * sin, axis.z * sin, cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_cameras_that_see_nothing() {
        let good = Camera {
            eye: DVec3::Z,
            target: DVec3::ZERO,
            up: DVec3::Y,
            projection: Projection::Orthographic { height: 1.0 },
        };
        assert!(good.frame().is_ok());
        let field = |c: Camera| c.frame().unwrap_err().field;
        assert_eq!(field(Camera { eye: DVec3::ZERO, ..good }), "camera.eye");
        assert_eq!(field(Camera { up: DVec3::Z, ..good }), "camera.up");
        assert_eq!(field(Camera { up: DVec3::ZERO, ..good }), "camera.up");
        assert_eq!(field(Camera { target: DVec3::NAN, ..good }), "camera.target");
        assert_eq!(field(Camera { projection: Projection::Perspective { fov: 180.0 }, ..good }), "camera.fov");
        assert_eq!(field(Camera { projection: Projection::Perspective { fov: 1e-300 }, ..good }), "camera.fov");
        assert_eq!(field(Camera { projection: Projection::Orthographic { height: 0.0 }, ..good }), "camera.height");
        // Beyond what arithmetic can keep.
        assert_eq!(field(Camera { projection: Projection::Orthographic { height: 1e-11 }, ..good }), "camera.eye");
        assert_eq!(field(Camera { eye: DVec3::Z * 1e11, ..good }), "camera.eye");
        assert_eq!(field(Camera { target: DVec3::Z * -1e200, ..good }), "camera.target");
        assert_eq!(field(Camera { eye: DVec3::Z * 1e-200, ..good }), "camera.eye");
        assert_eq!(field(Camera { up: DVec3::Y * 1e-200, ..good }), "camera.up");
        assert!(Camera { eye: DVec3::Z * 1e9, ..good }.frame().is_ok());
        // Framing the smallest and the largest volumes, through the narrowest of angles.
        for scale in [1e-15, 1.0, 1e18] {
            let bounds = (DVec3::splat(-scale), DVec3::splat(scale));
            for fov in [None, Some(1e-6), Some(30.0), Some(179.0)] {
                let framed = Camera::framing(bounds, 10.0, 20.0, fov).frame();
                assert!(framed.is_ok(), "{scale} {fov:?}: {framed:?}");
            }
        }
    }

    #[test]
    fn orbits_to_the_right_and_up() {
        let c = Camera::framing((DVec3::splat(-1.0), DVec3::splat(1.0)), 0.0, 0.0, None);
        assert!((c.eye.normalize() - DVec3::Z).length() < 1e-12);
        assert!((c.orbit(90.0, 0.0).eye.normalize() - DVec3::X).length() < 1e-12);
        let raised = c.orbit(0.0, 30.0);
        assert!((raised.eye.normalize().y - 0.5).abs() < 1e-12 && raised.frame().is_ok());
        assert!(c.orbit(0.0, 90.0).frame().is_ok(), "the up vector is carried along over the pole");
    }

    #[test]
    fn turns_as_a_whole() {
        let c = Camera::framing((DVec3::splat(-1.0), DVec3::splat(1.0)), 0.0, 0.0, None);
        let (around, orbit) = (c.turned(c.target, 7.0 * c.up, 40.0), c.orbit(40.0, 0.0));
        assert!((around.eye - orbit.eye).length() < 1e-12 && (around.up - orbit.up).length() < 1e-12);
        // About its own line of sight it rolls; about another place everything moves.
        let rolled = c.turned(c.target, DVec3::Z, 90.0);
        assert!((rolled.eye - c.eye).length() < 1e-12 && (rolled.up + DVec3::X).length() < 1e-12);
        let moved = c.turned(DVec3::X, DVec3::Y, 180.0);
        assert!((moved.target - 2.0 * DVec3::X).length() < 1e-12);
        assert!((moved.eye.distance(moved.target) - c.eye.distance(c.target)).abs() < 1e-12);
    }
}
