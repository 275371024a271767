//! STRUCTURED_POINTS of legacy files (.vtk).

use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::error::{FileError, FileErrorKind};
use crate::payload::Payload;
use crate::scalar::{Endian, ScalarType};
use crate::source::{Decoded, Source};
use crate::vtk::legacy::{Attribute, LatticeLines};
use crate::vtk::{Array, Legacy};

use super::choice::Candidate;
use super::lattice::{Extent, Lattice};
use super::{Header, Numbers};

/// Reads everything but numbers.
pub(super) fn header(path: &Path) -> Result<Header<Array>, FileErrorKind> {
    let Legacy { lattice, attributes, point_count, cell_count, .. } = Legacy::read(path, &["STRUCTURED_POINTS"])?;
    let extent = extent_of(&lattice)?;
    Ok(Header {
        arrays: lattice_arrays(&extent, [point_count, cell_count], attributes)?,
        lattice: Lattice {
            extent,
            origin: lattice.origin.map_or(DVec3::ZERO, DVec3::from_array),
            spacing: lattice.spacing.map(DVec3::from_array),
            direction: None,
        },
        notes: Vec::new(),
    })
}

/// The extent that the lines of a lattice tell.
pub(in crate::vtk) fn extent_of(lattice: &LatticeLines) -> Result<Extent, FileErrorKind> {
    let extent = match (lattice.dimensions, lattice.extent) {
        (_, Some(numbers)) => Extent::new("EXTENT", numbers)?,
        (Some(dims), None) => Extent::of_dims("DIMENSIONS", dims)?,
        (None, None) => return Err(FileErrorKind::field("DIMENSIONS", "nothing", "must be three positive integers")),
    };
    extent.ok_or_else(|| FileErrorKind::field("DIMENSIONS", "an axis without points", "all must be positive"))
}

/// The arrays that fit a lattice, with as many numbers as it has points or cells; the file claims `counts` of these.
///
/// # Errors
/// Claims that are not the lattice's.
pub(in crate::vtk) fn lattice_arrays(
    extent: &Extent,
    [point_count, cell_count]: [Option<usize>; 2],
    attributes: Vec<Attribute>,
) -> Result<Vec<(Candidate, Array)>, FileErrorKind> {
    for (of_cells, keyword, claimed) in [(false, "POINT_DATA", point_count), (true, "CELL_DATA", cell_count)] {
        let dims = extent.dims(of_cells);
        let count = dims.iter().try_fold(1usize, |n, &size| n.checked_mul(size));
        if let Some(claimed) = claimed.filter(|&claimed| Some(claimed) != count) {
            let [x, y, z] = dims;
            return Err(FileErrorKind::field(keyword, claimed, format!("DIMENSIONS make {x} x {y} x {z} of them")));
        }
    }
    let count = |of_cells: bool| if of_cells { cell_count } else { point_count };
    let fitting = attributes.into_iter().filter(|a| {
        a.components > 0 && count(a.of_cells).and_then(|count| count.checked_mul(a.components)) == Some(a.array.numbers)
    });
    let arrays = fitting.map(|a| {
        let name = a.array.name.clone();
        let of = Candidate { name, components: a.components, of_cells: a.of_cells, is_scalars: a.is_scalars };
        (of, a.array)
    });
    Ok(arrays.collect())
}

impl Numbers for Array {
    fn scalar(&self) -> Option<ScalarType> {
        Some(self.scalar)
    }

    fn numbers(&self, path: &Path, _: usize) -> Result<Vec<f64>, FileError> {
        self.numbers(path).map_err(|kind| FileError::new(path, kind))
    }

    fn held_by(&self, path: &Path) -> (&'static str, Vec<PathBuf>) {
        (self.encoding(), vec![path.into()])
    }

    fn source(self, path: &Path, _: usize) -> Result<Source, FileError> {
        let (scalar, endian) = (self.scalar, Endian::Big);
        if let Some(start) = self.place_in_file() {
            let payload = Payload::part(path, start, scalar, endian);
            return Ok(payload.into());
        }
        let (encoding, file) = (self.encoding(), path.to_path_buf());
        let decode = Box::new(move |_: &mut Vec<String>| self.bytes(&file).map_err(|kind| FileError::new(&file, kind)));
        Ok(Decoded { decode, scalar, endian, encoding, files: vec![path.into()] }.into())
    }
}
