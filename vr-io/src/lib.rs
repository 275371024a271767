//! Volumes, scene files and pictures on disk.

mod atomic;
mod decode;
mod detect;
mod encoding;
mod error;
mod exr;
mod file_pattern;
mod layout;
mod mapped;
mod metaimage;
mod nifti;
mod nrrd;
mod paraview;
mod payload;
mod picture;
mod png;
mod raw;
mod read;
mod samples;
mod scalar;
mod scene;
mod world;

pub use error::{ReadError, WriteError};
pub use exr::write_exr;
pub use nifti::Transform;
pub use nrrd::{NrrdEncoding, NrrdOptions, NrrdValues, write_nrrd};
pub use paraview::{ColorMap, ColorMapError, parse_color_maps, read_color_maps};
pub use picture::write;
pub use png::{Encode, PngDepth, PngOptions, write_png};
pub use raw::RawDescription;
pub use read::{FileInfo, Loaded, ReadOptions, read};
pub use scalar::{Endian, ScalarType};
pub use scene::{
    LoadedScene, SceneFileError, load_scene, parse_scene, read_scene, resolve_scene, scene_text, write_scene,
};
pub use world::{Space, orientation};
