//! An HDF5 file, with what it may allocate held against its length.

use std::path::Path;

use hdf5_reader::{Datatype, Hdf5File, OpenOptions};

use crate::error::FileErrorKind;
use crate::scalar::ScalarType;

/// Largest number of bytes that Deflate, the densest of the usual filters, packs into one.
const DENSEST: u64 = 1032;

/// Opens a file.
pub(crate) fn open(path: &Path) -> Result<Hdf5File, FileErrorKind> {
    let max_bytes = std::fs::metadata(path)?.len().saturating_mul(DENSEST);
    let max_bytes = usize::try_from(max_bytes).unwrap_or(usize::MAX);
    let options = OpenOptions::default()
        .with_max_read_bytes(max_bytes)
        .with_max_chunk_bytes(max_bytes.min(hdf5_reader::DEFAULT_MAX_CHUNK_BYTES));
    Hdf5File::open_with_options(path, options).map_err(|e| damaged("HDF5", e))
}

/// The type of numbers; `None` for anything else.
pub(crate) fn scalar_of(datatype: &Datatype) -> Option<ScalarType> {
    Some(match datatype {
        Datatype::FloatingPoint { size: 4, .. } => ScalarType::F32,
        Datatype::FloatingPoint { size: 8, .. } => ScalarType::F64,
        Datatype::FixedPoint { size, signed, .. } => match (size, signed) {
            (1, false) => ScalarType::U8,
            (1, true) => ScalarType::I8,
            (2, false) => ScalarType::U16,
            (2, true) => ScalarType::I16,
            (4, false) => ScalarType::U32,
            (4, true) => ScalarType::I32,
            (8, false) => ScalarType::U64,
            (8, true) => ScalarType::I64,
            _ => return None,
        },
        _ => return None,
    })
}

/// The fault of a place in a file.
pub(crate) fn damaged(place: &str, error: hdf5_reader::error::Error) -> FileErrorKind {
    FileErrorKind::field(place, error, "must be whole, as HDF5 describes it")
}
