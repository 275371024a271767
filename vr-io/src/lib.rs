//! Volumes, scene files and pictures on disk.

mod decode;
mod detect;
mod encoding;
mod error;
mod file_pattern;
mod layout;
mod mapped;
mod metaimage;
mod nifti;
mod nrrd;
mod payload;
mod raw;
mod read;
mod samples;
mod scalar;
mod world;

pub use error::{ReadError, WriteError};
pub use nifti::Transform;
pub use raw::RawDescription;
pub use read::{FileInfo, Loaded, ReadOptions, read};
pub use scalar::{Endian, ScalarType};
pub use world::{Space, orientation};
