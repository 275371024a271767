//! The image of a block: its own cells, without copies of its neighbours'.

use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::error::{FieldError, FileError};
use crate::vtk::{IMAGE, LatticeFile, PieceArrays};

use super::super::amr_file::{BlockBox, count_of};
use super::super::lattices::index_of;
use super::GHOST_TYPE;

/// Marks of cells: copied from a neighbour, or blanked (`vtkDataSetAttributes`). Those under finer cells need no mark.
const DUPLICATE_CELL: u8 = 1;
const HIDDEN_CELL: u8 = 32;

/// The image of a block.
pub(super) struct Block {
    pub path: PathBuf,
    pub image: LatticeFile,
    /// Cells of the image, ghost cells among them.
    pub whole: [usize; 3],
    /// First of its cells that is its own.
    pub from: [usize; 3],
    /// Its own cells.
    pub cells: [usize; 3],
    /// Cells that are blanked; empty where none is.
    pub hidden: Vec<bool>,
}

impl Block {
    /// Reads everything but numbers; of marks these, too.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let image = LatticeFile::open(path, IMAGE)?;
        let wrong = |what: &str, found: String, allowed: &str| Err(FieldError::new(what, found, allowed).in_file(path));
        if image.is_list {
            return wrong("VTKFile type", IMAGE[1].to_owned(), "a block must be in one file");
        }
        if image.attributes.direction.is_some_and(|m| m != [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]) {
            return wrong("Direction", "a rotation".to_owned(), "the axes of a block must be those of the world");
        }
        let points = image.hull().dims(false);
        if points.contains(&1) {
            return wrong("Extent", format!("{points:?} points"), "a block must have cells in three dimensions");
        }
        let whole = image.hull().dims(true);
        let mut block = Self { path: path.into(), image, whole, from: [0; 3], cells: whole, hidden: Vec::new() };
        block.read_marks()?;
        Ok(block)
    }

    /// Finds the box of its own cells, and those that are blanked.
    fn read_marks(&mut self) -> Result<(), FileError> {
        let arrays = PieceArrays::of_file(&self.image);
        let found = arrays.iter().find(|(c, _)| c.of_cells && c.name == GHOST_TYPE && c.components == 1);
        let Some((_, array)) = found else { return Ok(()) };
        let many = || FieldError::new("Extent", "too many cells", "must be fewer").in_file(&self.path);
        let marks = array.numbers(&self.path, count_of(self.whole, 1).ok_or_else(many)?)?;
        let is = |mark: f64, bit: u8| mark as u8 & bit != 0;
        let [nx, ny, _] = self.whole;
        let (mut low, mut high) = (self.whole, [0; 3]);
        for i in (0..marks.len()).filter(|&i| !is(marks[i], DUPLICATE_CELL)) {
            let at = [i % nx, i / nx % ny, i / (nx * ny)];
            for a in 0..3 {
                (low[a], high[a]) = (low[a].min(at[a]), high[a].max(at[a] + 1));
            }
        }
        // Where all are copies, the block is kept: its values are right.
        if high != [0; 3] {
            self.from = low;
            self.cells = [0, 1, 2].map(|a| high[a] - low[a]);
        }
        if marks.iter().any(|&mark| is(mark, HIDDEN_CELL)) {
            self.hidden = marks.iter().map(|&mark| is(mark, HIDDEN_CELL)).collect();
        }
        Ok(())
    }

    /// Distances of the planes, if the image tells them.
    pub fn spacing(&self) -> Option<DVec3> {
        self.image.attributes.spacing.map(DVec3::from_array)
    }

    /// Corner of its first own cell.
    pub fn low(&self) -> DVec3 {
        let origin = self.image.attributes.origin.map_or(DVec3::ZERO, DVec3::from_array);
        let first = self.image.hull().first();
        let index = [0, 1, 2].map(|a| first[a] as f64 + self.from[a] as f64);
        origin + DVec3::from_array(index) * self.spacing().unwrap_or(DVec3::ONE)
    }

    /// Its own cells on the lattice of its level, where the list may have a box for it, with or without ghost cells.
    pub fn place(
        &self,
        level: usize,
        listed: Option<[i64; 6]>,
        origin: DVec3,
        spacing: DVec3,
    ) -> Result<BlockBox, FieldError> {
        let first = index_of(self.low(), origin, spacing, "Origin and Extent")?;
        let found = BlockBox { level, first, cells: self.cells };
        if let Some([a, b, c, d, e, f]) = listed {
            let listed = BlockBox::between(level, [a, c, e], [b, d, f]);
            let mut with_ghosts = BlockBox { cells: self.whole, ..found };
            for (first, &ghosts) in with_ghosts.first.iter_mut().zip(&self.from) {
                *first -= ghosts as i64;
            }
            if listed.is_none_or(|listed| listed != found && listed != with_ghosts) {
                let shown = format!("{:?} cells from {first:?} on", self.cells);
                let allowed = format!("the list has amr_box {a} {b} {c} {d} {e} {f} for it");
                return Err(FieldError::new("Origin and Extent", shown, allowed));
            }
        }
        Ok(found)
    }
}
