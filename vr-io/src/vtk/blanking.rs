//! Values that VTK's marks want left out become NaN.

use std::ops::Range;
use std::path::Path;

use crate::error::{FieldError, FileError};

use super::image::Extent;

/// Cells that finer ones cover, or that are blanked (`vtkDataSetAttributes::REFINEDCELL`, `HIDDENCELL`). Copies of other pieces' cells stay: their
/// values are right.
const HIDDEN_CELL: u8 = 8 | 32;
/// A point that is blanked: the cells at it are not shown.
const HIDDEN_POINT: u8 = 2;

/// Name of the array of marks.
pub(super) const GHOST_TYPE: &str = "vtkGhostType";

/// Marks of the points and cells of a lattice; none where the file has none.
#[derive(Debug, Default)]
pub(super) struct Marks {
    pub of_points: Option<Vec<f64>>,
    pub of_cells: Option<Vec<f64>>,
}

impl Marks {
    /// Takes the marks of all points or of all cells of a lattice; `numbers` gives so many of them.
    ///
    /// # Errors
    /// Those of `numbers`, and a lattice of more points than can be counted.
    pub fn take(
        &mut self,
        of_cells: bool,
        extent: &Extent,
        path: &Path,
        numbers: impl FnOnce(usize) -> Result<Vec<f64>, FileError>,
    ) -> Result<(), FileError> {
        let count = extent.dims(of_cells).iter().try_fold(1usize, |n, &size| n.checked_mul(size));
        let many = || FieldError::new(GHOST_TYPE, "too many points", "must be fewer").in_file(path);
        *if of_cells { &mut self.of_cells } else { &mut self.of_points } = Some(numbers(count.ok_or_else(many)?)?);
        Ok(())
    }

    /// Blanks the values of a lattice of so many points along each axis; returns the number of cells that stay although they are marked.
    ///
    /// A value of a cell goes with the cell or with one of its points. A value of a point goes with the point, or where all cells around it are
    /// marked; a marked cell among others keeps its corners, which they need.
    pub fn blank(&self, values: &mut [f64], points: [usize; 3], of_cells: bool) -> usize {
        let cells = points.map(|n| n - 1);
        let is_point = |i: usize| is_marked(self.of_points.as_deref(), i, HIDDEN_POINT);
        let is_cell = |i: usize| is_marked(self.of_cells.as_deref(), i, HIDDEN_CELL);
        if of_cells {
            for (i, at) in places(cells).enumerate() {
                let corners = around([0, 1, 2].map(|a| at[a]..at[a] + 2), points);
                if is_cell(i) || self.of_points.is_some() && { corners }.any(is_point) {
                    values[i] = f64::NAN;
                }
            }
            return 0;
        }
        for (i, at) in places(points).enumerate() {
            let beside = [0, 1, 2].map(|a| at[a].saturating_sub(1)..(at[a] + 1).min(cells[a]));
            if is_point(i) || self.of_cells.is_some() && around(beside, cells).all(is_cell) {
                values[i] = f64::NAN;
            }
        }
        let has_all =
            |at: [usize; 3]| around([0, 1, 2].map(|a| at[a]..at[a] + 2), points).all(|corner| !values[corner].is_nan());
        let marked = places(cells).enumerate().filter(|&(i, _)| self.of_cells.is_some() && is_cell(i));
        marked.filter(|&(_, at)| has_all(at)).count()
    }
}

fn is_marked(marks: Option<&[f64]>, i: usize, bits: u8) -> bool {
    marks.and_then(|marks| marks.get(i)).is_some_and(|&mark| mark as u8 & bits != 0)
}

/// Places of a lattice, x running fastest.
fn places([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// Numbers of the places in a box of a lattice.
fn around([x, y, z]: [Range<usize>; 3], [nx, ny, _]: [usize; 3]) -> impl Iterator<Item = usize> {
    z.flat_map(move |k| {
        let x = x.clone();
        y.clone().flat_map(move |j| x.clone().map(move |i| i + nx * (j + ny * k)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nan(values: &[f64]) -> Vec<usize> {
        (0..values.len()).filter(|&i| values[i].is_nan()).collect()
    }

    #[test]
    fn cells_go_with_their_marks_and_those_of_their_points() {
        let mut marks = Marks { of_points: None, of_cells: Some(vec![1.0, 8.0, 32.0]) };
        let mut values = vec![0.0; 3];
        assert_eq!((marks.blank(&mut values, [4, 2, 2], true), nan(&values)), (0, vec![1, 2]));
        let mut points = vec![0.0; 16];
        points[12] = 2.0;
        marks = Marks { of_points: Some(points), of_cells: None };
        values = vec![0.0; 3];
        assert_eq!((marks.blank(&mut values, [4, 2, 2], true), nan(&values)), (0, vec![0]));
    }

    #[test]
    fn points_go_where_all_cells_around_are_marked() {
        let marks = Marks { of_points: None, of_cells: Some(vec![32.0, 32.0, 0.0]) };
        let mut values = vec![0.0; 16];
        assert_eq!(marks.blank(&mut values, [4, 2, 2], false), 0);
        assert_eq!(nan(&values), [0, 1, 4, 5, 8, 9, 12, 13]);
        let marks = Marks { of_points: None, of_cells: Some(vec![0.0, 32.0, 0.0]) };
        let mut values = vec![0.0; 16];
        assert_eq!((marks.blank(&mut values, [4, 2, 2], false), nan(&values)), (1, vec![]));
    }
}
