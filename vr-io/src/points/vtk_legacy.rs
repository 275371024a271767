//! Points of legacy VTK files: of POLYDATA and UNSTRUCTURED_GRID.

use std::path::Path;

use crate::error::FileErrorKind;
use crate::scalar::Endian;
use crate::vtk::{Array, Legacy};

use super::roles::Roles;
use super::{Column, Found, Numbering, PointOptions, Table, numbers};

/// The kinds of data that have points of their own.
pub(super) const DATA_SETS: [&str; 2] = ["POLYDATA", "UNSTRUCTURED_GRID"];

pub(super) fn read(path: &Path, options: &PointOptions) -> Result<Found, FileErrorKind> {
    let Legacy { points, attributes, cells, .. } = Legacy::read(path, &DATA_SETS)?;
    let points =
        points.ok_or_else(|| FileErrorKind::field("POINTS", "nothing", "the file must have a POINTS section"))?;

    let mut notes = Vec::new();
    if cells > 0 {
        notes.push(format!("{cells} cells are left out: their points are taken"));
    }
    let cell_arrays = attributes.iter().filter(|a| a.of_cells).count();
    if cell_arrays > 0 {
        notes.push(format!("{cell_arrays} arrays of cell data are left out"));
    }
    let of_points = attributes.into_iter().filter(|a| !a.of_cells).map(|a| a.array);
    let arrays: Vec<Array> = of_points.filter(|a| a.numbers == points.numbers / 3).collect();
    let names: Vec<String> = arrays.iter().map(|a| a.name.clone()).collect();
    let column = |i: usize| {
        let array: &Array = &arrays[i];
        Ok::<_, FileErrorKind>(Column { name: array.name.clone(), numbers: array.numbers(path)? })
    };
    let columns = Roles::choose(&names, options)?.try_map(column)?;
    let positions = numbers::positions(&points.numbers(path)?);
    Ok(Found {
        table: Table { positions, columns, numbering: Numbering::FromZero },
        format: "VTK (legacy)",
        encoding: points.encoding(),
        scalar: points.scalar,
        endian: Endian::Big,
        names,
        notes,
    })
}
