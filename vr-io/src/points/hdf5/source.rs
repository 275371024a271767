//! An HDF5 file through `hdf5-reader`, with what it may allocate held against the length of the file.

use std::path::Path;

use hdf5_reader::{Datatype, Hdf5File, OpenOptions};

use crate::error::FileErrorKind;
use crate::points::numbers;
use crate::scalar::{Endian, ScalarType};

/// A file.
pub(super) struct Source {
    file: Hdf5File,
}

/// Largest number of bytes that Deflate, the densest of the usual filters, packs into one.
const DENSEST: u64 = 1032;

impl Source {
    pub fn open(path: &Path) -> Result<Self, FileErrorKind> {
        let max_bytes = std::fs::metadata(path)?.len().saturating_mul(DENSEST);
        let max_bytes = usize::try_from(max_bytes).unwrap_or(usize::MAX);
        let options = OpenOptions::default()
            .with_max_read_bytes(max_bytes)
            .with_max_chunk_bytes(max_bytes.min(hdf5_reader::DEFAULT_MAX_CHUNK_BYTES));
        let file = Hdf5File::open_with_options(path, options).map_err(|e| damaged("HDF5", e))?;
        Ok(Self { file })
    }

    /// Names of the groups within a group.
    pub fn groups(&self, group: &str) -> Result<Vec<String>, FileErrorKind> {
        let group = self.file.group(group).map_err(|e| damaged(group, e))?;
        Ok(group.member_names().map_err(|e| damaged("groups", e))?.0)
    }

    /// Names of the datasets of a group that are columns of `count` numbers.
    pub fn columns(&self, group: &str, count: u64) -> Result<Vec<String>, FileErrorKind> {
        let found = self.file.group(group).map_err(|e| damaged(group, e))?;
        let (_, names) = found.member_names().map_err(|e| damaged(group, e))?;
        let is_column = |name: &String| {
            let dataset = found.dataset(name);
            dataset.is_ok_and(|d| matches!(d.shape(), [n] | [n, 1] if *n == count) && scalar_of(d.dtype()).is_some())
        };
        Ok(names.into_iter().filter(is_column).collect())
    }

    /// Shape, type and numbers of a dataset.
    pub fn numbers(&self, path: &str) -> Result<(Vec<u64>, ScalarType, Vec<f64>), FileErrorKind> {
        let dataset = self.file.dataset(path).map_err(|e| damaged(path, e))?;
        let scalar = scalar_of(dataset.dtype());
        let scalar =
            scalar.ok_or_else(|| FileErrorKind::field(path, format!("{:?}", dataset.dtype()), "must be numbers"))?;
        let bytes = dataset.read_native_bytes().map_err(|e| damaged(path, e))?;
        Ok((dataset.shape().to_vec(), scalar, numbers::numbers(&bytes, scalar, Endian::NATIVE)))
    }

    /// The numbers of an attribute of a group, or of a dataset in it; `None` where there is neither.
    pub fn list(&self, group: &str, name: &str) -> Result<Option<Vec<f64>>, FileErrorKind> {
        let Ok(found) = self.file.group(group) else { return Ok(None) };
        if let Ok(attribute) = found.attribute(name) {
            let numbers = attribute.read_1d::<f64>().or_else(|_| attribute.read_as_f64().map(|x| vec![x]));
            return numbers.map(Some).map_err(|e| damaged(&format!("{group}, {name}"), e));
        }
        if found.dataset(name).is_err() {
            return Ok(None);
        }
        self.numbers(&format!("{group}/{name}")).map(|(_, _, numbers)| Some(numbers))
    }
}

fn scalar_of(datatype: &Datatype) -> Option<ScalarType> {
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

fn damaged(place: &str, error: hdf5_reader::error::Error) -> FileErrorKind {
    FileErrorKind::field(place, error, "must be whole, as HDF5 describes it")
}
