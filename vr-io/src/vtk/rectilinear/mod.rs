//! Rectilinear grids of VTK: RECTILINEAR_GRID of legacy files (.vtk), RectilinearGrid (.vtr), and lists of such files (.pvtr).
//!
//! Values belong to the points where planes meet or to the cells between them (`vtkRectilinearGrid`). Where all planes are at even distances, the
//! grid is a uniform one.

mod axes;

use std::path::Path;

use vr_core::rectilinear::{Centering, RectilinearGrid};

use crate::chosen::Chosen;
use crate::error::{FieldError, FileError, FileErrorKind};
use crate::facts::Facts;
use crate::narrow::Narrowed;
use crate::read::{Loaded, ReadOptions};
use crate::scalar::{Endian, ScalarType};

use super::blanking::{GHOST_TYPE, Marks};
use super::content::{Content, content};
use super::image::{Candidate, Extent, extent_of, lattice_arrays};
use super::lattice_file::{LatticeFile, RECTILINEAR};
use super::legacy::{Array, Legacy};
use super::piece_arrays::PieceArrays;

/// The kind of data of legacy files.
const DATA_SET: &str = "RECTILINEAR_GRID";

/// The forms of a rectilinear grid's file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum RectilinearFormat {
    Xml,
    Legacy,
}

/// The form that the beginning of a file shows.
pub(crate) fn by_content(head: &[u8]) -> Option<RectilinearFormat> {
    match content(head)? {
        Content::Xml(kind) => RECTILINEAR.contains(&kind.as_str()).then_some(RectilinearFormat::Xml),
        Content::Legacy(kind) => (kind == DATA_SET).then_some(RectilinearFormat::Legacy),
    }
}

/// Reads a grid.
///
/// # Errors
/// A choice that the file does not have, and anything in the file that is not as it must be.
pub(crate) fn read(format: RectilinearFormat, path: &Path, options: &ReadOptions) -> Result<Loaded, FileError> {
    let file = match format {
        RectilinearFormat::Xml => RectilinearFile::xml(path)?,
        RectilinearFormat::Legacy => RectilinearFile::legacy(path).map_err(|kind| FileError::new(path, kind))?,
    };
    file.load(path, options)
}

/// A file of which the planes have been read, not the values.
struct RectilinearFile {
    facts: Facts,
    extent: Extent,
    axes: [Vec<f64>; 3],
    arrays: Vec<(Candidate, LatticeArray)>,
    notes: Vec<String>,
}

/// Values of a lattice in one of the two forms.
enum LatticeArray {
    Pieces(PieceArrays),
    Legacy(Array),
}

impl LatticeArray {
    fn numbers(&self, path: &Path, count: usize) -> Result<Vec<f64>, FileError> {
        match self {
            Self::Legacy(array) => array.numbers(path).map_err(|kind| FileError::new(path, kind)),
            Self::Pieces(pieces) => pieces.numbers(path, count),
        }
    }

    /// Encoding, type and byte order.
    fn form(&self) -> (&'static str, ScalarType, Endian) {
        match self {
            Self::Legacy(array) => (array.encoding(), array.scalar, Endian::Big),
            Self::Pieces(pieces) => (pieces.encoding(), pieces.scalar().unwrap_or(ScalarType::F32), pieces.endian()),
        }
    }
}

impl RectilinearFile {
    fn xml(path: &Path) -> Result<Self, FileError> {
        let in_file = |kind| FileError::new(path, kind);
        let file = LatticeFile::open(path, RECTILINEAR)?;
        let extent = file.hull();
        let axes = axes::joined(&extent, &file.pieces).map_err(in_file)?;
        let format = if file.is_list { "VTK PRectilinearGrid" } else { "VTK RectilinearGrid" };
        let of_array = |(candidate, array)| (candidate, LatticeArray::Pieces(array));
        let arrays = PieceArrays::of_file(&file).into_iter().map(of_array).collect();
        let notes = file.notes().map_err(in_file)?;
        let facts = Facts::of_form(format, file.files);
        Ok(Self { facts, extent, axes, arrays, notes })
    }

