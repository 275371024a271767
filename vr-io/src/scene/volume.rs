//! Conversion of a `[volume]` section to the volume that it describes: a file, a phantom, or data in the section itself.

use std::path::Path;

use vr_core::{ControlPoint, Filter, ParameterError, Volume, memory, phantom};

use crate::error::FileError;
use crate::given_place::GivenPlace;
use crate::points::{BYTES_PER_POINT, PointOptions};
use crate::raw::RawDescription;
use crate::read::{FileInfo, Loaded, ReadOptions, has_unread_voxels, missing_voxels, outline, read};
use crate::toml_table::table_of;

use super::error::SceneFileError;
use super::inline;
use super::volume_section::{FileSource, GridDescription, NO_SOURCE, VolumeSection, VolumeSource, unknown_phantom};

/// The volume of a scene file.
#[derive(Clone, Debug)]
pub struct LoadedVolume {
    /// The volume.
    pub volume: Volume,
    /// Everything that its file says, where there is one.
    pub info: Option<FileInfo>,
    /// A phantom's own transfer function, and the unit distance in world units that it is for.
    pub transfer: Option<(Vec<ControlPoint>, f64)>,
    /// Notes on everything assumed, one line each.
    pub notes: Vec<String>,
}

/// Makes the volume that a `[volume]` section describes. Paths in it are relative to the folder of `path`, which is also what errors
/// call it; it may be empty for a section from no file.
///
/// # Errors
/// A [`SceneFileError`] naming the file and the field.
pub fn load_volume(section: &VolumeSection, path: &Path) -> Result<LoadedVolume, SceneFileError> {
    let loaded = volume_of(section, path, |path, options| read(path, options).map(Some))?;
    Ok(loaded.expect("every file that is read is a volume"))
}

/// A stand-in for a large volume from a file, made of the header alone ([`outline`]); `None` where there is no such file.
pub(super) fn outline_volume(section: &VolumeSection, path: &Path) -> Result<Option<LoadedVolume>, SceneFileError> {
    match section.source {
        Some(VolumeSource::File(_)) => volume_of(section, path, |path, options| outline(path, options)),
        _ => Ok(None),
    }
}

/// The volume of a section, whose file is read by `read`; `None` where that gives none.
fn volume_of(
    section: &VolumeSection,
    path: &Path,
    read: impl Fn(&Path, &ReadOptions) -> Result<Option<Loaded>, FileError>,
) -> Result<Option<LoadedVolume>, SceneFileError> {
    let in_file = |source| SceneFileError::Parameter { path: path.into(), source };
    let in_memory =
        |what, bytes| memory::check(what, bytes).map_err(|source| SceneFileError::Memory { path: path.into(), source });
    let made = |volume: Volume, transfer| LoadedVolume { volume, info: None, transfer, notes: Vec::new() };
    let mut loaded = match &section.source {
        None => return Err(in_file(wrong("volume", "nothing", NO_SOURCE))),
        Some(VolumeSource::File(file)) => {
            let path = path.parent().unwrap_or(Path::new("")).join(&file.path);
            match from_file(file, &path, read, in_file)? {
                Some(loaded) => loaded,
                None => return Ok(None),
            }
        }
        Some(VolumeSource::Phantom { name, size }) => {
            let voxels = (size.unwrap_or(PHANTOM_SIZE) as u64).saturating_pow(3);
            in_memory("the phantom", voxels.saturating_mul(size_of::<f32>() as u64))?;
            let (volume, transfer) = sampled_phantom(name, size.unwrap_or(PHANTOM_SIZE)).map_err(in_file)?;
            made(volume, Some(transfer))
        }
        Some(VolumeSource::PhantomPoints { name, count }) => {
            in_memory("the phantom", (count.unwrap_or(PHANTOM_POINTS) as u64).saturating_mul(BYTES_PER_POINT))?;
            let volume = phantom_of_points(name, count.unwrap_or(PHANTOM_POINTS)).map_err(in_file)?;
            made(volume, phantom::point_transfer_function(name))
        }
        Some(VolumeSource::Grid { data, grid }) => made(inline::grid(data, grid).map_err(in_file)?, None),
        Some(VolumeSource::Points { points, kernel, mixing, colors }) => {
            let (kernel, mixing) = (kernel.unwrap_or_default(), mixing.unwrap_or_default());
            made(inline::points(points, kernel, mixing, colors.as_deref()).map_err(in_file)?, None)
        }
    };
    if let Some(resample) = &section.resample {
        let (volume, notes) = resample.apply(&loaded.volume).map_err(in_file)?;
        loaded.volume = volume;
        loaded.notes.extend(notes);
    }
    if loaded.volume.filter().is_none()
        && let Some(filter) = section.filter
        && filter != Filter::default()
    {
        let allowed = "only grids have a filter; points have a kernel, and meshes are linear in each cell";
        return Err(in_file(wrong("volume.filter", filter.name(), allowed)));
    }
    Ok(Some(loaded))
}

fn wrong(field: &str, found: &str, allowed: &'static str) -> ParameterError {
    ParameterError { field: field.into(), found: found.into(), allowed }
}

