//! Frames out, in the format that the file's name asks for.

use std::path::Path;

use vr_core::Frame;

use crate::error::WriteError;
use crate::exr::write_exr;
use crate::png::{PngOptions, write_png};

/// Writes a frame as what the name says: `.png` (with these options) or `.exr` (untouched floats, options without effect).
///
/// # Errors
/// A [`WriteError`] naming the file, also for any other name; no part of it is left behind then.
pub fn write(path: impl AsRef<Path>, frame: &Frame, options: &PngOptions) -> Result<(), WriteError> {
    let path = path.as_ref();
    match path.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
        Some("png") => write_png(path, frame, options),
        Some("exr") => write_exr(path, frame),
        other => Err(WriteError::Encode {
            path: path.into(),
            message: format!("extension {}: must be png or exr", other.unwrap_or("missing")),
        }),
    }
}
