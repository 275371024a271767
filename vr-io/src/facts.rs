//! Facts about a file whose numbers have positions of their own: of points, cells, and grids that are not uniform.

use std::path::PathBuf;

use crate::error::FieldError;
use crate::read::FileInfo;
use crate::scalar::{Endian, ScalarType};
use crate::world::Space;

/// Facts about a file as a whole.
#[derive(Clone, Debug)]
pub(crate) struct Facts {
    pub format: &'static str,
    pub encoding: &'static str,
    /// Type of the positions, or of the values where positions follow from a few numbers.
    pub scalar: ScalarType,
    pub endian: Endian,
    /// Number of time steps.
    pub frames: usize,
    /// Every file that is read.
    pub files: Vec<PathBuf>,
}

impl Facts {
    /// Facts about a file of one time step, whose encoding and type are those of the array that is taken.
    pub fn of_form(format: &'static str, files: Vec<PathBuf>) -> Self {
        Self { format, encoding: "raw", scalar: ScalarType::F32, endian: Endian::NATIVE, frames: 1, files }
    }

    /// Refuses a time step that the file does not have.
    ///
    /// # Errors
    /// A number that is not below that of the steps.
    pub fn check_frame(&self, frame: Option<usize>) -> Result<(), FieldError> {
        match frame.filter(|&frame| frame >= self.frames) {
            Some(frame) => {
                let allowed = format!("the file has {}, counted from 0", self.frames);
                Err(FieldError::new("frame", frame, allowed))
            }
            None => Ok(()),
        }
    }

    /// The facts that callers are told, with the number of components of the array that is taken, and the names of all arrays.
    pub fn into_info(self, placed_by: &'static str, components: usize, columns: Vec<String>) -> FileInfo {
        let Self { format, encoding, scalar, endian, frames, files } = self;
        FileInfo {
            format,
            encoding,
            scalar,
            endian,
            space: Space::Own,
            placed_by,
            units: None,
            frames,
            components,
            columns,
            data_files: files.clone(),
            files,
            mapped: false,
            modality: None,
            window: None,
        }
    }
}
