//! Environment maps: pictures of the light from all sides.

use std::path::Path;

use vr_core::scattering::EnvironmentImage;

use crate::error::shown_path;
use crate::picture_read::read_picture;
use crate::png::Encode;
use crate::scene::SceneFileError;

/// An environment map from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedEnvironment {
    /// The map.
    pub image: EnvironmentImage,
    /// Notes on everything assumed, one line each.
    pub notes: Vec<String>,
}

/// Reads an equirectangular picture as light from all sides: an EXR, whose numbers are radiances, or any picture of [`read_picture`], by the sRGB curve.
/// Radiances below 0, which filters and changes of colour space make, are taken for 0.
///
/// # Errors
/// [`SceneFileError::Picture`] for a file that is no picture, [`SceneFileError::Parameter`] for radiances that are not finite or too large.
pub fn read_environment_map(path: impl AsRef<Path>) -> Result<LoadedEnvironment, SceneFileError> {
    let path = path.as_ref();
    let frame = read_picture(path, Encode::Srgb)?.frame;
    let [width, height] = frame.size();
    let mut notes = Vec::new();
    if u64::from(width) != 2 * u64::from(height) {
        notes.push(format!(
            "{}: {width}x{height} pixels; an equirectangular picture of all directions is twice as wide as high",
            shown_path(path)
        ));
    }
    let mut negative = 0usize;
    let light = |radiance: f32| {
        let is_negative = radiance < 0.0;
        negative += usize::from(is_negative);
        if is_negative { 0.0 } else { radiance }
    };
    let radiances: Vec<f32> = frame.pixels().iter().flat_map(|&[r, g, b, _]| [r, g, b]).map(light).collect();
    if negative > 0 {
        notes.push(format!("{}: {negative} radiances below 0 are taken for 0", shown_path(path)));
    }
    let pixels = radiances.chunks_exact(3).map(|rgb| [rgb[0], rgb[1], rgb[2]]).collect();
    let image = EnvironmentImage::new(frame.size(), pixels)
        .map_err(|source| SceneFileError::Parameter { path: path.into(), source })?;
    Ok(LoadedEnvironment { image, notes })
}

#[cfg(test)]
mod tests {
    use vr_core::Frame;

    use super::*;

    #[test]
    fn radiances_are_kept_and_what_is_wrong_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, size: [u32; 2], pixels: Vec<[f32; 4]>| {
            let path = folder.path().join(name);
            crate::write_exr(&path, &Frame::new(size, pixels, None)).unwrap();
            path
        };
        let sky = write("sky.exr", [2, 1], vec![[1e3, 0.5, 0.25, 1.0], [-1e-3, 0.0, 2.0, 1.0]]);
        let loaded = read_environment_map(&sky).unwrap();
        assert_eq!(loaded.image.pixels(), [[1e3, 0.5, 0.25], [0.0, 0.0, 2.0]]);
        assert!(loaded.notes.len() == 1 && loaded.notes[0].contains("1 radiances below 0"), "{:?}", loaded.notes);
        let square = write("square.exr", [1, 1], vec![[1.0; 4]]);
        assert!(read_environment_map(&square).unwrap().notes[0].contains("twice as wide"));
        let bad = write("bad.exr", [2, 1], vec![[1.0; 4], [f32::NAN, 0.0, 0.0, 1.0]]);
        let message = read_environment_map(&bad).unwrap_err().to_string();
        assert!(message.contains("bad.exr") && message.contains("column 1, row 0"), "{message}");
        assert!(matches!(read_environment_map(folder.path().join("no.exr")), Err(SceneFileError::Picture(_))));
    }
}
