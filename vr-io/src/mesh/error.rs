//! What can be wrong with a mesh file.

use std::io;
use std::path::{Path, PathBuf};

use vr_core::MeshError;

use crate::error::FieldError;

/// Why a file gives no surface. Every message is one line that names the file, the place, what was found and what is allowed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshFileError {
    /// The file cannot be opened or read.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Something in the file that makes no sense.
    #[error("{}: {place}: found {found}; {allowed}", path.display())]
    Content {
        /// Which file.
        path: PathBuf,
        /// The line, from 1, or the part of the file.
        place: String,
        /// What was found, shortened.
        found: String,
        /// What would be right.
        allowed: String,
    },
    /// A file that is no mesh, or of a format that is not read.
    #[error(
        "{}: no mesh by content or name; supported are STL (text and binary), OBJ and PLY (text and binary)",
        path.display()
    )]
    Unrecognised {
        /// Which file.
        path: PathBuf,
    },
    /// Vertices and triangles that make no surface.
    #[error("{}: {source}", path.display())]
    Surface {
        /// Which file.
        path: PathBuf,
        /// What is wrong with them.
        source: MeshError,
    },
}

/// What is wrong, before it is known which file it is in.
#[derive(Debug)]
pub(super) enum Trouble {
    Content(FieldError),
    Surface(MeshError),
}

impl From<FieldError> for Trouble {
    fn from(error: FieldError) -> Self {
        Self::Content(error)
    }
}

impl From<MeshError> for Trouble {
    fn from(error: MeshError) -> Self {
        Self::Surface(error)
    }
}

impl Trouble {
    pub fn in_file(self, path: &Path) -> MeshFileError {
        let path = path.into();
        match self {
            Self::Content(FieldError { field, found, allowed }) => {
                MeshFileError::Content { path, place: field, found, allowed }
            }
            Self::Surface(source) => MeshFileError::Surface { path, source },
        }
    }
}

/// A complaint about a line, counted from 0.
pub(super) fn in_line(line: usize, found: impl std::fmt::Display, allowed: impl Into<String>) -> FieldError {
    FieldError::new(format!("line {}", line + 1), found, allowed)
}
