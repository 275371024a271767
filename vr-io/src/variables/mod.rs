//! Volumes among the named arrays of a file, with attributes and coordinates: what NetCDF and HDF5 have in common.
//!
//! Attributes are those of the CF conventions (1.11, <https://cfconventions.org>): `scale_factor` and `add_offset` are the calibration,
//! `_FillValue`, `missing_value` and `valid_range` tell which voxels are missing, and variables named as a dimension are coordinates along it.

mod axes;
mod choice;
mod packing;
mod place;

use std::path::Path;

use crate::error::{FileError, FileErrorKind};
use crate::layout::{Axis, Layout};
use crate::notes::Notes;
use crate::read::{Description, ReadOptions};
use crate::scalar::{Endian, ScalarType};
use crate::source::Decoded;
use crate::world::Space;

use packing::Packing;

/// An array under a name.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Variable {
    /// Name, or path from the root.
    pub name: String,
    /// Sizes of the axes, the slowest first.
    pub shape: Vec<usize>,
    /// Names of the axes, where the file has any.
    pub dimensions: Vec<Option<String>>,
    pub scalar: ScalarType,
}

/// Value of an attribute.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Attribute {
    Text(String),
    Numbers(Vec<f64>),
}

/// A file of variables.
pub(crate) trait Store {
    /// Everything that is an array of numbers.
    fn variables(&self) -> &[Variable];
    /// An attribute of a variable.
    fn attribute(&self, variable: &str, name: &str) -> Option<Attribute>;
    /// Numbers of a part of a variable: from an index on, that many along each axis, in C order.
    fn read(&self, variable: &Variable, start: &[usize], count: &[usize]) -> Result<Vec<u8>, FileErrorKind>;
    /// Byte order of what is read.
    fn endian(&self) -> Endian;
    /// Number that the format puts where nothing was written, if it is told by the type alone.
    fn default_fill(&self, scalar: ScalarType) -> Option<f64>;
}

/// Number that NetCDF's library puts where no float was written. Of integers, files hold theirs as a number, too.
pub(crate) fn netcdf_fill(scalar: ScalarType) -> Option<f64> {
    const FILL: f64 = 9.969_209_968_386_869e36;
    matches!(scalar, ScalarType::F32 | ScalarType::F64).then_some(FILL)
}

/// Text of an attribute.
fn text(store: &dyn Store, variable: &str, name: &str) -> Option<String> {
    match store.attribute(variable, name)? {
        Attribute::Text(text) => Some(text.trim_matches(['\0', ' ']).to_owned()),
        Attribute::Numbers(_) => None,
    }
}

/// Numbers of an attribute; none where it is not there, or a text.
fn numbers(store: &dyn Store, variable: &str, name: &str) -> Vec<f64> {
    match store.attribute(variable, name) {
        Some(Attribute::Numbers(numbers)) => numbers,
        _ => Vec::new(),
    }
}

/// Everything that a file says about the variable that is chosen, or the one that is most likely meant.
pub(crate) fn describe(
    path: &Path,
    format: &'static str,
    store: impl Store + 'static,
    options: &ReadOptions,
) -> Result<Description, FileError> {
    let in_file = |kind: FileErrorKind| FileError::new(path, kind);
    let mut notes = Notes::default();
    let variable =
        choice::choose(store.variables(), options.array.as_deref(), &mut notes).map_err(|e| e.in_file(path))?.clone();
    let axes = axes::axes(&store, &variable, &mut notes).map_err(in_file)?;
    // The last axis runs fastest.
    let fastest_first: Vec<Axis> =
        variable.shape.iter().zip(&axes).rev().map(|(&size, axis)| Axis { size, role: axis.role }).collect();
    let layout = Layout::new(path, &fastest_first, options)?;
    let placed = place::place(&store, &variable, &axes, &mut notes).map_err(in_file)?;
    let packing = Packing::read(&store, &variable).map_err(in_file)?;

    // One index along the axes of frames and components, all of them along those of space.
    let start = layout.first_index(&variable.shape);
    let count: Vec<usize> = variable.shape.iter().zip(&axes).map(|(&n, axis)| axis.count(n)).collect();
    let (scalar, endian) = (packing.decoded(), if packing.masks() { Endian::NATIVE } else { store.endian() });
    let (file, calibration) = (path.to_path_buf(), packing.calibration);
    let decode = Box::new(move |_: &mut Vec<String>| {
        let bytes = store.read(&variable, &start, &count).map_err(|kind| FileError::new(&file, kind))?;
        Ok(packing.apply(bytes, store.endian()))
    });
    let decoded = Decoded { decode, scalar, endian, encoding: format, files: vec![path.into()] };
    Ok(Description {
        format,
        header: path.into(),
        calibration,
        source: decoded.into(),
        layout: layout.dense(),
        placement: placed.placement,
        placed_by: placed.by,
        space: Space::Own,
        units: placed.unit,
        scan: None,
        notes,
    })
}
