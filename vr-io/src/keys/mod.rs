//! Key frames: a file of places and looks at certain times, and everything between them.
//!
//! ```toml
//! interpolation = "smooth"   # or "linear", or "ease": come to rest at each key
//!
//! [[keys]]
//! time = 0.0                 # seconds
//! azimuth = 0.0
//! elevation = 10.0
//! zoom = 1.0
//!
//! [[keys]]
//! time = 3.0
//! azimuth = 360.0
//! zoom = 2.0                 # elevation: as in the key before
//! clip = { planes = [{ normal = [0.0, 0.0, 1.0], offset = 12.0 }] }
//! ```

mod camera_path;
mod mixed;
mod rotation_spline;
mod spline;

use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use vr_core::{Camera, Clip, ControlPoint, ParameterError};

use crate::error::FileError;
use crate::regular_file;
use crate::scene::SceneFileError;

pub use camera_path::{AnglePath, Angles, CameraPath, PlacedPath};

/// Course between two keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// A spline through the keys, without a jerk and without overshooting any of them; what stays the same from one key to the next rests.
    #[default]
    Smooth,
    /// At constant speed from key to key.
    Linear,
    /// At rest at each key, fastest half-way between.
    Ease,
}

/// A file of key frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyFile {
    /// Course between the keys.
    #[serde(default)]
    pub interpolation: Interpolation,
    /// The keys, by time.
    pub keys: Vec<Key>,
}

/// State at one time. What a key leaves out is what the other keys make of it; what none has is the scene's own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Key {
    /// Seconds from any beginning.
    pub time: f64,
    /// Camera by angles: degrees to the right of the front.
    pub azimuth: Option<f64>,
    /// Camera by angles: degrees above.
    pub elevation: Option<f64>,
    /// Camera by angles: size of what is seen, 1 where everything visible is in the picture throughout.
    pub zoom: Option<f64>,
    /// Camera by place: position of the eye.
    pub eye: Option<DVec3>,
    /// Camera by place: point that the middle of the picture shows.
    pub target: Option<DVec3>,
    /// Camera by place: direction that is up in the picture.
    pub up: Option<DVec3>,
    /// Camera by place: world height of an orthographic picture.
    pub height: Option<f64>,
    /// Camera by place: vertical angle of a perspective picture in degrees.
    pub fov: Option<f64>,
    /// Control points of the transfer function, with linear colours; as many in each key that has any.
    pub points: Option<Vec<ControlPoint>>,
    /// Crop box and planes; as many in each key that has a clip.
    pub clip: Option<Clip>,
}

/// Reads a file of key frames.
///
/// # Errors
/// A [`SceneFileError`] naming the file and the line or the key.
pub fn read_keys(path: impl AsRef<Path>) -> Result<KeyFile, SceneFileError> {
    let path = path.as_ref();
    let text = regular_file::read_text(path, regular_file::MAX_TEXT).map_err(|e| FileError::new(path, e))?;
    parse_keys(&text, path)
}

/// Reads the text of key frames; `path` is what errors call it.
///
/// # Errors
/// A [`SceneFileError`] naming the line or the key.
pub fn parse_keys(text: &str, path: &Path) -> Result<KeyFile, SceneFileError> {
    let file: KeyFile = toml::from_str(text).map_err(|e| SceneFileError::of_toml(&e, text, path))?;
    file.check().map_err(|source| SceneFileError::Parameter { path: path.into(), source })?;
    Ok(file)
}

impl KeyFile {
    /// Returns the times of the first and the last key.
    pub fn span(&self) -> (f64, f64) {
        let time = |key: Option<&Key>| key.map_or(0.0, |key| key.time);
        (time(self.keys.first()), time(self.keys.last()))
    }

    /// Returns the camera's path; `None` where no key has a camera. `usual` gives what the keys leave open: angles by its own, the direction
    /// that is up and the projection by the camera.
    ///
    /// # Errors
    /// A key whose camera sees nothing, or is orthographic where others are perspective.
    pub fn camera_path(&self, usual: &Camera, angles: (f64, f64)) -> Result<Option<CameraPath>, ParameterError> {
        camera_path::of(self, usual, angles)
    }

    /// Returns the control points at a time: mixed of those of the keys around, which a point rests at; `None` where no key has any.
    pub fn points_at(&self, time: f64) -> Option<Vec<ControlPoint>> {
        mixed::points(self, time)
    }

    /// Returns crop box and planes at a time: mixed of those of the keys around; `None` where no key has any.
    pub fn clip_at(&self, time: f64) -> Option<Clip> {
        mixed::clip(self, time)
    }

