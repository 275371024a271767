//! What can go wrong between a file and a volume, and between a frame and a file.

use std::io;
use std::path::{Path, PathBuf};

use vr_core::GridError;

use crate::points::PointFileError;

/// Why a file gives no volume. Every message is one line that names the file, the field, what was found and what is allowed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A field of the header (or of the request) that makes no sense.
    #[error("{}: {field}: found {found}; {allowed}", path.display())]
    Field {
        /// Which file.
        path: PathBuf,
        /// The field, as the format names it.
        field: String,
        /// What was found, shortened.
        found: String,
        /// What would be right.
        allowed: String,
    },
    /// A data file that a header names and that cannot be opened.
    #[error("{}: data file {}: {source}; it must lie where the header says", path.display(), data.display())]
    DataFile {
        /// The header.
        path: PathBuf,
        /// The file that it names.
        data: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// More or fewer bytes than the header claims.
    #[error(
        "{}: the header claims {claimed} bytes of voxels, found {found}; the two must agree{hint}",
        path.display()
    )]
    Length {
        /// The file with the voxels.
        path: PathBuf,
        /// What sizes and type add up to.
        claimed: u64,
        /// What is there (at least, where there are many more).
        found: u64,
        /// What may have happened; empty, or starting with a bracket.
        hint: &'static str,
    },
    /// A compressed stream, or text, that is damaged.
    #[error("{}: {encoding} data are damaged: {source}", path.display())]
    Damaged {
        /// The file with the voxels.
        path: PathBuf,
        /// How they are encoded.
        encoding: &'static str,
        /// What the decoder says.
        source: io::Error,
    },
    /// Several frames or components, of which a volume has one.
    #[error("{}: holds {count} {what}s, a volume has one: pick it with {flag} N (0 to {})", path.display(), count - 1)]
    Choose {
        /// Which file.
        path: PathBuf,
        /// `frame` or `component`.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// The flag of `vr`, and the field of [`crate::ReadOptions`].
        flag: &'static str,
    },
    /// A format that is known and not read.
    #[error("{}: unsupported format {format}; supported are {SUPPORTED}", path.display())]
    Unsupported {
        /// Which file.
        path: PathBuf,
        /// The format found.
        format: &'static str,
    },
    /// A file that nothing is known about.
    #[error(
        "{}: format not recognised by content or name; supported are {SUPPORTED}; raw data need a description \
         (--dims and --type) or a name like foot_256x256x256_uint8.raw",
        path.display()
    )]
    Unrecognised {
        /// Which file.
        path: PathBuf,
    },
    /// Sizes, spacing or orientation that make no grid.
    #[error("{}: {source}", path.display())]
    Grid {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        source: GridError,
    },
    /// A file of scattered points with something wrong in it.
    #[error(transparent)]
    Points(PointFileError),
}

/// The formats that are read, as messages list them.
const SUPPORTED: &str = "NRRD, MetaImage, NIfTI-1 and -2, raw; points as CSV, VTK, NumPy or HDF5";

impl ReadError {
    pub(crate) fn io(path: &Path, source: io::Error) -> Self {
        Self::Io { path: path.into(), source }
    }

    pub(crate) fn grid(path: &Path, source: GridError) -> Self {
        Self::Grid { path: path.into(), source }
    }
}

/// A wrong field, before it is known which file it came from: what the header parsers return.
#[derive(Debug, PartialEq)]
pub(crate) struct FieldError {
    pub field: String,
    pub found: String,
    pub allowed: String,
}

impl FieldError {
    pub fn new(field: impl Into<String>, found: impl std::fmt::Display, allowed: impl Into<String>) -> Self {
        Self { field: field.into(), found: shown(&found.to_string()), allowed: allowed.into() }
    }

    pub fn in_file(self, path: &Path) -> ReadError {
        let Self { field, found, allowed } = self;
        ReadError::Field { path: path.into(), field, found, allowed }
    }
}

/// Text from a file, fit for one line of a terminal: control characters escaped, and not too long.
pub(crate) fn shown(text: &str) -> String {
    const MOST: usize = 60;
    let mut s: String = text.chars().take(MOST).flat_map(char::escape_debug).collect();
    if text.chars().nth(MOST).is_some() {
        s.push('…');
    }
    if s.is_empty() {
        s.push_str("nothing");
    }
    s
}

/// Why a file was not written. Nothing is left behind then.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The place cannot be written to.
    #[error("{}: cannot be written: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The format cannot hold what was to be written.
    #[error("{}: {message}", path.display())]
    Encode {
        /// Which file.
        path: PathBuf,
        /// What the encoder says.
        message: String,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_stay_on_one_line() {
        let e = FieldError::new("type", "a\nb".repeat(50), "one of u8, i8").in_file(Path::new("x.nrrd"));
        let text = e.to_string();
        assert!(!text.contains('\n') && text.len() < 200, "{text}");
        assert!(text.starts_with("x.nrrd: type: found a\\nb"), "{text}");
    }
}
