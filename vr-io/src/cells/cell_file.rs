//! The seam between files of cells and the mesh that is made of them.

use glam::DVec3;

use crate::error::FileError;
pub(super) use crate::facts::Facts;
use crate::vtk::Candidate;

use super::cell_list::CellList;

/// A file of cells whose description has been read; its numbers are read when asked for.
pub(super) trait CellFile {
    /// Facts about the file as a whole.
    fn facts(&self) -> Facts;
    /// Arrays of values that may be chosen.
    fn arrays(&self) -> &[Candidate];
    /// Number of pieces, each with vertices of its own.
    fn pieces(&self) -> usize {
        1
    }
    /// Vertices and cells of a piece.
    fn piece(&self, piece: usize) -> Result<Piece, FileError>;
    /// Numbers of an array in a piece: of each vertex or cell, all components.
    fn numbers(&self, piece: usize, array: usize) -> Result<Vec<f64>, FileError>;
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
