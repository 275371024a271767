//! Scattered points in: text, VTK, NumPy and HDF5.

mod assemble;
mod columns;
mod delimited;
#[cfg(feature = "hdf5")]
pub(crate) mod hdf5;
mod neighbours;
mod npy;
mod numbers;
mod roles;
mod vtk_legacy;
mod vtk_xml;

use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};
use vr_core::transfer::ColorMap;
use vr_core::{ParameterError, PointKernel, PointMixing, PointSet};

use crate::detect::{Format, detect};
use crate::error::{FileError, FileErrorKind};
use crate::facts::Facts;
use crate::notes::as_lines;
use crate::read::{FileInfo, file_head};
use crate::regular_file;
use crate::scalar::{Endian, ScalarType};
use crate::vtk::{self, Content};

use roles::Roles;

pub(crate) use columns::{Columns, points_of_columns};

/// The formats that are read, as messages list them.
const SUPPORTED: &str = "CSV and TSV, VTK PolyData and UnstructuredGrid (.vtp, .vtu, .vtk), NumPy (.npy, N x 3) and, with the feature hdf5, Gadget and Phantom HDF5";

/// Options of reading points. `PointOptions::default()` is right where columns have the usual names.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PointOptions {
    /// Spread of each point; the default kernel if absent.
    pub kernel: Option<PointKernel>,
    /// Radius of the kernels of all points, in world units, in place of what the file says.
    pub radius: Option<f64>,
    /// Multiplies every radius: more than 1 smoothes.
    pub radius_scale: Option<f64>,
    /// The column or array of the values; `1` for a value of 1 at every point.
    pub value: Option<String>,
    /// Combination of values where supports overlap; their sum if absent.
    pub mixing: Option<PointMixing>,
    /// The column or array of numbers that colour maps make colours of, which points have then; none if absent.
    pub color_value: Option<String>,
    /// The colour map; the default one if absent.
    pub color_map: Option<ColorMap>,
    /// Numbers of the colour map's first colour and of its last; the smallest and the largest there are if absent.
    pub color_range: Option<[f64; 2]>,
    /// The other columns or arrays.
    #[serde(skip_serializing_if = "PointColumns::is_empty")]
    pub columns: PointColumns,
}

/// Columns or arrays of a file of points, by name. What is absent is found by the names that are commonly used.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PointColumns {
    /// x, y and z; of text alone.
    pub position: Option<[String; 3]>,
    /// Reach of a kernel.
    pub radius: Option<String>,
    /// Half of that: h of smoothed particle hydrodynamics.
    pub smoothing_length: Option<String>,
    /// Mass.
    pub mass: Option<String>,
    /// Mass per volume.
    pub density: Option<String>,
    /// Weights, which are mass by density otherwise.
    pub weight: Option<String>,
}

impl PointColumns {
    /// True if no column is named.
    pub(crate) fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl PointOptions {
    /// Checks the numbers.
    ///
    /// # Errors
    /// A radius or factor that is not positive and finite; a range of colours that is none, or choices about colours where none are asked for.
    pub fn validate(&self) -> Result<(), ParameterError> {
        for (field, number) in [("volume.radius", self.radius), ("volume.radius_scale", self.radius_scale)] {
            if let Some(x) = number.filter(|&x| !(x > 1e-30 && x < 1e30)) {
                return Err(ParameterError::new(field, x, "must be positive, between 1e-30 and 1e30"));
            }
        }
        if let Some([low, high]) =
            self.color_range.filter(|[low, high]| !(high - low > 0.0 && (high - low).is_finite()))
        {
            let allowed = "must be two finite numbers, the first below the second";
            return Err(ParameterError::new("volume.color_range", [low, high], allowed));
        }
        let choice = self.color_map.map(|map| ("volume.color_map", map.name().to_owned()));
        let choice = choice.or_else(|| self.color_range.map(|range| ("volume.color_range", format!("{range:?}"))));
        if let (None, Some((field, found))) = (&self.color_value, choice) {
            let allowed = "must go with color_value, the column that colours are made of";
            return Err(ParameterError { field: field.into(), found, allowed });
        }
        Ok(())
    }
}

/// Points from a file.
#[derive(Clone, Debug)]
pub struct LoadedPoints {
    /// The points, where the file puts them.
    pub points: PointSet,
    /// Everything that the file says.
    pub info: FileInfo,
    /// Notes on everything assumed, chosen or left out on the way, one line each.
    pub notes: Vec<String>,
}

/// Memory of a point: position, radius, weight, value and colour, and a place in the order of neighbours.
pub(crate) const BYTES_PER_POINT: u64 = 68;

/// Reads scattered points of any supported format, told by the content first and by the name second.
///
/// f(x) = Σ wₖ vₖ W(|x − xₖ| / Rₖ) / Rₖ³ (see [`PointSet`]) needs a radius, a weight and a value for each point. They are the file's where
/// it has them, found by the usual names of columns or by those that options give, and otherwise assumed, which the notes tell:
///
/// | | the first that there is |
/// |---|---|
/// | radius R | [`PointOptions::radius`]; column radius; 2 smoothing lengths; 2.4 (mass / density)^(1/3); the distance of the 58th neighbour |
/// | weight w | column weight; mass / density; with a value, the volume (R / 2.4)³; mass; (R / 2.4)³ density; 1 |
/// | value v | the column that is chosen or has a usual name; 1 |
///
/// With [`PointOptions::mixing`] set to the mean, weights are divided out. With [`PointOptions::color_value`], points have colours.
///
/// So the field follows the values where there are any, and is the density of mass, or of points, where there are none. Radii of 2.4 mean
/// distances hold 58 points each (Price 2012, "Smoothed particle hydrodynamics and magnetohydrodynamics").
///
/// # Errors
/// A [`FileError`] that names the file, the line or point and the column, what was found and what is allowed. Points that make no
/// sense are refused, not left out.
pub fn read_points(path: impl AsRef<Path>, options: &PointOptions) -> Result<LoadedPoints, FileError> {
    let path = path.as_ref();
    let unrecognised = || FileError::new(path, FileErrorKind::Unrecognised { supported: SUPPORTED });
    let head = file_head(path).map_err(|e| FileError::new(path, e))?;
    match detect(path, &head) {
        Ok(Format::Points(format)) => read_as(format, path, options),
        _ => Err(unrecognised()),
    }
}

/// The formats of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PointFormat {
    Delimited,
    Npy,
    VtkLegacy,
    VtkXml,
    Hdf5,
}