fn from_file(
    file: &FileSource,
    path: &Path,
    read: impl Fn(&Path, &ReadOptions) -> Result<Option<Loaded>, FileError>,
    in_file: impl Fn(ParameterError) -> SceneFileError + Copy,
) -> Result<Option<LoadedVolume>, SceneFileError> {
    file.points.validate().map_err(in_file)?;
    let (raw, place) = grid_description(file, path).map_err(in_file)?;
    let options = ReadOptions {
        frame: file.frame,
        component: file.component,
        cells_or_points: file.cells_or_points,
        array: file.points.value.clone(),
        series: file.series.clone(),
        level: file.level,
        transform: file.transform.unwrap_or_default(),
        place,
        raw,
        points: file.points.clone(),
        ..ReadOptions::default()
    };
    let Some(loaded) = read(path, &options)? else { return Ok(None) };
    if file.transform.is_some() && !loaded.info.format.starts_with("NIfTI") {
        return Err(in_file(wrong("volume.transform", loaded.info.format, "only NIfTI files have a choice")));
    }
    // The array of a grid has its name from the same key.
    let choices_of_points = PointOptions { value: None, ..file.points.clone() };
    if let (Volume::Grid(_) | Volume::Color(_) | Volume::Rectilinear(_) | Volume::Amr(_), Some((key, found))) =
        (&loaded.volume, first_key(&choices_of_points))
    {
        let allowed = "only scattered points have one; this is a grid";
        return Err(in_file(wrong(&format!("volume.{key}"), &found.to_string(), allowed)));
    }
    if let (Volume::Cells(_), Some((key, found))) = (&loaded.volume, first_key(&choices_of_points)) {
        let allowed =
            "only scattered points have one; this is a mesh of cells, whose vertices as = \"points\" takes alone";
        return Err(in_file(wrong(&format!("volume.{key}"), &found.to_string(), allowed)));
    }
    if let (Volume::Amr(_), Some((key, found))) = (&loaded.volume, first_key(&choices_of_points)) {
        let allowed = "only scattered points have one; this is an adaptive mesh";
        return Err(in_file(wrong(&format!("volume.{key}"), &found.to_string(), allowed)));
    }
    let Loaded { volume, info, mut notes } = loaded;
    // What is drawn or described is read in any case.
    if has_unread_voxels(&volume, info.mapped) {
        notes.extend(missing_voxels(&volume));
    }
    Ok(Some(LoadedVolume { volume, info: Some(info), transfer: None, notes }))
}

/// Returns one of the keys that are set.
fn first_key(options: &PointOptions) -> Option<(String, toml::Value)> {
    table_of(options).unwrap_or_default().into_iter().next()
}

fn sampled_phantom(name: &str, size: usize) -> Result<(Volume, (Vec<ControlPoint>, f64)), ParameterError> {
    let phantom = phantom::by_name(name).ok_or_else(|| unknown_phantom(name))?;
    let allowed = "must be 2 to 2048";
    if !PHANTOM_SIZES.contains(&size) {
        return Err(wrong("volume.size", &size.to_string(), allowed));
    }
    let grid = phantom::sample::<f32>(phantom.as_ref(), [size; 3])
        .map_err(|e| wrong("volume.size", &e.to_string(), allowed))?;
    Ok((grid.into(), (phantom.transfer_points(), phantom::TRANSFER_UNIT_DISTANCE)))
}

fn phantom_of_points(name: &str, count: usize) -> Result<Volume, ParameterError> {
    if !PHANTOM_COUNTS.contains(&count) {
        return Err(wrong("volume.count", &count.to_string(), "must be 1 to 100000000"));
    }
    phantom::points_by_name(name, count).map(Volume::from).ok_or_else(|| unknown_phantom(name))
}

/// Voxels along each axis of a phantom of which no size is given.
const PHANTOM_SIZE: usize = 64;
/// The sizes that a phantom may have; the largest takes 32 GiB.
const PHANTOM_SIZES: std::ops::RangeInclusive<usize> = 2..=2048;

/// Points of a phantom of which no count is given.
const PHANTOM_POINTS: usize = 10_000;
/// The counts that a phantom of points may have; the largest takes some 4 GiB.
const PHANTOM_COUNTS: std::ops::RangeInclusive<usize> = 1..=100_000_000;

/// The description of a raw file: dims and type from the section or, where it has none, from the file's name. `None` where
/// the section describes none, so that the file must; spacing and origin are then in place of the file's.
fn grid_description(file: &FileSource, path: &Path) -> Result<(Option<RawDescription>, GivenPlace), ParameterError> {
    let FileSource { endian, skip, grid, .. } = file;
    let place = GivenPlace { spacing: grid.spacing, origin: grid.origin };
    let is_place_alone = GridDescription { spacing: None, origin: None, ..grid.clone() } == GridDescription::default();
    if is_place_alone && endian.is_none() && skip.is_none() {
        return Ok((None, place));
    }
    let named = RawDescription::from_name(path).and_then(Result::ok);
    let dims = grid.dims.or(named.as_ref().map(|n| n.dims)).ok_or_else(|| {
        let allowed = "type, endian, skip, direction, slope and intercept are for raw files, which need dims";
        wrong("volume.dims", "nothing", allowed)
    })?;
    let scalar = grid.scalar.or(named.map(|n| n.scalar));
    let scalar = scalar.ok_or_else(|| wrong("volume.type", "nothing", "raw files need a type"))?;
    let plain = RawDescription::new(dims, scalar);
    let description = RawDescription {
        endian: endian.unwrap_or_default(),
        spacing: grid.spacing,
        origin: grid.origin.unwrap_or(plain.origin),
        direction: grid.direction.unwrap_or(plain.direction),
        skip: skip.unwrap_or(0),
        calibration: grid.calibration(),
        ..plain
    };
    Ok((Some(description), GivenPlace::default()))
}
