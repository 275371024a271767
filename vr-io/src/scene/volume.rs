//! From a `[volume]` section to the volume that it describes: a file, a phantom, or what stands in the section itself.

use std::path::Path;

use vr_core::phantom;
use vr_core::scene_file::VolumeSection;
use vr_core::{ControlPoint, Filter, ParameterError, Volume};

use crate::nifti::Transform;
use crate::points::PointOptions;
use crate::raw::RawDescription;
use crate::read::{FileInfo, ReadOptions, read};
use crate::scalar::{Endian, ScalarType};

use super::error::{SceneFileError, nearest};

/// The volume of a scene file.
#[derive(Clone, Debug)]
pub struct LoadedVolume {
    /// The volume.
    pub volume: Volume,
    /// What its file said, where there is one.
    pub info: Option<FileInfo>,
    /// A phantom's own transfer function, and the unit distance in world units that it is for.
    pub transfer: Option<(Vec<ControlPoint>, f64)>,
    /// What was assumed, one line each.
    pub notes: Vec<String>,
}

/// The volume that a `[volume]` section describes. Paths in it are relative to the folder of `path`, which is also what errors
/// call it; it may be empty for a section from no file.
///
/// # Errors
/// A [`SceneFileError`] naming the file and the field.
pub fn load_volume(section: &VolumeSection, path: &Path) -> Result<LoadedVolume, SceneFileError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let in_file = |source| SceneFileError::Parameter { path: path.into(), source };
    let inline = |volume: Volume| LoadedVolume { volume, info: None, transfer: None, notes: Vec::new() };
    let loaded = match (&section.path, &section.phantom, &section.data, &section.points) {
        (Some(name), None, None, None) => from_file(section, &folder.join(name), in_file)?,
        (None, Some(name), None, None) => of_phantom(section, name).map_err(in_file)?,
        (None, None, Some(_), None) => inline(section.inline().map_err(in_file)?),
        (None, None, None, Some(_)) => inline(section.inline_points().map_err(in_file)?),
        (None, None, None, None) => {
            return Err(in_file(wrong("volume", "nothing", "must have a path, a phantom, data or points")));
        }
        _ => {
            return Err(in_file(wrong("volume", "several of path, phantom, data and points", "must have one of them")));
        }
    };
    check_keys(section, &loaded.volume).map_err(in_file)?;
    Ok(loaded)
}

fn wrong(field: &str, found: &str, allowed: &'static str) -> ParameterError {
    ParameterError { field: field.into(), found: found.into(), allowed }
}

fn from_file(
    section: &VolumeSection,
    path: &Path,
    in_file: impl Fn(ParameterError) -> SceneFileError + Copy,
) -> Result<LoadedVolume, SceneFileError> {
    let transform = section.transform.as_deref().unwrap_or(Transform::Auto.name());
    let points = PointOptions {
        kernel: section.kernel.unwrap_or_default(),
        radius: section.radius,
        radius_scale: section.radius_scale,
        value: section.value.clone(),
        columns: section.columns.clone().unwrap_or_default(),
    };
    points.validate().map_err(in_file)?;
    let options = ReadOptions {
        frame: section.frame,
        component: section.component,
        transform: transform.parse().map_err(|_| {
            in_file(wrong("volume.transform", &format!("'{transform}'"), "must be auto, sform, qform or spacing"))
        })?,
        raw: raw_description(section, path).map_err(in_file)?,
        points,
        ..ReadOptions::default()
    };
    let loaded = read(path, &options)?;
    if section.transform.is_some() && !loaded.info.format.starts_with("NIfTI") {
        return Err(in_file(wrong("volume.transform", loaded.info.format, "only NIfTI files have a choice")));
    }
    Ok(LoadedVolume { volume: loaded.volume, info: Some(loaded.info), transfer: None, notes: loaded.notes })
}

fn of_phantom(section: &VolumeSection, name: &str) -> Result<LoadedVolume, ParameterError> {
    if phantom::POINT_NAMES.contains(&name) {
        return phantom_of_points(section, name);
    }
    let phantom = phantom::by_name(name).ok_or_else(|| {
        let known = [phantom::NAMES, phantom::POINT_NAMES].concat();
        let near = nearest(name, &known).map_or_else(String::new, |n| format!(" (did you mean '{n}'?)"));
        wrong(
            "volume.phantom",
            &format!("'{name}'{near}"),
            "must be marschner-lobb, shepp-logan, blobs, shells, fog or hydrogen, or, of points, plummer or turbulence",
        )
    })?;
    let size = section.size.unwrap_or(PHANTOM_SIZE);
    let allowed = "must be 2 to 2048";
    if !PHANTOM_SIZES.contains(&size) {
        return Err(wrong("volume.size", &size.to_string(), allowed));
    }
    let grid = phantom::sample::<f32>(phantom.as_ref(), [size; 3])
        .map_err(|e| wrong("volume.size", &e.to_string(), allowed))?;
    let transfer = Some((phantom.transfer_points(), phantom::TRANSFER_UNIT_DISTANCE));
    Ok(LoadedVolume { volume: grid.into(), info: None, transfer, notes: Vec::new() })
}

