//! Values of an image that its file hides.

use std::path::Path;

use crate::error::FileError;
use crate::scalar::{Endian, ScalarType};
use crate::source::{Decoded, Source};
use crate::vtk::blanking::{GHOST_TYPE, Marks};

use super::Numbers;
use super::choice::Candidate;
use super::lattice::Extent;

/// Points or cells that are hidden, by their numbers; there is at least one.
pub(super) struct Hidden(Vec<bool>);

/// Reads the marks of a lattice; `None` where they hide no point, or no cell if those have the values.
///
/// # Errors
/// Marks that cannot be read, or that are not one for each point or cell.
pub(super) fn hidden<A: Numbers>(
    candidates: &[Candidate],
    arrays: &[A],
    (extent, of_cells): (&Extent, bool),
    path: &Path,
) -> Result<Option<Hidden>, FileError> {
    // A flat image has no cells to hide, and shows nothing anyway.
    let points = extent.dims(false);
    let is_mark = |c: &Candidate| c.name == GHOST_TYPE && c.components == 1;
    if points.contains(&1) || !candidates.iter().any(is_mark) {
        return Ok(None);
    }
    let mut marks = Marks::default();
    for (candidate, array) in candidates.iter().zip(arrays).filter(|(c, _)| is_mark(c)) {
        marks.take(candidate.of_cells, extent, path, |count| array.numbers(path, count))?;
    }
    // The marks are there: points are at most eight times as many as cells.
    let mut values = vec![0.0; extent.dims(of_cells).iter().product()];
    marks.blank(&mut values, points, of_cells);
    let hidden: Vec<bool> = values.iter().map(|v| v.is_nan()).collect();
    Ok(hidden.contains(&true).then_some(Hidden(hidden)))
}

impl Hidden {
    fn count(&self) -> usize {
        self.0.iter().filter(|hidden| **hidden).count()
    }

    /// A note that colours have no missing values.
    pub(super) fn shown_in_colors(&self) -> String {
        format!(
            "{} of {} voxels are hidden by {GHOST_TYPE}: they are shown, for colours cannot be missing",
            self.count(),
            self.0.len()
        )
    }

    /// Source of an array without its hidden values: they are NaN, which only floats have, so that all become floats.
    pub(super) fn left_out<A: Numbers + 'static>(self, array: A, components: usize, path: &Path) -> Source {
        let ((encoding, files), path) = (array.held_by(path), path.to_path_buf());
        let decode = move |notes: &mut Vec<String>| {
            let mut numbers = array.numbers(&path, self.0.len() * components)?;
            for (voxel, _) in numbers.chunks_mut(components).zip(&self.0).filter(|(_, hidden)| **hidden) {
                voxel.fill(f64::NAN);
            }
            notes.push(format!("{} of {} values are hidden by {GHOST_TYPE}, and missing", self.count(), self.0.len()));
            Ok(numbers.iter().flat_map(|x| x.to_le_bytes()).collect())
        };
        Decoded { decode: Box::new(decode), scalar: ScalarType::F64, endian: Endian::Little, encoding, files }.into()
    }
}
