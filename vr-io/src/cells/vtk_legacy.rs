//! Cells of legacy VTK files: of UNSTRUCTURED_GRID and STRUCTURED_GRID.

use std::path::{Path, PathBuf};

use crate::error::{FileError, FileErrorKind};
use crate::scalar::Endian;
use crate::vtk::{Array, Candidate, CellLines, Legacy};

use super::cell_file::{CellFile, Facts, Hidden, Piece};
use super::cell_list::{CellList, Listed};
use super::ghosts::is_ghost_array;
use super::positions;

/// The kinds of data with cells that have positions of their own.
pub(super) const DATA_SETS: [&str; 2] = ["UNSTRUCTURED_GRID", "STRUCTURED_GRID"];

/// A file of which the lines have been read, not the numbers.
pub(super) struct LegacyCells {
    path: PathBuf,
    points: Array,
    cells: Form,
    candidates: Vec<Candidate>,
    arrays: Vec<Array>,
    ghosts: Vec<(bool, Array)>,
}

enum Form {
    Listed(CellLines),
    Lattice([usize; 3]),
}

impl LegacyCells {
    /// Reads all lines.
    pub fn open(path: &Path) -> Result<Self, FileErrorKind> {
        let Legacy { points, attributes, cell_lines, lattice, .. } = Legacy::read(path, &DATA_SETS)?;
        let points =
            points.ok_or_else(|| FileErrorKind::field("POINTS", "nothing", "the file must have a POINTS section"))?;
        let cells = match lattice.dimensions {
            Some(dims) => Form::Lattice(dims),
            None => Form::Listed(cell_lines),
        };
        let (mut candidates, mut arrays, mut ghosts) = (Vec::new(), Vec::new(), Vec::new());
        for attribute in attributes {
            let (array, of_cells) = (attribute.array, attribute.of_cells);
            if is_ghost_array(&array.name) {
                ghosts.push((of_cells, array));
                continue;
            }
            let (name, components, is_scalars) = (array.name.clone(), attribute.components, attribute.is_scalars);
            // An array of a field may have any length.
            if components > 0 {
                candidates.push(Candidate { name, components, of_cells, is_scalars });
                arrays.push(array);
            }
        }
        Ok(Self { path: path.into(), points, cells, candidates, arrays, ghosts })
    }

    fn read_piece(&self) -> Result<Piece, FileErrorKind> {
        let positions = positions(&self.points.numbers(&self.path)?);
        let cells = match &self.cells {
            Form::Lattice(dims) => super::lattice("DIMENSIONS", *dims, positions.len())?,
            Form::Listed(lines) => CellList::Listed(self.listed(lines, positions.len())?),
        };
        let mut hidden = Hidden::default();
        for (of_cells, array) in &self.ghosts {
            hidden.mark(&array.name, *of_cells, &array.numbers(&self.path)?);
        }
        Ok(Piece { positions, cells, hidden })
    }

    fn listed(&self, lines: &CellLines, vertices: usize) -> Result<Listed, FileErrorKind> {
        let (Some(cells), Some(types)) = (&lines.cells, &lines.types) else {
            // Points without cells.
            return Ok(Listed::default());
        };
        let (numbers, types) = (cells.numbers(&self.path)?, types.numbers(&self.path)?);
        let offsets = lines.offsets.as_ref().map(|offsets| offsets.numbers(&self.path)).transpose()?;
        if types.len() != lines.count {
            let allowed = format!("there are {} cells, each with a type", lines.count);
            return Err(FileErrorKind::field("CELL_TYPES", types.len(), allowed));
        }
        let mut listed = Listed::default();
        let mut at = 0;
        let whole = |number: f64| (number >= 0.0 && number.fract() == 0.0).then_some(number as usize);
        for (cell, &vtk) in types.iter().enumerate() {
            // Up to version 4, each cell begins with the number of its vertices; later, offsets tell where each ends.
            let part = match &offsets {
                Some(offsets) => [cell, cell + 1].map(|i| offsets.get(i).copied().and_then(whole)),
                None => {
                    let length = numbers.get(at).copied().and_then(whole);
                    let end = length.and_then(|n| n.checked_add(at + 1));
                    let part = [Some(at + 1), end];
                    at = end.unwrap_or(at);
                    part
                }
            };
            let [Some(from), Some(to)] = part else { return Err(broken(cell, "no length")) };
            let vertices_of =
                numbers.get(from..to).ok_or_else(|| broken(cell, "vertices beyond the end of the list"))?;
            listed.push(vtk, vertices_of, vertices)?;
        }
        Ok(listed)
    }
}

fn broken(cell: usize, found: &str) -> FileErrorKind {
    FileErrorKind::field(
        format!("CELLS, cell {cell}"),
        found,
        "there must be as many cells as types, each with its vertices",
    )
}

impl CellFile for LegacyCells {
    fn facts(&self) -> Facts {
        Facts {
            format: "VTK (legacy)",
            encoding: self.points.encoding(),
            scalar: self.points.scalar,
            endian: Endian::Big,
            frames: 1,
            files: vec![self.path.clone()],
        }
    }

    fn arrays(&self) -> &[Candidate] {
        &self.candidates
    }

    fn piece(&self, _: usize) -> Result<Piece, FileError> {
        self.read_piece().map_err(|kind| FileError::new(&self.path, kind))
    }

    fn numbers(&self, _: usize, array: usize) -> Result<Vec<f64>, FileError> {
        self.arrays[array].numbers(&self.path).map_err(|kind| FileError::new(&self.path, kind))
    }
}