    fn legacy(path: &Path) -> Result<Self, FileErrorKind> {
        let Legacy { mut lattice, attributes, point_count, cell_count, .. } = Legacy::read(path, &[DATA_SET])?;
        let extent = extent_of(&lattice)?;
        let mut axes = [Vec::new(), Vec::new(), Vec::new()];
        for (axis, all) in axes.iter_mut().enumerate() {
            let name = ["X_COORDINATES", "Y_COORDINATES", "Z_COORDINATES"][axis];
            let array = lattice.coordinates[axis].take();
            let array =
                array.ok_or_else(|| FileErrorKind::field(name, "nothing", "each axis must have its coordinates"))?;
            let planes = extent.dims(false)[axis];
            if array.numbers != planes {
                return Err(FileErrorKind::field(name, array.numbers, format!("DIMENSIONS make {planes} of them")));
            }
            *all = axes::evened(array.numbers(path)?, axes::precision_of(array.scalar));
        }
        let arrays = lattice_arrays(&extent, [point_count, cell_count], attributes)?;
        let arrays = arrays.into_iter().map(|(candidate, array)| (candidate, LatticeArray::Legacy(array))).collect();
        let facts = Facts::of_form("VTK (legacy)", vec![path.into()]);
        Ok(Self { facts, extent, axes, arrays, notes: Vec::new() })
    }

    fn load(self, path: &Path, options: &ReadOptions) -> Result<Loaded, FileError> {
        let in_file = |e: FieldError| e.in_file(path);
        let Self { mut facts, extent, axes, arrays, mut notes } = self;
        facts.check_frame(options.frame).map_err(in_file)?;

        // Choose an array; marks are none.
        let (marks, arrays): (Vec<_>, Vec<_>) = arrays.into_iter().partition(|(c, _)| c.name == GHOST_TYPE);
        let (candidates, arrays): (Vec<Candidate>, Vec<LatticeArray>) = arrays.into_iter().unzip();
        let options = &options.with_point_value();
        let chosen = Chosen::of_arrays(&candidates, options, &mut notes).map_err(in_file)?;
        let array = &arrays[chosen.array.unwrap_or_default()];

        // Take one value of each point or cell.
        let dims = extent.dims(chosen.of_cells);
        let many = || in_file(FieldError::new("Extent", format!("{dims:?}"), "must have fewer points"));
        let count = dims.iter().try_fold(1usize, |n, &size| n.checked_mul(size)).ok_or_else(many)?;
        let numbers = count.checked_mul(chosen.components).ok_or_else(many)?;
        let mut values = chosen.values(array.numbers(path, numbers)?, count).map_err(in_file)?;
        (facts.encoding, facts.scalar, facts.endian) = array.form();
        let points = extent.dims(false);
        if points.iter().all(|&n| n > 1) {
            let kept = marks_of(&marks, &extent, path)?.blank(&mut values, points, chosen.of_cells);
            if kept > 0 {
                notes.push(format!("{kept} cells that are blanked are drawn: their corners belong to others, too"));
            }
        }
        let mut narrowed = Narrowed::default();
        let values = narrowed.take(&values);
        notes.extend(narrowed.notes());

        let centering = if chosen.of_cells { Centering::Cells } else { Centering::Points };
        let grid = RectilinearGrid::new(axes, values, centering).map_err(|e| FileError::new(path, e))?;
        let volume = grid.into_volume();
        if chosen.of_cells {
            notes.push("the numbers belong to cells: each is placed at the centre of its cell".to_owned());
        }
        if volume.grid().is_some() {
            notes.push("all planes are at even distances: a uniform grid is made".to_owned());
        }
        let columns = candidates.into_iter().map(|candidate| candidate.name).collect();
        Ok(Loaded { volume, info: facts.into_info("coordinates", chosen.components, columns), notes })
    }
}

fn marks_of(marks: &[(Candidate, LatticeArray)], extent: &Extent, path: &Path) -> Result<Marks, FileError> {
    let mut found = Marks::default();
    for (Candidate { of_cells, .. }, array) in marks.iter().filter(|(c, _)| c.components == 1) {
        found.take(*of_cells, extent, path, |count| array.numbers(path, count))?;
    }
    Ok(found)
}
