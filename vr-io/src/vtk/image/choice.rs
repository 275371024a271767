//! Choice of the array that becomes the volume.

use crate::error::FieldError;
use crate::names;
use crate::read::ReadOptions;

/// An array that could be taken.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub name: String,
    /// Numbers per point or cell.
    pub components: usize,
    pub of_cells: bool,
    /// True if the file calls it the scalars of its points or cells.
    pub is_scalars: bool,
}

impl Candidate {
    /// Marks of points and cells that a reader should not show.
    pub fn is_ghost(&self) -> bool {
        matches!(self.name.as_str(), "vtkGhostType" | "vtkGhostLevels" | "vtkValidPointMask")
    }
}

/// Finds the array that the options name; else the scalars, the first array with one component, or the first. Points come before cells.
pub(crate) fn choose(
    candidates: &[Candidate],
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<usize, FieldError> {
    // Stable: within points, and within cells, the order is the file's.
    let mut order: Vec<usize> = (0..candidates.len()).collect();
    order.sort_by_key(|&i| candidates[i].of_cells);
    let sorted: Vec<String> = order.iter().map(|&i| candidates[i].name.clone()).collect();
    if sorted.is_empty() {
        let allowed = "the file must hold an array of numbers of its points or cells";
        return Err(FieldError::new("PointData and CellData", "no arrays", allowed));
    }
    if let Some(name) = &options.array {
        let found = names::named(&sorted, name).ok_or_else(|| names::missing("array", name, &sorted))?;
        return Ok(order[found]);
    }
    let first = |good: &dyn Fn(&Candidate) -> bool| order.iter().copied().find(|&i| good(&candidates[i]));
    let (chosen, reason) = if let Some(i) = first(&|c| c.is_scalars) {
        (i, "the active scalars")
    } else if let Some(i) = first(&|c| c.components == 1 && !c.is_ghost()) {
        (i, "the first with one component")
    } else {
        (order[0], "the first")
    };
    if sorted.len() > 1 {
        let Candidate { name, of_cells, .. } = &candidates[chosen];
        let of = if *of_cells { "cells" } else { "points" };
        notes.push(format!("array '{name}' of the {of} is taken, {reason} of {}", names::listed(&sorted)));
    }
    Ok(chosen)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(name: &str, components: usize, of_cells: bool, is_scalars: bool) -> Candidate {
        Candidate { name: name.to_owned(), components, of_cells, is_scalars }
    }

    fn chosen(candidates: &[Candidate], array: Option<&str>) -> Result<usize, String> {
        let options = ReadOptions { array: array.map(str::to_owned), ..ReadOptions::default() };
        choose(candidates, &options, &mut Vec::new()).map_err(|e| e.to_string())
    }

    #[test]
    fn scalars_come_before_single_components_and_these_before_the_rest() {
        let mut list = vec![
            candidate("level", 1, true, false),
            candidate("velocity", 3, false, false),
            candidate("vtkGhostType", 1, false, false),
            candidate("density", 1, false, false),
            candidate("pressure", 1, false, true),
        ];
        assert_eq!(chosen(&list, None), Ok(4));
        list.pop();
        assert_eq!(chosen(&list, None), Ok(3));
        list.pop();
        assert_eq!(chosen(&list, None), Ok(0));
        assert_eq!(chosen(&list[1..], None), Ok(0));
        assert_eq!(chosen(&list, Some("Velocity")), Ok(1));
        let error = chosen(&list, Some("heat")).unwrap_err();
        assert_eq!(error, "array: found heat; must be one of velocity, vtkGhostType, level");
        assert!(chosen(&[], None).unwrap_err().contains("no arrays"));
    }
}
