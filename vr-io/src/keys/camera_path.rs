//! Cameras between keys.

use glam::{DMat3, DQuat, DVec3};
use vr_core::{Camera, ParameterError, Projection};

use super::rotation_spline::RotationSpline;
use super::spline::Spline;
use super::{Key, KeyFile};

/// Course of a camera.
#[derive(Clone, Debug)]
pub enum CameraPath {
    /// By angles, about all that is visible.
    Around(AnglePath),
    /// By place.
    Placed(PlacedPath),
}

/// Direction from which everything is seen, and its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angles {
    /// Degrees to the right of the front.
    pub azimuth: f64,
    /// Degrees above.
    pub elevation: f64,
    /// Size of what is seen; 1 where all of it fits.
    pub zoom: f64,
}

/// Course of a camera's angles.
#[derive(Clone, Debug)]
pub struct AnglePath(Spline);

impl AnglePath {
    /// Returns the angles at a time.
    pub fn at(&self, time: f64) -> Angles {
        let v = self.0.at(time);
        Angles { azimuth: v[0], elevation: v[1], zoom: libm::exp(v[2]) }
    }
}

/// Course of a camera's place: the target on a spline, the eye on a sphere about it that grows and shrinks.
#[derive(Clone, Debug)]
pub struct PlacedPath {
    keys: Vec<(f64, Camera)>,
    orientation: RotationSpline,
    /// Target, logarithm of the distance, logarithm of the height or the angle.
    place: Spline,
}

impl PlacedPath {
    /// Returns the camera at a time; at the time of a key, the camera of the key, bit for bit.
    pub fn at(&self, time: f64) -> Camera {
        if let Some((_, camera)) = self.keys.iter().find(|(key, _)| *key == time) {
            return *camera;
        }
        let v = self.place.at(time);
        let target = DVec3::new(v[0], v[1], v[2]);
        let orientation = self.orientation.at(time);
        let size = libm::exp(v[4]);
        let projection = match self.keys[0].1.projection {
            Projection::Orthographic { .. } => Projection::Orthographic { height: size },
            Projection::Perspective { .. } => Projection::Perspective { fov: size },
        };
        let eye = target + orientation * DVec3::Z * libm::exp(v[3]);
        Camera { eye, target, up: orientation * DVec3::Y, projection }
    }
}

/// The path through the keys of a file that have cameras.
pub(super) fn of(file: &KeyFile, usual: &Camera, angles: (f64, f64)) -> Result<Option<CameraPath>, ParameterError> {
    if file.keys.iter().any(Key::has_angles) {
        return Ok(Some(CameraPath::Around(around(file, angles))));
    }
    let mut keys: Vec<(f64, Camera)> = Vec::new();
    for (i, key) in file.keys.iter().enumerate().filter(|(_, key)| key.is_placed()) {
        // What is left open is as it was in the key before.
        let before = keys.last().map_or(*usual, |(_, camera)| *camera);
        let camera = placed(key, &before);
        let named = |e: ParameterError| {
            let field = e.field.strip_prefix("camera.").map_or_else(|| e.field.clone(), |f| format!("keys[{i}].{f}"));
            ParameterError { field, ..e }
        };
        camera.frame().map_err(named)?;
        let kind = std::mem::discriminant;
        if let Some((_, first)) = keys.first().filter(|(_, first)| kind(&first.projection) != kind(&camera.projection))
        {
            let allowed = "the cameras of one file must all be orthographic (height) or all perspective (fov)";
            let found = format!("{:?} after {:?}", camera.projection, first.projection);
            return Err(ParameterError { field: format!("keys[{i}]"), found, allowed });
        }
        keys.push((key.time, camera));
    }
    if keys.is_empty() {
        return Ok(None);
    }
    let times: Vec<f64> = keys.iter().map(|(time, _)| *time).collect();
    let (mut orientations, mut places) = (Vec::new(), Vec::new());
    for (_, camera) in &keys {
        let frame = camera.frame()?;
        // Right-handed: the third axis points to the eye.
        orientations.push(DQuat::from_mat3(&DMat3::from_cols(frame.x_axis, frame.y_axis, -frame.z_axis)));
        let (Projection::Orthographic { height: size } | Projection::Perspective { fov: size }) = camera.projection;
        let Camera { eye, target, .. } = camera;
        places.push(vec![target.x, target.y, target.z, libm::log(eye.distance(*target)), libm::log(size)]);
    }
    Ok(Some(CameraPath::Placed(PlacedPath {
        orientation: RotationSpline::new(times.clone(), orientations, file.interpolation),
        place: Spline::new(times, places, file.interpolation),
        keys,
    })))
}

