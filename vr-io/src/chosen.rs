//! Choice of the values of meshes and of grids that are not uniform: an array, or 1 everywhere, and one number of each of its tuples.

use crate::error::FieldError;
use crate::read::ReadOptions;
use crate::vtk::{Candidate, choose};

/// Name that stands for a value of 1 everywhere, as for points.
const ONE: &str = "1";

/// The values that are taken.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chosen {
    /// Number of the array; `None` for 1 everywhere.
    pub array: Option<usize>,
    pub of_cells: bool,
    /// Name of the array.
    pub name: String,
    /// Numbers of each vertex or cell.
    pub components: usize,
    /// The one that is taken; `None` for the length of all together.
    component: Option<usize>,
}

impl Chosen {
    /// Chooses the values of a mesh: an array as [`Self::of_arrays`] does, or 1 everywhere; `None` where there is no array and none was asked for.
    ///
    /// # Errors
    /// A name that no array has, or a component that the array does not have.
    pub fn of_mesh(
        arrays: &[Candidate],
        options: &ReadOptions,
        notes: &mut Vec<String>,
    ) -> Result<Option<Self>, FieldError> {
        let wants_one = options.array.as_deref() == Some(ONE) && !arrays.iter().any(|a| a.name == ONE);
        if wants_one {
            return Ok(Some(Self { array: None, of_cells: false, name: ONE.into(), components: 1, component: None }));
        }
        if arrays.is_empty() && options.array.is_none() {
            return Ok(None);
        }
        Self::of_arrays(arrays, options, notes).map(Some)
    }

    /// Chooses an array: that of the options, the active scalars, the first with one component, or the first.
    ///
    /// # Errors
    /// No array, a name that none has, or a component that the array does not have.
    pub fn of_arrays(arrays: &[Candidate], options: &ReadOptions, notes: &mut Vec<String>) -> Result<Self, FieldError> {
        let array = choose(arrays, options, notes)?;
        let Candidate { name, components, of_cells, .. } = arrays[array].clone();
        if let Some(component) = options.component.filter(|&c| c >= components) {
            let allowed = format!("array '{name}' has {components}, counted from 0");
            return Err(FieldError::new("component", component, allowed));
        }
        if components > 1 && options.component.is_none() {
            notes.push(format!("array '{name}' has {components} components: their length is taken, the root of the sum of their squares"));
        }
        Ok(Self { array: Some(array), of_cells, name, components, component: options.component })
    }

    /// One value of each of `count` vertices or cells, from all their numbers.
    ///
    /// # Errors
    /// More or fewer numbers than `count` tuples have.
    pub fn values(&self, numbers: Vec<f64>, count: usize) -> Result<Vec<f64>, FieldError> {
        if Some(numbers.len()) != count.checked_mul(self.components) {
            let found = format!("{} numbers", numbers.len());
            let of = if self.of_cells { "cells" } else { "vertices" };
            let allowed = format!("there are {count} {of}, with {} each", self.components);
            return Err(FieldError::new(format!("array {}", self.name), found, allowed));
        }
        Ok(match self.component {
            _ if self.components == 1 => numbers,
            Some(component) => numbers.chunks_exact(self.components).map(|tuple| tuple[component]).collect(),
            None => numbers.chunks_exact(self.components).map(length).collect(),
        })
    }
}

/// Length of a vector of any dimension, without overflow of the squares.
fn length(tuple: &[f64]) -> f64 {
    tuple.iter().fold(0.0, |sum: f64, &x| sum.hypot(x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_a_value_unless_an_array_is_called_so() {
        let options = ReadOptions { array: Some("1".into()), ..ReadOptions::default() };
        let chosen = |arrays: &[Candidate], options: &ReadOptions| Chosen::of_mesh(arrays, options, &mut Vec::new());
        assert_eq!(chosen(&[], &options).unwrap().unwrap().array, None);
        assert_eq!(chosen(&[], &ReadOptions::default()), Ok(None));
        let array = Candidate { name: "1".into(), components: 3, of_cells: true, is_scalars: false };
        let found = chosen(std::slice::from_ref(&array), &options).unwrap().unwrap();
        assert_eq!((found.array, found.components, found.component), (Some(0), 3, None));
        let wrong = ReadOptions { component: Some(3), ..ReadOptions::default() };
        assert_eq!(
            chosen(std::slice::from_ref(&array), &wrong).unwrap_err().to_string(),
            "component: found 3; array '1' has 3, counted from 0"
        );
    }

    #[test]
    fn lengths_do_not_overflow() {
        assert_eq!(length(&[3.0, 4.0]), 5.0);
        assert_eq!(length(&[-2.0]), 2.0);
        assert!(length(&[1e200, 1e200]).is_finite() && length(&[f64::NAN, 1.0]).is_nan());
    }
}
