//! ImageData of VTK's XML (.vti), and lists of such files (.pvti).

use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3};

use crate::error::FileError;
use crate::scalar::ScalarType;
use crate::source::Source;
use crate::vtk::lattice_file::{IMAGE, LatticeFile};
use crate::vtk::piece_arrays::PieceArrays;

use super::lattice::Lattice;
use super::{Header, Numbers};

/// Reads everything but numbers.
pub(super) fn header(path: &Path) -> Result<(&'static str, Header<PieceArrays>), FileError> {
    let file = LatticeFile::open(path, IMAGE)?;
    let notes = file.notes().map_err(|kind| FileError::new(path, kind))?;
    let attributes = &file.attributes;
    let lattice = Lattice {
        extent: file.hull(),
        origin: attributes.origin.map_or(DVec3::ZERO, DVec3::from_array),
        spacing: attributes.spacing.map(DVec3::from_array),
        direction: attributes.direction.map(|m| DMat3::from_cols_array(&m).transpose()),
    };
    let format = if file.is_list { "VTK PImageData" } else { "VTK ImageData" };
    Ok((format, Header { lattice, arrays: PieceArrays::of_file(&file), notes }))
}

impl Numbers for PieceArrays {
    fn scalar(&self) -> Option<ScalarType> {
        self.scalar()
    }

    fn numbers(&self, path: &Path, count: usize) -> Result<Vec<f64>, FileError> {
        self.numbers(path, count)
    }

    fn held_by(&self, _: &Path) -> (&'static str, Vec<PathBuf>) {
        (self.encoding(), self.files())
    }

    fn source(self, path: &Path, count: usize) -> Result<Source, FileError> {
        self.source(path, count)
    }
}
