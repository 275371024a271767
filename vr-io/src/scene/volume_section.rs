//! `[volume]`: where a volume comes from. On the wire a flat list of keys; here, for each source, those that mean something to it.

use std::sync::LazyLock;

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use vr_core::resample::ResampleFilter;
use vr_core::transfer::ColorMap;
use vr_core::{Calibration, Filter, GridError, ParameterError, Placement, PointKernel, PointMixing, phantom};

use crate::cells::CellsOrPoints;
use crate::nifti::Transform;
use crate::points::{PointColumns, PointOptions};
use crate::scalar::{Endian, ScalarType};
use crate::toml_table::table_of;

use super::error::unknown_name;
use super::file_name::FileName;
use super::resample_section::{ResampleSection, ResampleSize};

/// `[volume]`: a source, and the filter that makes the field of a grid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Keys", into = "Keys")]
pub struct VolumeSection {
    /// Source of the volume; a file without one describes a scene only once a volume is put into it.
    pub source: Option<VolumeSource>,
    /// The filter; absent: trilinear, or nearest where the automatic look finds labels.
    pub filter: Option<Filter>,
    /// Resampling of a volume that is no grid.
    pub resample: Option<ResampleSection>,
}

/// Source of a volume, with the keys that mean something to it.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "a scene file has one")]
pub enum VolumeSource {
    /// A file.
    File(FileSource),
    /// A phantom that is sampled on a grid.
    Phantom {
        /// One of [`phantom::NAMES`].
        name: String,
        /// Voxels along each axis; 64 if absent.
        size: Option<usize>,
    },
    /// A phantom that is made of points.
    PhantomPoints {
        /// One of [`phantom::POINT_NAMES`].
        name: String,
        /// Number of points; 10 000 if absent.
        count: Option<usize>,
    },
    /// Voxels that stand in the scene file.
    Grid {
        /// The voxels, x fastest (`nan` where one is missing), up to 64³.
        data: Vec<f64>,
        /// The grid that they fill.
        grid: GridDescription,
    },
    /// Points that stand in the scene file.
    Points {
        /// x, y, z, radius, weight and value of each, up to 4096 of them.
        points: Vec<[f64; 6]>,
        /// Spread of each.
        kernel: Option<PointKernel>,
        /// Combination of values where supports overlap.
        mixing: Option<PointMixing>,
        /// Red, green and blue of each in linear light, where points have colours.
        colors: Option<Vec<[f64; 3]>>,
    },
}

/// A volume file, and the choices that it leaves open.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileSource {
    /// A path, relative to the scene file.
    pub path: FileName,
    /// Number of a frame of a series.
    pub frame: Option<usize>,
    /// Number of a component of several.
    pub component: Option<usize>,
    /// The way to take cells with vertices.
    pub cells_or_points: Option<CellsOrPoints>,
    /// UID or number of a DICOM series.
    pub series: Option<String>,
    /// Number of a resolution of an OME-Zarr image, 0 the finest.
    pub level: Option<usize>,
    /// The transform that places a NIfTI file.
    pub transform: Option<Transform>,
    /// Byte order of a raw file.
    pub endian: Option<Endian>,
    /// Bytes before the voxels of a raw file.
    pub skip: Option<u64>,
    /// The grid in a raw file.
    pub grid: GridDescription,
    /// Choices about scattered points; `value` also names the array of a grid whose file holds several.
    pub points: PointOptions,
}

/// Description of a grid whose voxels have no header: those of a raw file or of a scene file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GridDescription {
    /// Voxels along x, y, z.
    pub dims: Option<[usize; 3]>,
    /// Type of the voxels.
    pub scalar: Option<ScalarType>,
    /// World units between voxels; 1 if absent.
    pub spacing: Option<[f64; 3]>,
    /// World position of voxel (0, 0, 0); 0 if absent.
    pub origin: Option<[f64; 3]>,
    /// Directions of the x, y and z axis of the grid, one after the other.
    pub direction: Option<[[f64; 3]; 3]>,
    /// Calibration: value per stored unit.
    pub slope: Option<f64>,
    /// Calibration: value of stored 0.
    pub intercept: Option<f64>,
}

impl GridDescription {
    /// Returns spacing, origin and direction.
    ///
    /// # Errors
    /// Errors of [`Placement::oriented`].
    pub(super) fn placement(&self) -> Result<Placement, GridError> {
        let direction = self.direction.map_or(DMat3::IDENTITY, |d| DMat3::from_cols_array_2d(&d));
        let origin = DVec3::from(self.origin.unwrap_or_default());
        Placement::oriented(origin, self.spacing.unwrap_or([1.0; 3]), direction)
    }

