//! Scene files: from TOML text to a scene and a view, and back.

mod annotations_section;
mod commented;
mod complete;
mod error;
mod file_name;
mod inline;
mod key_help;
mod key_page;
mod labels;
mod labels_section;
mod named_transfer;
mod resample_section;
mod resolve;
mod scattering_section;
mod scene_file;
mod sections;
mod surface_entry;
mod transfer_points;
mod volume;
mod volume_section;
mod wrong_value;

use std::path::Path;

use vr_core::memory;

use crate::atomic::write_whole;
use crate::error::{FileError, WriteError};
use crate::regular_file;

pub use annotations_section::AnnotationsSection;
pub use commented::commented_scene;
pub use error::SceneFileError;
pub use file_name::FileName;
pub use key_page::scene_keys;
pub use labels_section::{LabelLook, LabelName, LabelSection, LabelsSection};
pub use resample_section::{FinestWord, ResampleSection, ResampleSize};
pub use resolve::{LoadedScene, SceneMesh, outline_scene, preset_by_name, resolve_scene, resolve_scene_around};
pub use scattering_section::{AlbedoEntry, ColorWord, PhaseEntry, PointLightEntry, ScatteringSection};
pub use scene_file::SceneFile;
pub use sections::{
    CameraSection, ColorEncoding, CompositingName, ImageSection, LightEntry, LookName, MeshSection, ProjectionName,
    RenderSection, ShadingSection, TransferSection, USUAL_FOV,
};
pub use surface_entry::{FaceName, FinishEntry, ShapeEntry, SurfaceEntry};
pub(crate) use transfer_points::stretching;
pub use transfer_points::{TransferPoints, TransferRowSection};
pub use volume::{LoadedVolume, load_volume};
pub use volume_section::{FileSource, GridDescription, VolumeSection, VolumeSource};

/// Bytes of memory that the parser takes for a byte of text.
const PARSED: u64 = 50;

/// Reads a scene file, without the files that it names.
///
/// # Errors
/// A [`SceneFileError`] naming the file and the line; an unknown key comes with the known one most like it.
pub fn read_scene(path: impl AsRef<Path>) -> Result<SceneFile, SceneFileError> {
    let path = path.as_ref();
    let text = regular_file::read_text(path, regular_file::MAX_TEXT).map_err(|e| FileError::new(path, e))?;
    parse_scene(&text, path)
}

/// Reads the text of a scene file; `path` is what errors call it.
///
/// # Errors
/// A [`SceneFileError`] naming the line; an unknown key comes with the known one most like it.
pub fn parse_scene(text: &str, path: &Path) -> Result<SceneFile, SceneFileError> {
    memory::check("the scene file", PARSED * text.len() as u64)
        .map_err(|source| SceneFileError::Memory { path: path.into(), source })?;
    toml::from_str(text).map_err(|e| SceneFileError::of_toml(&e, text, path))
}

/// Reads a scene file and everything that it names.
///
/// # Errors
/// A [`SceneFileError`] naming the file and the field.
pub fn load_scene(path: impl AsRef<Path>) -> Result<LoadedScene, SceneFileError> {
    let path = path.as_ref();
    let mut loaded = resolve_scene(&read_scene(path)?, path)?;
    loaded.files.insert(0, path.into());
    Ok(loaded)
}

/// A scene file's text.
///
/// # Errors
/// [`SceneFileError::Text`] for a number that TOML cannot hold.
pub fn scene_text(file: &SceneFile) -> Result<String, SceneFileError> {
    toml::to_string(file).map_err(|e| SceneFileError::Text { message: e.to_string() })
}

/// Writes a scene file.
///
/// # Errors
/// A [`WriteError`] naming the file; no part of it is left behind then.
pub fn write_scene(path: impl AsRef<Path>, file: &SceneFile) -> Result<(), WriteError> {
    let path = path.as_ref();
    let text = scene_text(file).map_err(|e| WriteError::Encode { path: path.into(), message: e.to_string() })?;
    write_whole(path, |out| {
        out.write_all(text.as_bytes()).map_err(|source| WriteError::Io { path: path.into(), source })
    })
}
