//! The seam between files of adaptive meshes and the mesh that is made of them.

use glam::DVec3;

use crate::error::FileError;
use crate::facts::Facts;
use crate::vtk::Candidate;

/// A file of an adaptive mesh whose description has been read; its numbers are read when asked for.
pub(super) trait AmrFile {
    /// Facts about the file as a whole.
    fn facts(&self) -> Facts;
    /// Levels, and places of the blocks.
    fn hierarchy(&self) -> &Hierarchy;
    /// Arrays of values that may be chosen.
    fn arrays(&self) -> &[Candidate];
    /// Numbers of an array in a block, all components: of each cell or point, x running fastest.
    ///
    /// # Errors
    /// An array that the block lacks, or one that is not whole.
    fn numbers(&self, block: usize, array: usize) -> Result<Vec<f64>, FileError>;
    /// Notes on what was left out or assumed.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Lattices of the levels, and the boxes of the blocks on them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hierarchy {
    /// World position of the corner of cell 0 of every level.
    pub origin: DVec3,
    /// Edges of a cell of level 0.
    pub spacing: DVec3,
    /// Cells of the next level along the edges of a cell of each level.
    pub ratios: Vec<[u32; 3]>,
    pub boxes: Vec<BlockBox>,
    /// Source of the placement, as [`crate::FileInfo::placed_by`] has it.
    pub placed_by: &'static str,
}

/// The cells of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BlockBox {
    pub level: usize,
    /// Index of the first cell on the lattice of the level.
    pub first: [i64; 3],
    /// Cells along each axis.
    pub cells: [usize; 3],
}

impl BlockBox {
    /// The box from a first to a last cell, both in it; `None` for none that can be counted.
    pub fn between(level: usize, first: [i64; 3], last: [i64; 3]) -> Option<Self> {
        let mut cells = [0; 3];
        for a in 0..3 {
            let count = last[a].checked_sub(first[a])?.checked_add(1)?;
            cells[a] = usize::try_from(count).ok().filter(|&n| n > 0)?;
        }
        Some(Self { level, first, cells })
    }

    /// Values along each axis: of cells, or of the points at their corners.
    pub fn dims(&self, of_cells: bool) -> [usize; 3] {
        self.cells.map(|n| if of_cells { n } else { n.saturating_add(1) })
    }
}

/// Product of sizes and components; `None` where it cannot be counted.
pub(super) fn count_of(dims: [usize; 3], components: usize) -> Option<usize> {
    dims.iter().try_fold(components, |n, &size| n.checked_mul(size))
}
