//! Errors of reading files and of writing frames.

use std::borrow::Cow;
use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use vr_core::amr::AmrError;
use vr_core::cancel::CancelToken;
use vr_core::cells::CellError;
use vr_core::labels::LabelError;
use vr_core::memory::MemoryError;
use vr_core::rectilinear::RectilinearError;
use vr_core::{GridError, MeshError, PointError};

/// The reason why a file gives no volume, points, surface or colour map: one line that names the file, the place in it, what was found and
/// what is allowed.
#[derive(Debug, thiserror::Error)]
#[error("{}: {kind}", shown_path(path))]
pub struct FileError {
    /// The file with the fault: the one that was asked for, or one that it names.
    pub path: PathBuf,
    /// The fault.
    pub kind: FileErrorKind,
}

impl FileError {
    pub(crate) fn new(path: &Path, kind: impl Into<FileErrorKind>) -> Self {
        // Once the work is cancelled, that is the reason of any fault, whatever a decoder took the end of its stream for.
        let kind = if CancelToken::current().is_cancelled() { FileErrorKind::Cancelled } else { kind.into() };
        Self { path: path.into(), kind }
    }
}

/// A fault of a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileErrorKind {
    /// The caller cancelled the work ([`vr_core::Control::cancellable`]).
    #[error("cancelled while it was read")]
    Cancelled,
    /// The file cannot be opened or read.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// Too little memory for what the file holds.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// Content, or a request, that makes no sense.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A data file that a header names and that cannot be opened.
    #[error("data file {}: {source}; it must lie where the header says", shown_path(data))]
    DataFile {
        /// The file that the header names.
        data: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// More or fewer bytes than the header claims.
    #[error("the header claims {claimed} bytes of voxels, found {found}; the two must agree{hint}")]
    Length {
        /// The bytes that sizes and type add up to.
        claimed: u64,
        /// The bytes that are there (at least, where there are many more).
        found: u64,
        /// A likely cause; empty, or starting with a bracket.
        hint: &'static str,
    },
    /// A compressed stream, or text, that is damaged.
    #[error("{encoding} data are damaged: {source}")]
    Damaged {
        /// The encoding of the voxels.
        encoding: &'static str,
        /// The decoder's error.
        source: io::Error,
    },
    /// A format that is known and not read.
    #[error("unsupported format {format}; supported are {VOLUMES}")]
    Unsupported {
        /// The format found.
        format: &'static str,
    },
    /// A format that is not known, or not one of those that were asked for.
    #[error("format not recognised by content or name; supported are {supported}")]
    Unrecognised {
        /// The formats that are read there.
        supported: &'static str,
    },
    /// A format that is read by builds with a feature alone.
    #[error("{format} is read by builds with the feature `{feature}` alone: cargo build --features {feature}")]
    Feature {
        /// The format found.
        format: &'static str,
        /// The feature of this crate that reads it.
        feature: &'static str,
    },
    /// Sizes, spacing or orientation that make no grid.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// Positions, radii, weights and values that make no set of points.
    #[error(transparent)]
    Points(#[from] PointError),
    /// Vertices, cells and values that make no mesh.
    #[error(transparent)]
    Cells(#[from] CellError),
    /// Blocks and levels that make no adaptive mesh.
    #[error(transparent)]
    Amr(#[from] AmrError),
    /// Planes and values that make no rectilinear grid.
    #[error(transparent)]
    Rectilinear(#[from] RectilinearError),
    /// Voxels that are no labels, or labels that do not fit the volume.
    #[error(transparent)]
    Labels(#[from] LabelError),
    /// Vertices and triangles that make no surface.
    #[error(transparent)]
    Surface(#[from] MeshError),
}

/// The formats of volumes, as messages list them.
pub(crate) const VOLUMES: &str = "NRRD, MetaImage, NIfTI-1 and -2, DICOM, VTK images, TIFF, folders of pictures, Zarr, NetCDF, HDF5 (with a feature), MRC, OpenVDB, PVM, SLC, NumPy, \
                                  OpenDX, Voreen; raw, with dims and a type or a name like \
                                  foo_256x256x256_uint8.raw; points as CSV, VTK, NumPy or HDF5; cells as VTK (.vtk, .vtu, .vts, .pvtu, .pvts), PLOT3D or Exodus II; rectilinear grids of VTK (.vtk, .vtr, .pvtr); \
                                  adaptive meshes of VTK (.vthb), AMReX or Enzo";

impl FileErrorKind {
    pub(crate) fn field(field: impl Into<String>, found: impl Display, allowed: impl Into<String>) -> Self {
        FieldError::new(field, found, allowed).into()
    }
}

/// A wrong field of a header, line of a text, point or column.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: found {found}; {}", on_one_line(field), on_one_line(allowed))]
pub struct FieldError {
    /// The field as the format names it, or the place: a line from 1, a point from 0, a column.
    pub field: String,
    /// The content found there, shortened.
    pub found: String,
    /// The content that would be right.
    pub allowed: String,
}

impl FieldError {
    pub(crate) fn new(field: impl Into<String>, found: impl Display, allowed: impl Into<String>) -> Self {
        Self { field: field.into(), found: shown(&found.to_string()), allowed: allowed.into() }
    }

    pub(crate) fn in_file(self, path: &Path) -> FileError {
        FileError::new(path, self)
    }
}

/// Text from a file, fit for one line of a terminal: control characters escaped, and not too long.
pub(crate) fn shown(text: &str) -> String {
    clipped(text, char::escape_debug)
}

/// The same of a text that has quotes of its own, such as a value in a scene file: they stay as they are.
pub(crate) fn shown_with_quotes(text: &str) -> String {
    // An escape is a backslash before the character.
    clipped(text, |c| c.escape_debug().skip(usize::from(matches!(c, '"' | '\'' | '\\'))))
}

/// Text that a file may have had a say in, with its control characters escaped: line feeds are among them.
pub(crate) fn on_one_line(text: &str) -> Cow<'_, str> {
    if !text.contains(char::is_control) {
        return text.into();
    }
    text.chars().flat_map(|c| if c.is_control() { c.escape_default().collect() } else { vec![c] }).collect()
}

/// Name of a file or a folder, which another file may have named, on one line.
pub(crate) fn shown_path(path: &Path) -> String {
    on_one_line(&path.display().to_string()).into_owned()
}

fn clipped<E: Iterator<Item = char>>(text: &str, escape: impl Fn(char) -> E) -> String {
    const MAX_CHARS: usize = 60;
    let mut s: String = text.chars().take(MAX_CHARS).flat_map(escape).collect();
    if text.chars().nth(MAX_CHARS).is_some() {
        s.push('…');
    }
    if s.is_empty() {
        s.push_str("nothing");
    }
    s
}

/// The reason why a file was not written. Nothing is left behind then.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The place cannot be written to.
    #[error("{}: cannot be written: {source}", shown_path(path))]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The format cannot hold what was to be written.
    #[error("{}: {message}", shown_path(path))]
    Encode {
        /// The file.
        path: PathBuf,
        /// The encoder's message.
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
        // Names of fields and of files are a file's words, too.
        let data = PathBuf::from("a\r\u{1b}[2J.raw");
        let texts = [
            FieldError::new("di\nmension", 1, "must be\tthere").in_file(Path::new("x\n.nrrd")).to_string(),
            FileErrorKind::DataFile { data, source: io::ErrorKind::NotFound.into() }.to_string(),
            WriteError::Encode { path: "a\nb".into(), message: "no".to_owned() }.to_string(),
        ];
        assert_eq!(texts[0], r"x\n.nrrd: di\nmension: found 1; must be\tthere");
        assert!(texts[1].starts_with(r"data file a\r\u{1b}[2J.raw: "), "{}", texts[1]);
        assert_eq!(texts[2], r"a\nb: no");
    }
}
