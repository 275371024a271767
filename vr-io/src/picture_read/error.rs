//! Errors of reading pictures.

use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use vr_core::memory::MemoryError;

use crate::error::{on_one_line, shown_path};

/// The reason why a file gives no picture. Every message is one line that names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The file cannot be opened or read.
    #[error("{}: {source}", shown_path(path))]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// A format that is not read.
    #[error("{}: no picture that can be read; supported are EXR, PNG, JPEG, TIFF, BMP and PNM", shown_path(path))]
    Unrecognised {
        /// The file.
        path: PathBuf,
    },
    /// A sound file that holds what is not read: deep data, say.
    #[error("{}: {format}: not supported: {message}", shown_path(path))]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The format found.
        format: &'static str,
        /// The feature that is not read.
        message: String,
    },
    /// A file that is damaged or cut off.
    #[error("{}: {format}: damaged: {message}", shown_path(path))]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The format found.
        format: &'static str,
        /// The decoder's message.
        message: String,
    },
    /// A size that no picture of this file can have.
    #[error(
        "{}: size: found {}x{} pixels in a file of {length} bytes; at least one, at most {} and no more than such a file holds",
        shown_path(path), size[0], size[1], super::MAX_PIXELS
    )]
    Size {
        /// The file.
        path: PathBuf,
        /// Width and height that the header claims.
        size: [u64; 2],
        /// Length of the file in bytes.
        length: u64,
    },
    /// Too little memory for the picture.
    #[error("{}: {source}", shown_path(path))]
    Memory {
        /// The file.
        path: PathBuf,
        /// Its size, and the memory that is left.
        source: MemoryError,
    },
    /// An EXR file without colours.
    #[error("{}: channels: found {found}; R, G and B or Y are needed", shown_path(path))]
    Channels {
        /// The file.
        path: PathBuf,
        /// The channels that are there, shortened.
        found: String,
    },
}

impl PictureError {
    pub(crate) fn damaged(path: &Path, format: &'static str, message: impl Display) -> Self {
        Self::Damaged { path: path.into(), format, message: one_line(&message.to_string()) }
    }

    pub(crate) fn unsupported(path: &Path, format: &'static str, message: impl Display) -> Self {
        Self::Unsupported { path: path.into(), format, message: one_line(&message.to_string()) }
    }
}

/// A library's message on one line, without control characters (it may quote the file).
fn one_line(message: &str) -> String {
    let words: Vec<&str> = message.split_whitespace().collect();
    on_one_line(&words.join(" ")).into_owned()
}