    /// Returns slope and intercept.
    pub(super) fn calibration(&self) -> Calibration {
        Calibration { slope: self.slope.unwrap_or(1.0), intercept: self.intercept.unwrap_or(0.0) }
    }
}

impl VolumeSource {
    /// Returns the phantom of a name, of the usual size.
    ///
    /// # Errors
    /// A name that no phantom has.
    pub fn phantom(name: &str) -> Result<Self, ParameterError> {
        if phantom::POINT_NAMES.contains(&name) {
            Ok(Self::PhantomPoints { name: name.to_owned(), count: None })
        } else if phantom::NAMES.contains(&name) {
            Ok(Self::Phantom { name: name.to_owned(), size: None })
        } else {
            Err(unknown_phantom(name))
        }
    }

    /// Makes the complaint about a key of `[volume]` that means nothing to this source.
    pub fn refusal(&self, key: &str, found: impl std::fmt::Display) -> ParameterError {
        let allowed = match self {
            Self::File(_) => "a file has none; only phantoms do",
            Self::Phantom { .. } => "a phantom that is a grid has a size, and no other key",
            Self::PhantomPoints { .. } => "a phantom that is made of points has a count, and a kernel of its own",
            Self::Grid { .. } => {
                "voxels of a grid in a scene file have dims, type, spacing, origin, direction, slope and intercept"
            }
            Self::Points { .. } => {
                "points in a scene file have a kernel, a mixing and point_colors; only points from files have other keys"
            }
        };
        ParameterError { field: format!("volume.{key}"), found: found.to_string(), allowed }
    }
}

/// Makes the complaint about a phantom that there is not.
pub(super) fn unknown_phantom(name: &str) -> ParameterError {
    static ALLOWED: LazyLock<String> = LazyLock::new(|| {
        format!("must be {}, or, of points, {}", phantom::NAMES.join(", "), phantom::POINT_NAMES.join(" or "))
    });
    unknown_name("volume.phantom", name, &[phantom::NAMES, phantom::POINT_NAMES].concat(), &ALLOWED)
}

/// `[volume]` as it is written.
#[derive(Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Keys {
    path: Option<FileName>,
    phantom: Option<String>,
    size: Option<usize>,
    data: Option<Vec<f64>>,
    dims: Option<[usize; 3]>,
    #[serde(rename = "type")]
    scalar: Option<ScalarType>,
    endian: Option<Endian>,
    skip: Option<u64>,
    spacing: Option<[f64; 3]>,
    origin: Option<[f64; 3]>,
    direction: Option<[[f64; 3]; 3]>,
    slope: Option<f64>,
    intercept: Option<f64>,
    frame: Option<usize>,
    component: Option<usize>,
    #[serde(rename = "as")]
    cells_or_points: Option<CellsOrPoints>,
    series: Option<Series>,
    level: Option<usize>,
    transform: Option<Transform>,
    points: Option<Vec<[f64; 6]>>,
    count: Option<usize>,
    kernel: Option<PointKernel>,
    radius: Option<f64>,
    radius_scale: Option<f64>,
    value: Option<String>,
    mixing: Option<PointMixing>,
    point_colors: Option<Vec<[f64; 3]>>,
    color_value: Option<String>,
    color_map: Option<ColorMap>,
    color_range: Option<[f64; 2]>,
    columns: Option<PointColumns>,
    filter: Option<Filter>,
    resample: Option<ResampleSize>,
    resample_filter: Option<ResampleFilter>,
    conserve: Option<bool>,
}

/// UID or number of a series: text, or a number without quotes.
#[derive(Clone, Serialize, Deserialize)]
#[serde(untagged)]
enum Series {
    Text(String),
    Number(i64),
}

impl Series {
    fn into_text(self) -> String {
        match self {
            Self::Text(text) => text,
            Self::Number(number) => number.to_string(),
        }
    }
}

impl Keys {
    fn take_grid(&mut self) -> GridDescription {
        GridDescription {
            dims: self.dims.take(),
            scalar: self.scalar.take(),
            spacing: self.spacing.take(),
            origin: self.origin.take(),
            direction: self.direction.take(),
            slope: self.slope.take(),
            intercept: self.intercept.take(),
        }
    }

    fn put_grid(&mut self, grid: GridDescription) {
        let GridDescription { dims, scalar, spacing, origin, direction, slope, intercept } = grid;
        *self = Self { dims, scalar, spacing, origin, direction, slope, intercept, ..std::mem::take(self) };
    }
}

impl TryFrom<Keys> for VolumeSection {
    type Error = ParameterError;