/// The format of points that the beginning of a file shows.
pub(crate) fn by_content(head: &[u8]) -> Option<PointFormat> {
    if crate::npy::is_npy(head) {
        Some(PointFormat::Npy)
    } else if head.starts_with(b"\x89HDF\r\n\x1a\n") {
        Some(PointFormat::Hdf5)
    } else {
        match vtk::content(head)? {
            Content::Legacy(kind) => vtk_legacy::DATA_SETS.contains(&kind.as_str()).then_some(PointFormat::VtkLegacy),
            Content::Xml(kind) => vtk_xml::KINDS.contains(&kind.as_str()).then_some(PointFormat::VtkXml),
        }
    }
}

/// The format of points that the end of a name tells, in lower case.
pub(crate) fn by_extension(extension: &str) -> Option<PointFormat> {
    Some(match extension {
        "csv" | "tsv" | "txt" => PointFormat::Delimited,
        "npy" => PointFormat::Npy,
        "vtp" | "vtu" => PointFormat::VtkXml,
        _ => return None,
    })
}

/// Longest list of points, which is taken into memory as a whole: a thousand million of them in binary.
const MAX_BYTES: u64 = 1 << 34;

/// Reads points of a known format.
pub(crate) fn read_as(format: PointFormat, path: &Path, options: &PointOptions) -> Result<LoadedPoints, FileError> {
    let in_file = |kind| FileError::new(path, kind);
    options.validate().map_err(|e| FileErrorKind::field(e.field, e.found, e.allowed)).map_err(in_file)?;
    if format != PointFormat::Delimited && options.columns.position.is_some() {
        let allowed = "the format itself tells which numbers are positions; only text has a choice";
        return Err(in_file(FileErrorKind::field("columns.position", "names", allowed)));
    }
    let bytes = || regular_file::read(path, MAX_BYTES).map_err(|e| FileError::new(path, e));
    let found = match format {
        PointFormat::Delimited => delimited::read(&bytes()?, options),
        PointFormat::Npy => npy::read(&bytes()?),
        PointFormat::VtkLegacy => vtk_legacy::read(path, options),
        PointFormat::VtkXml => vtk_xml::read(path, options),
        #[cfg(feature = "hdf5")]
        PointFormat::Hdf5 => hdf5::read(path, options),
        #[cfg(not(feature = "hdf5"))]
        PointFormat::Hdf5 => {
            return Err(in_file(FileErrorKind::Feature { format: "HDF5", feature: "hdf5" }));
        }
    };
    let Found { table, format, encoding, scalar, endian, names, mut notes } = found.map_err(in_file)?;
    let points = assemble::assemble(table, options, &mut notes).map_err(in_file)?;
    let facts = Facts { format, encoding, scalar, endian, frames: 1, files: vec![path.into()] };
    let info = facts.into_info("positions", 1, names);
    Ok(LoadedPoints { points, info, notes: as_lines(notes) })
}

/// The columns of a file, before they are made points.
struct Found {
    table: Table,
    format: &'static str,
    encoding: &'static str,
    /// The type of the positions.
    scalar: ScalarType,
    endian: Endian,
    /// All columns that could be chosen.
    names: Vec<String>,
    notes: Vec<String>,
}

/// Positions, and the columns that have a role: as long as the positions.
struct Table {
    positions: Vec<DVec3>,
    columns: Roles<Column>,
    numbering: Numbering,
}

/// Naming of points in messages.
enum Numbering {
    FromZero,
    /// Lines of the file, from 1.
    Lines(Vec<u64>),
    /// Numbers in the file, where some points were left out.
    #[cfg_attr(not(feature = "hdf5"), expect(dead_code, reason = "only HDF5 leaves points out"))]
    Points(Vec<usize>),
}

impl Numbering {
    fn name(&self, k: usize) -> String {
        match self {
            Self::Lines(lines) => format!("line {}", lines[k]),
            Self::Points(points) => format!("point {}", points[k]),
            Self::FromZero => format!("point {k}"),
        }
    }
}

/// A number for each point.
#[derive(Clone, Debug, Default, PartialEq)]
struct Column {
    name: String,
    numbers: Vec<f64>,
}
