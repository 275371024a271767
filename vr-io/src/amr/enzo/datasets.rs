//! Numbers of Enzo's grids, in HDF5: a group for each grid, a dataset for each field, with z, y and x for axes.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use crate::error::{FileError, FileErrorKind, shown};
use crate::facts::Facts;
use crate::read::each_once;
use crate::scalar::ScalarType;
use crate::vtk::Candidate;

use super::super::amr_file::{AmrFile, Hierarchy, count_of};
use super::super::crop::crop;
use super::Texts;
use super::grid_file::{Field, GridFile};
use super::grids::Grid;

/// A mesh of which the texts and the names of the fields have been read.
pub(super) struct Datasets {
    texts: Texts,
    arrays: Vec<Candidate>,
    scalar: ScalarType,
    /// The file that was read last: grids of one file stand together.
    last: RefCell<Option<(PathBuf, GridFile)>>,
}

impl Datasets {
    /// Finds the fields of the first grid.
    ///
    /// # Errors
    /// A file that is missing or damaged, or a first grid without fields.
    pub fn open(texts: Texts) -> Result<Self, FileError> {
        let mut found = Self { texts, arrays: Vec::new(), scalar: ScalarType::F32, last: RefCell::new(None) };
        let grid = &found.texts.grids[0];
        let mut fields = found.in_file_of(grid, |file| {
            let mut fields = file.fields(&group_of(grid))?;
            fields.retain(|(_, shape, _)| held_cells(shape, grid).is_some());
            Ok(fields)
        })?;
        let Some(&(_, _, scalar)) = fields.first() else {
            let allowed = "must be a group of datasets with a number for each of its cells";
            let kind = FileErrorKind::field(group_of(grid), "no field", allowed);
            return Err(FileError::new(&found.path_of(grid), kind));
        };
        // Those of the parameters come first, in their order.
        fields.sort_by_key(|(name, ..)| found.texts.labels.iter().position(|l| l == name).unwrap_or(usize::MAX));
        let array = |(name, ..): Field| Candidate { name, components: 1, of_cells: true, is_scalars: false };
        found.arrays = fields.into_iter().map(array).collect();
        found.scalar = scalar;
        Ok(found)
    }

    fn path_of(&self, grid: &Grid) -> PathBuf {
        self.texts.list.parent().unwrap_or(Path::new("")).join(&grid.file)
    }

    /// Does something with the file of a grid.
    fn in_file_of<T>(
        &self,
        grid: &Grid,
        with: impl FnOnce(&mut GridFile) -> Result<T, FileErrorKind>,
    ) -> Result<T, FileError> {
        let path = self.path_of(grid);
        let mut last = self.last.borrow_mut();
        let (_, file) = match &mut *last {
            Some(known) if known.0 == path => known,
            other => {
                if let Err(source) = std::fs::metadata(&path) {
                    let kind = FileErrorKind::DataFile { data: path, source };
                    return Err(FileError::new(&self.texts.list, kind));
                }
                let file = GridFile::open(&path, &group_of(grid)).map_err(|kind| FileError::new(&path, kind))?;
                other.insert((path.clone(), file))
            }
        };
        with(file).map_err(|kind| FileError::new(&path, kind))
    }
}

/// The group of a grid.
fn group_of(grid: &Grid) -> String {
    format!("Grid{:08}", grid.id)
}

/// The shape of a dataset with a number for each of so many cells: the last axis runs fastest.
fn shape_of(cells: [usize; 3]) -> [u64; 3] {
    let [x, y, z] = cells.map(|n| n as u64);
    [z, y, x]
}

/// Cells that a dataset of a shape holds: those of the grid, or its ghost zones, too; `None` for one of something else.
fn held_cells(shape: &[u64], grid: &Grid) -> Option<[usize; 3]> {
    [grid.cells(), grid.whole].into_iter().find(|&cells| shape == shape_of(cells))
}

impl AmrFile for Datasets {
    fn facts(&self) -> Facts {
        let Texts { parameters, list, grids, .. } = &self.texts;
        let data = grids.iter().map(|grid| self.path_of(grid));
        let files = each_once([parameters.clone(), list.clone()].into_iter().chain(data));
        Facts { encoding: "HDF5", scalar: self.scalar, ..Facts::of_form("Enzo", files) }
    }

    fn hierarchy(&self) -> &Hierarchy {
        &self.texts.hierarchy
    }

    fn arrays(&self) -> &[Candidate] {
        &self.arrays
    }

    fn numbers(&self, block: usize, array: usize) -> Result<Vec<f64>, FileError> {
        let (grid, name) = (&self.texts.grids[block], &self.arrays[array].name);
        let (group, own) = (group_of(grid), grid.cells());
        self.in_file_of(grid, |file| {
            for held in [own, grid.whole] {
                let Some(numbers) = file.numbers(&group, name, &shape_of(held))? else { continue };
                if Some(numbers.len()) == count_of(held, 1) {
                    return Ok(if held == own { numbers } else { crop(&numbers, held, grid.start, own, 1) });
                }
            }
            let allowed = format!("must be a dataset of shape {:?}, as the hierarchy says", shape_of(own));
            let place = shown(&format!("{group}/{name}"));
            Err(FileErrorKind::field(place, "no such dataset", allowed))
        })
    }
}
