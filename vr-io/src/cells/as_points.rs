//! The vertices of a file of cells, taken for scattered points.

use std::path::Path;

use glam::DVec3;

use crate::error::{FieldError, FileError};
use crate::points::{Columns, PointOptions, points_of_columns};
use crate::read::{Loaded, ReadOptions};

use super::cell_file::CellFile;

/// Makes points of the vertices of all pieces, with the arrays of one component for columns.
///
/// # Errors
/// Faults of the file, of the choices, or of points that make no sense.
pub(super) fn load_points(file: &dyn CellFile, path: &Path, options: &ReadOptions) -> Result<Loaded, FileError> {
    if let Some(component) = options.component {
        return Err(FieldError::new("component", component, "scattered points have none to choose").in_file(path));
    }
    file.facts().check_frame(options.frame).map_err(|e| e.in_file(path))?;
    let choices = PointOptions { value: options.array.clone(), ..options.points.clone() };
    let (mut positions, mut counts, mut cells) = (Vec::<DVec3>::new(), Vec::new(), 0);
    for k in 0..file.pieces() {
        let piece = file.piece(k)?;
        cells += piece.cells.count();
        counts.push(piece.positions.len());
        positions.extend(piece.positions);
    }
    let arrays = file.arrays();
    let single: Vec<usize> = (0..arrays.len()).filter(|&i| arrays[i].components == 1 && !arrays[i].of_cells).collect();
    let load = |column: usize| {
        let mut all = Vec::new();
        for (k, &count) in counts.iter().enumerate().filter(|&(_, &count)| count > 0) {
            let numbers = file.numbers(k, single[column])?;
            if numbers.len() != count {
                let (name, found) = (&arrays[single[column]].name, format!("{} numbers", numbers.len()));
                let error = FieldError::new(format!("array {name}"), found, format!("there are {count} vertices"));
                return Err(error.in_file(path));
            }
            all.extend(numbers);
        }
        Ok(all)
    };
    let names: Vec<String> = single.iter().map(|&i| arrays[i].name.clone()).collect();
    let mut notes = vec![format!("{cells} cells are left out: their points are taken")];
    let points = points_of_columns(path, Columns { positions, names: &names, load: &load }, &choices, &mut notes)?;
    let info = file.facts().into_info("positions", 1, names);
    Ok(Loaded { volume: points.into(), info, notes })
}