fn phantom_of_points(section: &VolumeSection, name: &str) -> Result<LoadedVolume, ParameterError> {
    if let Some(size) = section.size {
        return Err(wrong("volume.size", &size.to_string(), "this phantom is made of points: it has a count"));
    }
    let count = section.count.unwrap_or(PHANTOM_POINTS);
    let points = phantom::points_by_name(name, count).filter(|_| PHANTOM_COUNTS.contains(&count));
    let points = points.ok_or_else(|| wrong("volume.count", &count.to_string(), "must be 1 to 100000000"))?;
    let transfer = phantom::point_transfer(name);
    Ok(LoadedVolume { volume: points.into(), info: None, transfer, notes: Vec::new() })
}

/// Refuses keys that say nothing about a volume of this kind, or from this place.
fn check_keys(section: &VolumeSection, volume: &Volume) -> Result<(), ParameterError> {
    match &volume {
        Volume::Points(_) => {
            if section.filter != Filter::default() {
                return Err(wrong(
                    "volume.filter",
                    section.filter.name(),
                    "only grids have a filter; points have a kernel",
                ));
            }
            let key = section.keys_of_points().find(|&key| match key {
                "volume.count" => section.phantom.is_none(),
                "volume.kernel" => section.phantom.is_some(),
                _ => section.path.is_none(),
            });
            match key {
                Some("volume.count") => Err(wrong("volume.count", "one", "only phantoms have one")),
                Some("volume.kernel") => Err(wrong("volume.kernel", "one", "a phantom has its own")),
                Some(key) => Err(wrong(key, "one", "only points from files have one")),
                None => Ok(()),
            }
        }
        _ => {
            let key = section.keys_of_points().next();
            key.map_or(Ok(()), |key| Err(wrong(key, "one", "only scattered points have one; this is a grid")))
        }
    }
}

/// Samples along each axis of a phantom of which no size is given.
const PHANTOM_SIZE: usize = 64;
/// The sizes that a phantom may have; the largest takes 32 GiB.
const PHANTOM_SIZES: std::ops::RangeInclusive<usize> = 2..=2048;

/// Points of a phantom of which no count is given.
const PHANTOM_POINTS: usize = 10_000;
/// The counts that a phantom of points may have; the largest takes some 4 GiB.
const PHANTOM_COUNTS: std::ops::RangeInclusive<usize> = 1..=100_000_000;

/// The description of a raw file: dims and type from the section or, where it has none, from the file's name. `None` where
/// the section describes nothing, so that the file must.
fn raw_description(section: &VolumeSection, path: &Path) -> Result<Option<RawDescription>, ParameterError> {
    let s = section;
    let described = s.dims.is_some() || s.voxel_type.is_some() || s.endian.is_some() || s.skip.is_some();
    let placed = s.spacing.is_some() || s.origin.is_some() || s.direction.is_some();
    let calibrated = s.slope.is_some() || s.intercept.is_some();
    if !described && !placed && !calibrated {
        return Ok(None);
    }
    let named = RawDescription::from_name(path).and_then(Result::ok);
    let missing = |field: &str, allowed| ParameterError { field: field.into(), found: "nothing".into(), allowed };
    let dims = s.dims.or(named.as_ref().map(|n| n.dims)).ok_or_else(|| {
        missing(
            "volume.dims",
            "type, endian, skip, spacing, origin, direction, slope and intercept are for raw files, which need dims",
        )
    })?;
    let scalar = match (&s.voxel_type, named) {
        (Some(name), _) => ScalarType::from_name(name).ok_or_else(|| {
            ParameterError::new("volume.type", name, "must be u8, i8, u16, i16, u32, i32, u64, i64, f32 or f64")
        })?,
        (None, Some(named)) => named.scalar,
        (None, None) => return Err(missing("volume.type", "raw files need a type")),
    };
    let endian = match s.endian.as_deref() {
        None | Some("little") => Endian::Little,
        Some("big") => Endian::Big,
        Some(other) => return Err(ParameterError::new("volume.endian", other, "must be little or big")),
    };
    let plain = RawDescription::new(dims, scalar);
    Ok(Some(RawDescription {
        endian,
        spacing: s.spacing,
        origin: s.origin.unwrap_or(plain.origin),
        direction: s.direction.unwrap_or(plain.direction),
        skip: s.skip.unwrap_or(0),
        calibration: s.calibration(),
        ..plain
    }))
}