    /// Checks all that does not depend on a scene.
    fn check(&self) -> Result<(), ParameterError> {
        if self.keys.is_empty() {
            return Err(wrong("keys", "nothing", "there must be at least one [[keys]]"));
        }
        for (i, key) in self.keys.iter().enumerate() {
            let field = |name: &str| format!("keys[{i}].{name}");
            if !key.time.is_finite() || i > 0 && key.time <= self.keys[i - 1].time {
                return Err(ParameterError::new(
                    field("time"),
                    key.time,
                    "must be finite and later than the key before",
                ));
            }
            if let Some(zoom) = key.zoom.filter(|zoom| !(1e-3..=1e3).contains(zoom)) {
                return Err(ParameterError::new(field("zoom"), zoom, "must be 0.001 to 1000"));
            }
            for (name, angle) in [("azimuth", key.azimuth), ("elevation", key.elevation)] {
                if let Some(angle) = angle.filter(|angle| !(-1e6..=1e6).contains(angle)) {
                    return Err(ParameterError::new(field(name), angle, "must be finite, 1000000 degrees at most"));
                }
            }
            if key.is_placed() && (key.eye.is_none() || key.target.is_none()) {
                return Err(wrong(&field("eye"), "half a camera", "a camera by place needs both eye and target"));
            }
            if key.height.is_some() && key.fov.is_some() {
                return Err(wrong(&field("height"), "height and fov", "a camera has a height or an angle, not both"));
            }
        }
        let [by_angles, placed] = [Key::has_angles, Key::is_placed].map(|has| self.keys.iter().position(has));
        if let (Some(a), Some(b)) = (by_angles, placed) {
            let found = format!("angles or zoom in keys[{a}], eye or target in keys[{b}]");
            return Err(wrong("keys", &found, "the cameras of one file must all be given in one way"));
        }
        mixed::check(self)
    }
}

impl Key {
    fn has_angles(&self) -> bool {
        self.azimuth.is_some() || self.elevation.is_some() || self.zoom.is_some()
    }

    fn is_placed(&self) -> bool {
        let Self { eye, target, up, height, fov, .. } = self;
        eye.is_some() || target.is_some() || up.is_some() || height.is_some() || fov.is_some()
    }
}

fn wrong(field: &str, found: &str, allowed: &'static str) -> ParameterError {
    ParameterError { field: field.into(), found: found.into(), allowed }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(text: &str) -> Result<KeyFile, String> {
        parse_keys(text, Path::new("k.toml")).map_err(|e| e.to_string())
    }

    #[test]
    fn faults_are_named() {
        for (text, words) in [
            ("", "keys"),
            ("keys = []", "at least one"),
            ("[[keys]]\ntime = 1\n[[keys]]\ntime = 1", "keys[1].time: found 1"),
            ("[[keys]]\ntime = nan", "keys[0].time"),
            ("[[keys]]\ntime = 0\nazimut = 3", "did you mean 'azimuth'"),
            ("[[keys]]\neye = [0, 0, 1]", "both eye and target"),
            ("[[keys]]\nzoom = 0", "0.001 to 1000"),
            ("[[keys]]\nazimuth = inf", "keys[0].azimuth"),
            ("[[keys]]\nzoom = 1\n[[keys]]\ntime = 1\neye = [0,0,1]\ntarget = [0,0,0]", "all be given in one way"),
            ("[[keys]]\neye = [0,0,1]\ntarget = [0,0,0]\nfov = 3\nheight = 3", "not both"),
            ("interpolation = \"cubic\"\n[[keys]]", "smooth"),
            ("[[keys]]\nclip = { box = [[0,0,0],[1,1,1]] }\n[[keys]]\ntime = 1\nclip = {}", "keys[1].clip"),
            ("[[keys]]\npoints = []", "keys[0].points"),
        ] {
            let error = keys(text).unwrap_err();
            assert!(error.starts_with("k.toml: ") && error.contains(words) && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn a_file_may_leave_cameras_out() {
        let file = keys("[[keys]]\n[[keys]]\ntime = 2\nclip = {}").unwrap();
        let usual = Camera::framing((DVec3::NEG_ONE, DVec3::ONE), 0.0, 0.0, None);
        assert!(file.camera_path(&usual, (0.0, 0.0)).unwrap().is_none());
        assert_eq!((file.span(), file.points_at(1.0), file.clip_at(1.0)), ((0.0, 2.0), None, Some(Clip::default())));
    }
}
