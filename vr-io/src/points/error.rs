//! What can be wrong with a file of points.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use vr_core::PointError;

use crate::error::{FieldError, ReadError};

/// Why a file gives no points. Every message is one line that names the file, the place, what was found and what is allowed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PointFileError {
    /// The file cannot be opened or read.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// Something in the file, or asked of it, that makes no sense.
    #[error("{}: {place}: found {found}; {allowed}", path.display())]
    Content {
        /// Which file.
        path: PathBuf,
        /// The line from 1, the point from 0, the column, or the part of the file.
        place: String,
        /// What was found, shortened.
        found: String,
        /// What would be right.
        allowed: String,
    },
    /// A file that holds no points, or of a format that is not read.
    #[error("{}: no points by content or name; supported are {}", path.display(), super::SUPPORTED)]
    Unrecognised {
        /// Which file.
        path: PathBuf,
    },
    /// A format that this build of the program does not read.
    #[error("{}: {format} is read by builds with the feature `{feature}` alone: cargo build --features {feature}", path.display())]
    Feature {
        /// Which file.
        path: PathBuf,
        /// The format found.
        format: &'static str,
        /// The feature of `vr-io` and `vr-cli` that reads it.
        feature: &'static str,
    },
    /// Positions, radii, weights and values that make no set of points.
    #[error("{}: {source}", path.display())]
    Points {
        /// Which file.
        path: PathBuf,
        /// What is wrong with them.
        source: PointError,
    },
}

/// What is wrong, before it is known which file it is in.
#[derive(Debug)]
pub(super) enum Trouble {
    Io(io::Error),
    Content(FieldError),
    Points(PointError),
}

impl Trouble {
    pub fn new(place: impl Into<String>, found: impl Display, allowed: impl Into<String>) -> Self {
        Self::Content(FieldError::new(place, found, allowed))
    }

    pub fn in_file(self, path: &Path) -> PointFileError {
        let path = path.into();
        match self {
            Self::Io(source) => PointFileError::Io { path, source },
            Self::Content(FieldError { field, found, allowed }) => {
                PointFileError::Content { path, place: field, found, allowed }
            }
            Self::Points(source) => PointFileError::Points { path, source },
        }
    }
}

impl From<io::Error> for Trouble {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

impl From<FieldError> for Trouble {
    fn from(error: FieldError) -> Self {
        Self::Content(error)
    }
}

impl From<PointError> for Trouble {
    fn from(error: PointError) -> Self {
        Self::Points(error)
    }
}

impl From<PointFileError> for ReadError {
    fn from(error: PointFileError) -> Self {
        match error {
            PointFileError::Io { path, source } => Self::Io { path, source },
            other => Self::Points(other),
        }
    }
}