fn around(file: &KeyFile, (azimuth, elevation): (f64, f64)) -> AnglePath {
    let mut state = Angles { azimuth, elevation, zoom: 1.0 };
    let (mut times, mut values) = (Vec::new(), Vec::new());
    for key in file.keys.iter().filter(|key| key.has_angles()) {
        state = Angles {
            azimuth: key.azimuth.unwrap_or(state.azimuth),
            elevation: key.elevation.unwrap_or(state.elevation),
            zoom: key.zoom.unwrap_or(state.zoom),
        };
        times.push(key.time);
        values.push(vec![state.azimuth, state.elevation, libm::log(state.zoom)]);
    }
    AnglePath(Spline::new(times, values, file.interpolation))
}

fn placed(key: &Key, before: &Camera) -> Camera {
    let projection = match (key.height, key.fov) {
        (Some(height), _) => Projection::Orthographic { height },
        (_, Some(fov)) => Projection::Perspective { fov },
        (None, None) => before.projection,
    };
    Camera {
        eye: key.eye.unwrap_or(before.eye),
        target: key.target.unwrap_or(before.target),
        up: key.up.unwrap_or(before.up),
        projection,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::parse_keys;
    use super::*;

    fn path(text: &str) -> Result<CameraPath, ParameterError> {
        let file = parse_keys(text, Path::new("")).unwrap();
        let usual = Camera::framing((DVec3::NEG_ONE, DVec3::ONE), 0.0, 0.0, None);
        file.camera_path(&usual, (30.0, 20.0)).map(|path| path.expect("keys with cameras"))
    }

    #[test]
    fn cameras_by_place_hit_their_keys_and_circle_between() {
        let text = "
            [[keys]]
            eye = [0, 0, 4]
            target = [0, 0, 0]
            height = 3
            [[keys]]
            time = 1
            eye = [4, 0, 0]
            target = [0, 0, 0]
            [[keys]]
            time = 3
            eye = [8, 1, 0]
            target = [0, 1, 0]
            up = [0, 5, 0]
            height = 6
        ";
        let CameraPath::Placed(path) = path(text).unwrap() else { panic!("by place") };
        assert_eq!(
            (path.at(0.0).eye, path.at(1.0).eye, path.at(3.0).eye),
            (path.keys[0].1.eye, path.keys[1].1.eye, path.keys[2].1.eye)
        );
        assert_eq!(path.at(3.0).up, DVec3::new(0.0, 5.0, 0.0), "as it was written");
        for i in 1..100 {
            let camera = path.at(0.01 * f64::from(i));
            assert!((camera.eye.length() - 4.0).abs() < 1e-12 && camera.frame().is_ok(), "on the sphere: {camera:?}");
            assert_eq!(camera.projection, Projection::Orthographic { height: libm::exp(libm::log(3.0)) });
        }
        // Just before a key it is where the key is.
        let near = path.at(3.0 - 1e-9);
        assert!((near.eye - path.at(3.0).eye).length() < 1e-6);
        let later = path.at(2.0);
        assert!((4.0..8.0).contains(&later.eye.distance(later.target)) && (0.0..1.0).contains(&later.target.y));
    }

    #[test]
    fn angles_turn_as_far_as_they_say() {
        let CameraPath::Around(path) =
            path("[[keys]]\nazimuth = 0\n[[keys]]\ntime = 2\nazimuth = 360\nzoom = 4").unwrap()
        else {
            panic!("by angles")
        };
        let half = path.at(1.0);
        assert!((half.azimuth - 180.0).abs() < 1e-9 && half.elevation == 20.0 && (half.zoom - 2.0).abs() < 1e-12);
        assert_eq!(path.at(2.0).azimuth, 360.0);
    }

    #[test]
    fn cameras_that_see_nothing_or_differ_in_kind_are_refused() {
        let wrong = path("[[keys]]\neye = [0, 0, 1]\ntarget = [0, 0, 1]").unwrap_err();
        assert_eq!(wrong.field, "keys[0].eye");
        let text = "[[keys]]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nfov = 30\n[[keys]]\ntime = 1\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nheight = 2";
        assert_eq!(path(text).unwrap_err().field, "keys[1]");
    }
}
