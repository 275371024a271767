//! Moves of a camera by hand.

use glam::DVec3;
use vr_core::{Camera, ParameterError, Projection};

/// World height of the picture at the camera's target.
pub fn height_at_target(camera: &Camera) -> f64 {
    match camera.projection {
        Projection::Orthographic { height } => height,
        Projection::Perspective { .. } => camera.eye.distance(camera.target) * camera.projection.height(),
    }
}

/// The camera turned about its target, its up vector kept upright in the picture: rounding does not add up over an hour of turning.
///
/// # Errors
/// Those of [`Camera::frame`].
pub fn orbit(camera: &Camera, right: f64, up: f64) -> Result<Camera, ParameterError> {
    let upright = Camera { up: camera.frame()?.y_axis, ..*camera };
    let turned = upright.orbit(right, up);
    Ok(Camera { up: turned.frame()?.y_axis, ..turned })
}

/// The camera turned about its line of sight, so that the picture turns counterclockwise.
///
/// # Errors
/// Those of [`Camera::frame`].
pub fn roll(camera: &Camera, degrees: f64) -> Result<Camera, ParameterError> {
    let frame = camera.frame()?;
    let turned = Camera { up: frame.y_axis, ..*camera }.turned(camera.target, frame.z_axis, degrees);
    // The axis goes through eye and target, which stay as they are.
    Ok(Camera { eye: camera.eye, target: camera.target, ..turned })
}

/// The camera moved across its view, in heights of the picture at the target.
///
/// # Errors
/// Those of [`Camera::frame`].
pub fn pan(camera: &Camera, right: f64, up: f64) -> Result<Camera, ParameterError> {
    let by = across(camera, [right, up])?;
    checked(Camera { eye: camera.eye + by, target: camera.target + by, ..*camera })
}

/// The camera that shows things at the target `factor` times as large; the place at the target's depth that is seen `at` some heights right of
/// and above the picture's middle stays there.
///
/// # Errors
/// A factor that is not positive; those of [`Camera::frame`].
pub fn zoom(camera: &Camera, factor: f64, at: [f64; 2]) -> Result<Camera, ParameterError> {
    if !(factor > 0.0 && factor.is_finite()) {
        return Err(ParameterError::new("zoom.factor", factor, "must be positive and finite"));
    }
    let nearer = with_height(camera, height_at_target(camera) / factor, camera.projection);
    let by = across(camera, at)? * (1.0 - 1.0 / factor);
    checked(Camera { eye: nearer.eye + by, target: nearer.target + by, ..nearer })
}

/// The camera under another projection; what is seen at the target keeps its size.
///
/// # Errors
/// Those of [`Camera::frame`].
pub fn project(camera: &Camera, fov: Option<f64>) -> Result<Camera, ParameterError> {
    let height = height_at_target(camera);
    let projection = match fov {
        Some(fov) => Projection::Perspective { fov },
        None => Projection::Orthographic { height },
    };
    checked(with_height(camera, height, projection))
}

/// The camera with a height of the picture at its target under a projection.
fn with_height(camera: &Camera, height: f64, projection: Projection) -> Camera {
    match projection {
        Projection::Orthographic { .. } => Camera { projection: Projection::Orthographic { height }, ..*camera },
        Projection::Perspective { .. } => {
            let back = (camera.eye - camera.target).normalize();
            Camera { eye: camera.target + back * (height / projection.height()), projection, ..*camera }
        }
    }
}

/// World vector of a way across the picture in heights at the target.
fn across(camera: &Camera, [right, up]: [f64; 2]) -> Result<DVec3, ParameterError> {
    let frame = camera.frame()?;
    Ok((frame.x_axis * right + frame.y_axis * up) * height_at_target(camera))
}

fn checked(camera: Camera) -> Result<Camera, ParameterError> {
    camera.frame()?;
    Ok(camera)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Rays, View};

    fn cameras() -> [Camera; 2] {
        let bounds = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(5.0, 9.0, 4.0));
        [None, Some(40.0)].map(|fov| Camera::framing(bounds, 30.0, 20.0, fov))
    }

    /// Place in the picture of a point, in heights from its middle.
    fn seen(camera: &Camera, point: DVec3) -> [f64; 2] {
        let local = camera.frame().unwrap().transpose() * (point - camera.eye);
        let height = camera.projection.height() * if camera.projection.is_perspective() { local.z } else { 1.0 };
        [local.x / height, local.y / height]
    }

    fn near(a: [f64; 2], b: [f64; 2]) -> bool {
        (a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-9
    }

    #[test]
    fn the_place_under_the_pointer_stays() {
        for camera in cameras() {
            let at = [0.3, -0.2];
            let point = camera.target + across(&camera, at).unwrap();
            assert!(near(seen(&camera, point), at));
            for factor in [0.5, 1.0, 3.0] {
                let zoomed = zoom(&camera, factor, at).unwrap();
                assert!(near(seen(&zoomed, point), at), "{factor}");
                let other = point + across(&camera, [0.1, 0.0]).unwrap();
                assert!(near(seen(&zoomed, other), [at[0] + 0.1 * factor, at[1]]));
            }
            let moved = pan(&camera, 0.3, -0.2).unwrap();
            assert!(near(seen(&moved, point), [0.0; 2]));
        }
    }

    #[test]
    fn projections_keep_the_size_at_the_target() {
        for camera in cameras() {
            for fov in [None, Some(10.0), Some(90.0)] {
                let other = project(&camera, fov).unwrap();
                assert!((height_at_target(&other) / height_at_target(&camera) - 1.0).abs() < 1e-12);
                assert_eq!((other.target, other.projection.is_perspective()), (camera.target, fov.is_some()));
            }
        }
    }

    #[test]
    fn an_hour_of_turning_leaves_no_trace() {
        for start in cameras() {
            let mut camera = start;
            for _ in 0..36_000 {
                camera = orbit(&camera, 1.0, 0.0).unwrap();
            }
            let [now, then] = [camera, start].map(|c| Rays::new(&View::new(c, [8, 8])).unwrap().at(1.0, 2.0));
            assert!(now.direction.distance(then.direction) < 1e-6 && now.origin.distance(then.origin) < 1e-5);
            // Up in the picture and back.
            let there = orbit(&orbit(&start, 0.0, 170.0).unwrap(), 0.0, -170.0).unwrap();
            assert!(there.eye.distance(start.eye) < 1e-9);
        }
    }

    #[test]
    fn rolls_counterclockwise() {
        for camera in cameras() {
            let right = camera.target + across(&camera, [0.25, 0.0]).unwrap();
            let rolled = roll(&camera, 90.0).unwrap();
            assert!(near(seen(&rolled, right), [0.0, 0.25]), "{:?}", seen(&rolled, right));
            assert_eq!((rolled.eye, rolled.target), (camera.eye, camera.target));
        }
    }

    #[test]
    fn nonsense_is_refused() {
        for camera in cameras() {
            for factor in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300] {
                assert!(zoom(&camera, factor, [0.0; 2]).is_err(), "{factor}");
            }
            assert!(project(&camera, Some(180.0)).is_err());
            assert!(pan(&camera, 1e40, 0.0).is_err());
        }
    }
}
