//! Points of columns that a reader of other data has found.

use std::path::Path;

use glam::DVec3;
use vr_core::PointSet;

use crate::error::{FileError, FileErrorKind};

use super::assemble::assemble;
use super::roles::Roles;
use super::{Column, Numbering, PointOptions, Table};

/// Positions, and columns that are loaded when they have a role.
pub(crate) struct Columns<'a> {
    pub positions: Vec<DVec3>,
    pub names: &'a [String],
    /// Loads the numbers of a column, one for each position.
    pub load: &'a dyn Fn(usize) -> Result<Vec<f64>, FileError>,
}

/// Makes points of columns. Tells in the notes what was assumed.
///
/// # Errors
/// Faults of the columns, of the choices among them, or of points that make no sense.
pub(crate) fn points_of_columns(
    path: &Path,
    columns: Columns<'_>,
    options: &PointOptions,
    notes: &mut Vec<String>,
) -> Result<PointSet, FileError> {
    let in_file = |kind: FileErrorKind| FileError::new(path, kind);
    options.validate().map_err(|e| FileErrorKind::field(e.field, e.found, e.allowed)).map_err(in_file)?;
    let Columns { positions, names, load } = columns;
    let roles = Roles::choose(names, options).map_err(|e| in_file(e.into()))?;
    let columns = roles.try_map(|i| Ok::<_, FileError>(Column { name: names[i].clone(), numbers: load(i)? }))?;
    assemble(Table { positions, columns, numbering: Numbering::FromZero }, options, notes).map_err(in_file)
}
