//! Values of nodes and elements.

use crate::decode::numbers_as_f64;
use crate::error::FileErrorKind;
use crate::netcdf::Classic;
use crate::scalar::Endian;
use crate::variables::{Store, Variable};
use crate::vtk::Candidate;

use super::blocks::Block;
use super::variable;

/// An array: of one variable of the file, or of the three components of a vector.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Values {
    of_elements: bool,
    /// Numbers of the variables, from 1.
    components: Vec<usize>,
}

/// The arrays of a file, and what there is to know for a choice.
pub(super) fn candidates(store: &Classic) -> Result<(Vec<Values>, Vec<Candidate>), FileErrorKind> {
    let (mut values, mut candidates) = (Vec::new(), Vec::new());
    for (list, of_elements) in [("name_nod_var", false), ("name_elem_var", true)] {
        let names = store.lines(list)?;
        for (name, components) in arrays(&names) {
            let candidate = Candidate { name, components: components.len(), of_cells: of_elements, is_scalars: false };
            candidates.push(candidate);
            values.push(Values { of_elements, components });
        }
    }
    Ok((values, candidates))
}

/// Names with the numbers of their variables: each by itself, then vectors of three that end in x, y and z.
fn arrays(names: &[String]) -> Vec<(String, Vec<usize>)> {
    let mut arrays: Vec<_> = names.iter().enumerate().map(|(i, name)| (name.clone(), vec![i + 1])).collect();
    for (i, three) in names.windows(3).enumerate() {
        let stem = |k: usize| {
            let (end, letter) = (three[k].char_indices().next_back()?, ['x', 'y', 'z'][k]);
            (end.1.eq_ignore_ascii_case(&letter)).then(|| three[k][..end.0].trim_end_matches('_'))
        };
        if let (Some(x), Some(y), Some(z)) = (stem(0), stem(1), stem(2))
            && x == y
            && y == z
            && !x.is_empty()
            && !names.iter().any(|name| name == x)
        {
            arrays.push((x.to_owned(), vec![i + 1, i + 2, i + 3]));
        }
    }
    arrays
}

impl Values {
    /// Number of time steps; `None` where no block has the values.
    pub fn frames(&self, store: &Classic) -> Option<usize> {
        let name = |v: &Variable| v.name.starts_with(if self.of_elements { "vals_elem_var" } else { "vals_nod_var" });
        store.variables().iter().find(|v| name(v)).and_then(|v| v.shape.first().copied())
    }

    /// Numbers of all nodes or elements at a time: all components of the first, then of the second, and so on.
    pub fn read(&self, store: &Classic, frame: usize, blocks: &[Block]) -> Result<Vec<f64>, FileErrorKind> {
        let parts = self.components.iter().map(|&number| self.component(store, number, frame, blocks));
        let parts = parts.collect::<Result<Vec<_>, _>>()?;
        if let [only] = &parts[..] {
            return Ok(only.clone());
        }
        let count = parts.iter().map(Vec::len).min().unwrap_or(0);
        Ok((0..count).flat_map(|i| parts.iter().map(move |part| part[i])).collect())
    }

    fn component(
        &self,
        store: &Classic,
        number: usize,
        frame: usize,
        blocks: &[Block],
    ) -> Result<Vec<f64>, FileErrorKind> {
        if !self.of_elements {
            // Older files have all of them in one variable.
            let (name, all) = (format!("vals_nod_var{number}"), "vals_nod_var");
            return match (variable(store, &name), variable(store, all)) {
                (Some(own), _) => at_time(store, own, &[frame]),
                (None, Some(all)) => at_time(store, all, &[frame, number - 1]),
                (None, None) => Err(FileErrorKind::field(name, "nothing", "the file names it, and must have it")),
            };
        }
        let mut numbers = Vec::new();
        for block in blocks {
            match variable(store, &format!("vals_elem_var{number}eb{}", block.number)) {
                Some(own) => numbers.extend(at_time(store, own, &[frame])?),
                // A block need not have every value: its elements are vacuum.
                None => numbers.resize(numbers.len() + block.elements, f64::NAN),
            }
        }
        Ok(numbers)
    }
}

/// Numbers along the last axis of a variable, at indices along those before.
fn at_time(store: &Classic, variable: &Variable, indices: &[usize]) -> Result<Vec<f64>, FileErrorKind> {
    let fits = variable.shape.len() == indices.len() + 1 && indices.iter().zip(&variable.shape).all(|(&i, &n)| i < n);
    let Some((&count, _)) = variable.shape.split_last().filter(|_| fits) else {
        let found = format!("{:?}", variable.shape);
        let allowed = format!("must hold the indices {indices:?} and, along one axis more, all values");
        return Err(FileErrorKind::field(format!("sizes of {}", variable.name), found, allowed));
    };
    let start: Vec<usize> = indices.iter().copied().chain([0]).collect();
    let counts: Vec<usize> = indices.iter().map(|_| 1).chain([count]).collect();
    Ok(numbers_as_f64(&store.read(variable, &start, &counts)?, variable.scalar, Endian::Big))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_names_are_a_vector() {
        let names = ["T", "VelX", "VelY", "VelZ", "b_x", "b_y", "b_z", "x", "y", "z"].map(String::from);
        let found = arrays(&names);
        assert_eq!(found.len(), 12);
        assert_eq!(found[10], ("Vel".to_owned(), vec![2, 3, 4]));
        assert_eq!(found[11], ("b".to_owned(), vec![5, 6, 7]));
    }
}
