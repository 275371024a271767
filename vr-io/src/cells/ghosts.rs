//! Marks of VTK on vertices and cells that are not to be shown.

use super::cell_file::Hidden;

/// Name of the array of marks.
pub(super) const GHOST_TYPE: &str = "vtkGhostType";
/// Name of the array of older files: how far a cell lies outside of its piece.
pub(super) const GHOST_LEVELS: &str = "vtkGhostLevels";

/// A cell that another piece has, too (`vtkDataSetAttributes::DUPLICATECELL`).
const DUPLICATE_CELL: u8 = 1;
/// A cell that finer ones cover.
const REFINED_CELL: u8 = 8;
/// A cell that is blanked.
const HIDDEN_CELL: u8 = 32;
/// A vertex that is blanked: the cells at it are not shown.
const HIDDEN_POINT: u8 = 2;

/// True for an array that is no choice: it marks what is hidden.
pub(super) fn is_ghost_array(name: &str) -> bool {
    matches!(name, GHOST_TYPE | GHOST_LEVELS)
}

impl Hidden {
    /// Takes in the marks of an array.
    pub fn mark(&mut self, name: &str, of_cells: bool, marks: &[f64]) {
        let bits = match (name, of_cells) {
            (GHOST_TYPE, true) => DUPLICATE_CELL | REFINED_CELL | HIDDEN_CELL,
            (GHOST_TYPE, false) => HIDDEN_POINT,
            (GHOST_LEVELS, true) => u8::MAX,
            _ => return,
        };
        let list = if of_cells { &mut self.cells } else { &mut self.vertices };
        if list.len() < marks.len() {
            list.resize(marks.len(), false);
        }
        for (hidden, &mark) in list.iter_mut().zip(marks) {
            *hidden |= mark as u8 & bits != 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_bits() {
        let mut hidden = Hidden::default();
        hidden.mark(GHOST_TYPE, true, &[0.0, 1.0, 2.0, 33.0, 16.0]);
        assert_eq!(hidden.cells, [false, true, false, true, false]);
        hidden.mark(GHOST_TYPE, false, &[0.0, 1.0, 2.0]);
        assert_eq!(hidden.vertices, [false, false, true]);
        assert!(
            hidden.hides(1, &[]) && hidden.hides(0, &[0, 2]) && !hidden.hides(0, &[0, 1]) && !hidden.hides(9, &[9])
        );
    }
}
