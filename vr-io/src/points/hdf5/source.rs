//! The groups and columns of an HDF5 file.

use std::path::Path;

use hdf5_reader::Hdf5File;

use crate::error::FileErrorKind;
use crate::hdf5::{damaged, open, scalar_of};
use crate::points::numbers;
use crate::scalar::{Endian, ScalarType};

/// A file.
pub(super) struct Source {
    file: Hdf5File,
}

impl Source {
    pub fn open(path: &Path) -> Result<Self, FileErrorKind> {
        let file = open(path)?;
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
