//! Location of the voxels: behind the header, or in files that it names.

use std::path::{Path, PathBuf};

use crate::encoding::Encoding;
use crate::error::{FieldError, FileError};
use crate::file_pattern::expand;
use crate::layout::Layout;
use crate::payload::{Payload, Segment, Skip};
use crate::scalar::{Endian, ScalarType};

use super::header::Header;

pub(super) fn payload(path: &Path, header: &Header, layout: &Layout, scalar: ScalarType) -> Result<Payload, FileError> {
    parse(path, header, layout, scalar).map_err(|e| e.in_file(path))
}

fn parse(path: &Path, header: &Header, layout: &Layout, scalar: ScalarType) -> Result<Payload, FieldError> {
    // Read the packing of the data.
    let name = header.required("encoding")?;
    let encoding = match name.to_lowercase().as_str() {
        "raw" => Encoding::Raw,
        "txt" | "text" | "ascii" => Encoding::Text,
        "hex" => Encoding::Hex,
        "gz" | "gzip" => Encoding::Gzip,
        "bz2" | "bzip2" => Encoding::Bzip2,
        _ => return Err(FieldError::new("encoding", name, "must be raw, ascii, hex, gzip or bzip2")),
    };
    let endian = match header.get("endian").map(str::to_lowercase).as_deref() {
        Some("little") => Endian::Little,
        Some("big") => Endian::Big,
        None if scalar.bytes() == 1 || encoding == Encoding::Text => Endian::NATIVE,
        other => {
            let allowed = format!("must be little or big for numbers of {} bytes", scalar.bytes());
            return Err(FieldError::new("endian", other.unwrap_or("nothing"), allowed));
        }
    };
    let lines: u64 = match header.get("line skip") {
        None => 0,
        Some(text) => text.parse().map_err(|_| FieldError::new("line skip", text, "must be 0 or more"))?,
    };
    let skip = match header.get("byte skip") {
        None => Skip::Bytes(0),
        Some(text) => match text.parse::<i64>() {
            Ok(-1) if encoding != Encoding::Text => Skip::AllButVoxels,
            Ok(n @ 0..) if n == 0 || encoding != Encoding::Text => Skip::Bytes(n as u64),
            _ => {
                let allowed = "must be 0 or more, or -1 for the last bytes of the data; 0 with ascii";
                return Err(FieldError::new("byte skip", text, allowed));
            }
        },
    };

    // List the data files.
    let folder = path.parent().unwrap_or(Path::new(""));
    let segment = |path: PathBuf, start: u64| Segment { path, start, lines, skip };
    let segments = match header.get("data file") {
        None => vec![segment(path.into(), header.length)],
        Some(list) if list.starts_with("LIST") => {
            header.listed_files().iter().map(|name| segment(folder.join(name), 0)).collect()
        }
        Some(pattern) if pattern.contains('%') => {
            let names = expand("data file", pattern, layout.total)?;
            names.iter().map(|name| segment(folder.join(name), 0)).collect()
        }
        Some(name) => vec![segment(folder.join(name), 0)],
    };
    Ok(Payload {
        segments,
        encoding,
        scalar,
        endian,
        // Else a header that points into another file at the wrong place would go unnoticed.
        excess_is_error: true,
        hint: " (are sizes, type and byte skip right?)",
    })
}
