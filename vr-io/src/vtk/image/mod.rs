//! Images of VTK: ImageData (.vti), lists of such files (.pvti), and STRUCTURED_POINTS of legacy files (.vtk).
//!
//! World positions are origin + direction · (spacing ∘ index), and indices need not begin at 0 (`vtkImageData`). Numbers belong to the points of
//! the lattice or to its cells; those of cells are placed at the cells' centres. Points and cells that `vtkGhostType` hides have no value.

mod choice;
mod hidden;
mod lattice;
mod legacy;
mod pieces;
mod xml;

use std::path::{Path, PathBuf};

use vr_core::Calibration;

use crate::error::FileError;
use crate::layout::{Axis, Layout, Role};
use crate::notes::Notes;
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

    /// Its `count` numbers.
    fn numbers(&self, path: &Path, count: usize) -> Result<Vec<f64>, FileError>;

    /// The encoding in a word, and the files that hold the numbers.
    fn held_by(&self, path: &Path) -> (&'static str, Vec<PathBuf>);

    /// Source of its `count` numbers.
    fn source(self, path: &Path, count: usize) -> Result<Source, FileError>;
}

impl<A: Numbers + 'static> Header<A> {
    fn describe(self, format: &'static str, path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
        let Self { lattice, arrays, notes } = self;
        let mut notes = Notes::from(notes);
        let (candidates, mut arrays): (Vec<Candidate>, Vec<A>) = arrays.into_iter().unzip();
        let chosen = choose(&candidates, options, &mut notes).map_err(|e| e.in_file(path))?;
        let Candidate { components, of_cells, .. } = candidates[chosen];
        let axis = |size, role| Axis { size, role };
        let [nx, ny, nz] = lattice.extent.dims(of_cells).map(|size| axis(size, Role::Space));
        let of_voxel = arrays[chosen].scalar().map_or(Role::Component, |s| Role::of_components(components, s));
        let layout = Layout::new(path, &[axis(components, of_voxel), nx, ny, nz], options)?;
        let placement = lattice.placement(of_cells, &mut notes).map_err(|e| FileError::new(path, e))?;
        let hidden = if candidates[chosen].is_ghost() {
            None
        } else {
            hidden::hidden(&candidates, &arrays, (&lattice.extent, of_cells), path)?
        };
        let array = arrays.swap_remove(chosen);
        let source = match hidden {
            Some(hidden) if of_voxel == Role::Color => {
                notes.push(hidden.shown_in_colors());
                array.source(path, layout.total)?
            }
            Some(hidden) => hidden.left_out(array, components, path),
            None => array.source(path, layout.total)?,
        };
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

#[cfg(test)]
mod tests {
    use std::fs;

    use vr_core::Volume;

    use super::*;
    use crate::read;

    /// Writes a file, reads it back, and returns the values, with what was noted.
    fn values_of(name: &str, text: &str) -> (Vec<f64>, Vec<String>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        let loaded = read(&path, &ReadOptions::default()).unwrap();
        let Volume::Grid(grid) = &loaded.volume else { panic!("a grid") };
        let [nx, ny, nz] = grid.dims();
        let places = (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])));
        let all = vr_core::with_grid!(grid.values(), g => {
            places.map(|[x, y, z]| f64::from(g.samples()[(z * ny + y) * nx + x])).collect()
        });
        (all, loaded.notes)
    }

    fn vti(values: &str, of_points: &str, of_cells: &str) -> String {
        format!(
            r#"<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian">
<ImageData WholeExtent="0 3 0 1 0 1" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 3 0 1 0 1">
<PointData Scalars="v"><DataArray type="UInt8" Name="v" format="ascii">{values}</DataArray>{of_points}</PointData>
<CellData>{of_cells}</CellData></Piece></ImageData></VTKFile>"#
        )
    }

    fn marks(numbers: &str) -> String {
        format!(r#"<DataArray type="UInt8" Name="vtkGhostType" format="ascii">{numbers}</DataArray>"#)
    }

    const VALUES: &str = "0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15";

    fn missing(values: &[f64]) -> Vec<usize> {
        (0..values.len()).filter(|&i| values[i].is_nan()).collect()
    }

    #[test]
    fn hidden_points_have_no_value() {
        let of_points = marks("0 1 0 0 0 0 2 0 0 0 0 0 0 0 0 2");
        let (values, notes) = values_of("hidden.vti", &vti(VALUES, &of_points, ""));
        // A copy of another piece's point (1) is a point like any other.
        assert_eq!((missing(&values), values[1], values[14]), (vec![6, 15], 1.0, 14.0));
        assert!(notes.iter().any(|n| n.contains("2 of 16 values are hidden")), "{notes:?}");
    }

    #[test]
    fn points_of_hidden_cells_alone_have_no_value() {
        let (values, _) = values_of("cells.vti", &vti(VALUES, "", &marks("32 0 0")));
        assert_eq!(missing(&values), [0, 4, 8, 12]);
    }

    #[test]
    fn marks_that_hide_nothing_leave_integers() {
        let (values, notes) = values_of("shown.vti", &vti(VALUES, &marks(&["0"; 16].join(" ")), &marks("1 0 1")));
        assert!(missing(&values).is_empty() && !notes.iter().any(|n| n.contains("hidden")), "{notes:?}");
    }

    #[test]
    fn legacy_files_hide_cells() {
        let text = "# vtk DataFile Version 5.1\ncells\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 4 3 3\nORIGIN 0 0 0\nSPACING 1 1 1\n\
            CELL_DATA 12\nSCALARS v float 1\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7 8 9 10 11\n\
            FIELD FieldData 1\nvtkGhostType 1 12 unsigned_char\n0 0 32 0 0 8 0 0 0 0 1 0\n";
        let (values, _) = values_of("cells.vtk", text);
        assert_eq!((missing(&values), values[10]), (vec![2, 5], 10.0));
    }
}
