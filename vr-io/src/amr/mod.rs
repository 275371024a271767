//! Adaptive meshes in: overlapping AMR of VTK, plotfiles of AMReX and packed AMR of Enzo become meshes of blocks.
//!
//! Every format gives the same (`AmrFile`): boxes of blocks on the lattices of their levels, and arrays of values. From there on there is one way:
//! an array is chosen (`crate::chosen`), the blocks are read one after the other, and the mesh is made (`load`).

mod align;
mod amr_file;
mod amrex;
mod crop;
mod enzo;
mod lattices;
mod load;
mod text;
mod vthb;

use std::path::Path;

use crate::error::FileError;
use crate::read::{Loaded, ReadOptions};

/// The formats of adaptive meshes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum AmrFormat {
    /// Overlapping and non-overlapping AMR of VTK's XML: a list of images.
    Vthb,
    /// A plotfile of AMReX: a folder with a file `Header`.
    Amrex,
    /// Packed AMR of Enzo: parameters, a hierarchy, and HDF5 files.
    Enzo,
}

/// The format of a file that its beginning shows, together with its name and the files beside it.
pub(crate) fn by_content(path: &Path, head: &[u8]) -> Option<AmrFormat> {
    if vthb::is_vthb(head) {
        Some(AmrFormat::Vthb)
    } else if amrex::is_header(head) {
        Some(AmrFormat::Amrex)
    } else if enzo::is_part(path, head) {
        Some(AmrFormat::Enzo)
    } else {
        None
    }
}

/// The format of a folder that is a mesh by itself.
pub(crate) fn of_folder(folder: &Path) -> Option<AmrFormat> {
    if amrex::is_plotfile(folder) {
        Some(AmrFormat::Amrex)
    } else if enzo::hierarchy_in(folder).is_some() {
        Some(AmrFormat::Enzo)
    } else {
        None
    }
}

/// Reads a mesh.
///
/// # Errors
/// A choice that the files do not have, and anything in them that is not as it must be.
pub(crate) fn read_as(format: AmrFormat, path: &Path, options: &ReadOptions) -> Result<Loaded, FileError> {
    match format {
        AmrFormat::Vthb => load::load(&vthb::Vthb::open(path)?, path, options),
        AmrFormat::Amrex => load::load(&amrex::Plotfile::open(path)?, path, options),
        AmrFormat::Enzo => enzo::load(path, options),
    }
}
