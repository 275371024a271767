//! Frames between keys.

use vr_core::{Camera, ParameterError, Projection};
use vr_io::{CameraPath, KeyFile};
use vr_look::{centre_of, fit_together};

use crate::failure::Failure;

use super::shot::Shot;
use super::stage::Stage;

/// Largest number of frames.
const MAX_FRAMES: f64 = 100_000.0;

/// Returns the times of all frames: one every 1/fps seconds from the first key to the last; or a number of them, spread evenly with one at
/// each end.
///
/// # Errors
/// More frames than anyone can want.
pub fn times(keys: &KeyFile, frames: Option<u32>, fps: f64) -> Result<Vec<f64>, Failure> {
    let (first, last) = keys.span();
    // A frame that rounding alone keeps from a key is at the key.
    let snapped = |time: f64| {
        let near = |key: &f64| (key - time).abs() <= 1e-9 * (last - first).max(1.0 / fps);
        keys.keys.iter().map(|key| key.time).find(near).unwrap_or(time)
    };
    if let Some(frames) = frames {
        let steps = f64::from(frames.max(2) - 1);
        return Ok((0..frames).map(|i| snapped(first + (last - first) * (f64::from(i) / steps))).collect());
    }
    let count = ((last - first) * fps * (1.0 + 1e-12) + 1e-9).floor() + 1.0;
    if !(1.0..=MAX_FRAMES).contains(&count) {
        return Err(Failure::usage(format!(
            "--fps: the keys last {} s, which is {count} frames; must be 1 to 100000, by other times, --fps, or --frames N",
            last - first
        )));
    }
    Ok((0..count as usize).map(|i| snapped(first + i as f64 / fps)).collect())
}

/// Returns the frames at some times.
///
/// # Errors
/// A camera that sees nothing, or that flags and keys both place.
pub fn shots(keys: &KeyFile, times: &[f64], stage: &Stage<'_>) -> Result<Vec<Shot>, ParameterError> {
    let usual = Camera { up: stage.up, ..stage.camera };
    let cameras: Vec<Camera> = match keys.camera_path(&usual, stage.usual_angles())? {
        None => vec![stage.camera; times.len()],
        Some(CameraPath::Placed(path)) => times.iter().map(|&time| path.at(time)).collect(),
        Some(CameraPath::Around(_)) if stage.is_placed => {
            let allowed = "keys with angles place the camera: leave --eye, --target and --up out";
            return Err(ParameterError { field: "keys".into(), found: "azimuth, elevation or zoom".into(), allowed });
        }
        Some(CameraPath::Around(path)) => {
            let angles: Vec<_> = times.iter().map(|&time| path.at(time)).collect();
            let cameras: Vec<Camera> = angles.iter().map(|a| stage.around((a.azimuth, a.elevation))).collect();
            // Zoom 1 shows all that is visible, all the time.
            let cameras = match centre_of(&stage.visible).filter(|_| stage.fits) {
                Some(pivot) => fit_together(&cameras, pivot, &stage.visible, stage.aspect),
                None => cameras,
            };
            cameras.into_iter().zip(angles).map(|(camera, a)| zoomed(camera, a.zoom)).collect()
        }
    };
    let mut shots = Vec::new();
    for (camera, &time) in cameras.into_iter().zip(times) {
        camera.frame()?;
        shots.push(Shot { camera, points: keys.points_at(time), clip: keys.clip_at(time) });
    }
    Ok(shots)
}

/// A narrower picture, or a nearer eye.
fn zoomed(camera: Camera, zoom: f64) -> Camera {
    match camera.projection {
        Projection::Orthographic { height } => {
            Camera { projection: Projection::Orthographic { height: height / zoom }, ..camera }
        }
        Projection::Perspective { .. } => Camera { eye: camera.target + (camera.eye - camera.target) / zoom, ..camera },
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn file(times: &[f64]) -> KeyFile {
        let text: String = times.iter().map(|time| format!("[[keys]]\ntime = {time:?}\n")).collect();
        vr_io::parse_keys(&text, Path::new("")).unwrap()
    }

    #[test]
    fn frames_hit_the_keys() {
        let keys = [0.0, 0.3, 1.1, 2.0];
        let all = times(&file(&keys), None, 30.0).unwrap();
        assert_eq!(all.len(), 61);
        assert!(keys.iter().all(|key| all.contains(key)), "{all:?}");
        let shifted = times(&file(&[0.1, 0.4, 0.7]), None, 10.0).unwrap();
        assert!(shifted.len() == 7 && [0.1, 0.4, 0.7].iter().all(|key| shifted.contains(key)), "{shifted:?}");
        assert_eq!(times(&file(&[0.0, 2.0]), Some(5), 24.0).unwrap(), [0.0, 0.5, 1.0, 1.5, 2.0]);
        assert_eq!(times(&file(&[4.0]), None, 24.0).unwrap(), [4.0]);
        assert_eq!(times(&file(&[4.0, 5.0]), Some(1), 24.0).unwrap(), [4.0]);
        assert!(times(&file(&[0.0, 1e9]), None, 24.0).unwrap_err().to_string().contains("--frames N"));
    }
}
