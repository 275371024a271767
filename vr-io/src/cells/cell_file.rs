//! The seam between files of cells and the mesh that is made of them.

use std::path::PathBuf;

use glam::DVec3;

use crate::error::FileError;
use crate::scalar::{Endian, ScalarType};
use crate::vtk::Candidate;

use super::cell_list::CellList;

/// A file of cells whose description has been read; its numbers are read when asked for.
pub(super) trait CellFile {
    /// Facts about the file as a whole.
    fn facts(&self) -> Facts;
    /// Arrays of values that may be chosen.
    fn arrays(&self) -> &[Candidate];
    /// Number of pieces, each with vertices of its own.
    fn pieces(&self) -> usize;
    /// Vertices and cells of a piece.
    fn piece(&self, piece: usize) -> Result<Piece, FileError>;
    /// Numbers of an array in a piece: of each vertex or cell, all components.
    fn numbers(&self, piece: usize, array: usize) -> Result<Vec<f64>, FileError>;
}

/// Facts about a file of cells.
pub(super) struct Facts {
    pub format: &'static str,
    pub encoding: &'static str,
    /// Type of the positions.
    pub scalar: ScalarType,
    pub endian: Endian,
    /// Number of time steps.
    pub frames: usize,
    /// Every file that is read.
    pub files: Vec<PathBuf>,
}

/// Vertices and cells that belong together.
pub(super) struct Piece {
    pub positions: Vec<DVec3>,
    pub cells: CellList,
    pub hidden: Hidden,
}

/// Vertices and cells that the file wants left out; empty lists where there is none.
#[derive(Debug, Default)]
pub(super) struct Hidden {
    pub vertices: Vec<bool>,
    pub cells: Vec<bool>,
}

impl Hidden {
    /// True if a cell is left out, for itself or for one of its vertices.
    pub fn hides(&self, cell: usize, vertices: &[u32]) -> bool {
        self.cells.get(cell).is_some_and(|&hidden| hidden)
            || !self.vertices.is_empty()
                && vertices.iter().any(|&v| self.vertices.get(v as usize).is_some_and(|&hidden| hidden))
    }
}