    fn try_from(mut keys: Keys) -> Result<Self, ParameterError> {
        let wrong = |found: &str, allowed| ParameterError { field: "volume".into(), found: found.into(), allowed };
        let filter = keys.filter.take();
        let choices = (keys.resample_filter.take(), keys.conserve.take());
        let resample = match (keys.resample.take(), choices) {
            (Some(size), (filter, conserve)) => Some(ResampleSection {
                size,
                filter: filter.unwrap_or_default(),
                conserve: conserve.unwrap_or_default(),
            }),
            (None, (None, None)) => None,
            (None, _) => {
                return Err(wrong(
                    "resample_filter or conserve alone",
                    "must go with resample, which says to what size",
                ));
            }
        };
        let source = match (keys.path.take(), keys.phantom.take(), keys.data.take(), keys.points.take()) {
            (Some(path), None, None, None) => Some(VolumeSource::File(FileSource {
                path,
                frame: keys.frame.take(),
                component: keys.component.take(),
                cells_or_points: keys.cells_or_points.take(),
                series: keys.series.take().map(Series::into_text),
                level: keys.level.take(),
                transform: keys.transform.take(),
                endian: keys.endian.take(),
                skip: keys.skip.take(),
                grid: keys.take_grid(),
                points: PointOptions {
                    kernel: keys.kernel.take(),
                    radius: keys.radius.take(),
                    radius_scale: keys.radius_scale.take(),
                    value: keys.value.take(),
                    mixing: keys.mixing.take(),
                    color_value: keys.color_value.take(),
                    color_map: keys.color_map.take(),
                    color_range: keys.color_range.take(),
                    columns: keys.columns.take().unwrap_or_default(),
                },
            })),
            (None, Some(name), None, None) => {
                let mut source = VolumeSource::phantom(&name)?;
                match &mut source {
                    VolumeSource::PhantomPoints { count, .. } => *count = keys.count.take(),
                    VolumeSource::Phantom { size, .. } => *size = keys.size.take(),
                    _ => {}
                }
                Some(source)
            }
            (None, None, Some(data), None) => Some(VolumeSource::Grid { data, grid: keys.take_grid() }),
            (None, None, None, Some(points)) => Some(VolumeSource::Points {
                points,
                kernel: keys.kernel.take(),
                mixing: keys.mixing.take(),
                colors: keys.point_colors.take(),
            }),
            (None, None, None, None) => None,
            _ => return Err(wrong("several of path, phantom, data and points", "must have one of them")),
        };
        // What nothing has taken means nothing here.
        let left = table_of(&keys).unwrap_or_default();
        match (source, left.iter().next()) {
            (source, None) => Ok(Self { source, filter, resample }),
            (Some(source), Some((key, value))) => Err(source.refusal(key, value)),
            (None, Some((key, _))) => Err(wrong(&format!("{key} alone"), NO_SOURCE)),
        }
    }
}

/// Sources that a section may have.
pub(super) const NO_SOURCE: &str = "must have a path, a phantom, data or points";

impl From<VolumeSection> for Keys {
    fn from(VolumeSection { source, filter, resample }: VolumeSection) -> Self {
        let mut keys = Self { filter, ..Self::default() };
        if let Some(ResampleSection { size, filter, conserve }) = resample {
            keys.resample = Some(size);
            keys.resample_filter = (filter != ResampleFilter::default()).then_some(filter);
            keys.conserve = conserve.then_some(true);
        }
        match source {
            Some(VolumeSource::File(file)) => {
                let FileSource {
                    path,
                    frame,
                    component,
                    cells_or_points,
                    series,
                    level,
                    transform,
                    endian,
                    skip,
                    grid,
                    points,
                } = file;
                let PointOptions {
                    kernel,
                    radius,
                    radius_scale,
                    value,
                    mixing,
                    color_value,
                    color_map,
                    color_range,
                    columns,
                } = points;
                keys.put_grid(grid);
                keys = Self {
                    path: Some(path),
                    columns: (!columns.is_empty()).then_some(columns),
                    series: series.map(Series::Text),
                    ..Self {
                        frame,
                        component,
                        cells_or_points,
                        level,
                        transform,
                        endian,
                        skip,
                        kernel,
                        radius,
                        radius_scale,
                        value,
                        mixing,
                        color_value,
                        color_map,
                        color_range,
                        ..keys
                    }
                };
            }
            Some(VolumeSource::Phantom { name, size }) => (keys.phantom, keys.size) = (Some(name), size),
            Some(VolumeSource::PhantomPoints { name, count }) => (keys.phantom, keys.count) = (Some(name), count),
            Some(VolumeSource::Grid { data, grid }) => {
                keys.put_grid(grid);
                keys.data = Some(data);
            }
            Some(VolumeSource::Points { points, kernel, mixing, colors }) => {
                keys = Self { points: Some(points), kernel, mixing, point_colors: colors, ..keys };
            }
            None => {}
        }
        keys
    }
}
