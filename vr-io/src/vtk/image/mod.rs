//! Images of VTK: ImageData (.vti), lists of such files (.pvti), and STRUCTURED_POINTS of legacy files (.vtk).
//!
//! World positions are origin + direction · (spacing ∘ index), and indices need not begin at 0 (`vtkImageData`). Numbers belong to the points of
//! the lattice or to its cells; those of cells are placed at the cells' centres.

mod choice;
mod lattice;
mod legacy;
mod pieces;
mod xml;

use std::path::Path;

use vr_core::Calibration;

use crate::error::FileError;
use crate::layout::{Axis, Layout, Role};
use crate::read::{Description, ReadOptions};
use crate::scalar::ScalarType;
use crate::source::Source;
use crate::world::Space;

use super::content::{Content, content};
use super::lattice_file::IMAGE;

pub(crate) use choice::{Candidate, choose};
pub(crate) use lattice::Extent;
pub(super) use legacy::{extent_of, lattice_arrays};
pub(super) use pieces::assemble;

use lattice::Lattice;

/// The forms of an image's file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ImageFormat {
    Xml,
    Legacy,
}

/// The form that the beginning of a file shows.
pub(crate) fn by_content(head: &[u8]) -> Option<ImageFormat> {
    match content(head)? {
        Content::Xml(kind) => IMAGE.contains(&kind.as_str()).then_some(ImageFormat::Xml),
        // Where the kind is further down, the reader will tell.
        Content::Legacy(kind) => matches!(kind.as_str(), "STRUCTURED_POINTS" | "").then_some(ImageFormat::Legacy),
    }
}

/// The form that the end of a name tells, in lower case.
pub(crate) fn by_extension(extension: &str) -> Option<ImageFormat> {
    match extension {
        "vti" | "pvti" => Some(ImageFormat::Xml),
        "vtk" => Some(ImageFormat::Legacy),
        _ => None,
    }
}

/// Describes the volume of a header.
pub(crate) fn describe(format: ImageFormat, path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let in_file = |kind| FileError::new(path, kind);
    match format {
        ImageFormat::Xml => {
            let (format, header) = xml::header(path)?;
            header.describe(format, path, options)
        }
        ImageFormat::Legacy => legacy::header(path).map_err(in_file)?.describe("VTK (legacy)", path, options),
    }
}

/// A lattice, and the arrays on it.
struct Header<A> {
    lattice: Lattice,
    arrays: Vec<(Candidate, A)>,
    notes: Vec<String>,
}

/// An array of which the numbers can be found.
trait Numbers {
    /// Type of the numbers; `None` where the array is faulty.
    fn scalar(&self) -> Option<ScalarType>;

    /// Source of its `count` numbers.
    fn source(self, path: &Path, count: usize) -> Result<Source, FileError>;
}

impl<A: Numbers> Header<A> {
    fn describe(self, format: &'static str, path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
        let Self { lattice, arrays, mut notes } = self;
        let (candidates, mut arrays): (Vec<Candidate>, Vec<A>) = arrays.into_iter().unzip();
        let chosen = choose(&candidates, options, &mut notes).map_err(|e| e.in_file(path))?;
        let Candidate { components, of_cells, .. } = candidates[chosen];
        let axis = |size, role| Axis { size, role };
        let [nx, ny, nz] = lattice.extent.dims(of_cells).map(|size| axis(size, Role::Space));
        let of_voxel = arrays[chosen].scalar().map_or(Role::Component, |s| Role::of_components(components, s));
        let layout = Layout::new(path, &[axis(components, of_voxel), nx, ny, nz], options)?;
        let placement = lattice.placement(of_cells, &mut notes).map_err(|e| FileError::new(path, e))?;
        let source = arrays.swap_remove(chosen).source(path, layout.total)?;
        Ok(Description {
            format,
            header: path.into(),
            source,
            layout,
            placement,
            placed_by: lattice.placed_by(),
            calibration: Calibration::default(),
            space: Space::Own,
            units: None,
            scan: None,
            notes,
        })
    }
}
