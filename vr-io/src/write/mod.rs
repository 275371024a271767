//! Volumes out, in the format that the file's name asks for.

mod folder;
mod levels;
mod metaimage;
mod nifti;
mod nrrd;
mod numbers;
mod raw;
mod shape;
mod slices;
mod vti;
mod zarr;

use std::path::{Path, PathBuf};

use vr_core::{Calibration, GridVolume, Volume};

use crate::error::WriteError;
use crate::read::FileInfo;
use crate::scalar::ScalarType;

pub use levels::Levels;
pub use nrrd::{NrrdEncoding, NrrdOptions, NrrdValues, write_nrrd};

use numbers::Numbers;
use slices::SliceFiles;

/// Options of writing a volume: what it does not say of itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WriteVolumeOptions {
    /// True if the volume's world is a patient's, in RAS, as for volumes whose file has a patient space.
    pub patient: bool,
    /// Unit of world positions. Millimetres are assumed of a patient.
    pub units: Option<String>,
    /// Resolutions, for a format that holds several.
    pub levels: Levels,
}

impl WriteVolumeOptions {
    /// Options for a volume of which a file said this.
    pub fn of_file(info: &FileInfo) -> Self {
        Self { patient: info.space.is_patient(), units: info.units.clone(), levels: Levels::default() }
    }
}

/// Description of a volume that was written.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct WrittenVolume {
    /// `NRRD`, `NIfTI-1`, `MetaImage`, `VTK ImageData`, `OME-Zarr`, `raw` or `PNG slices`.
    pub format: &'static str,
    /// Type of the numbers in the file.
    pub scalar: ScalarType,
    /// The files, a header first; of OME-Zarr the folder.
    pub files: Vec<PathBuf>,
    /// Notes on everything that the format does not hold, or holds otherwise, one line each.
    pub notes: Vec<String>,
}

/// Endings of names that [`write_volume`] knows, for messages.
const ENDINGS: &str = ".nrrd, .nii, .nii.gz, .mha, .mhd, .vti, .zarr, .raw, a pattern such as out_%03d.png, or a folder for PNG slices (out/)";

/// The format that a name asks for.
#[derive(Clone, Debug)]
enum Target {
    Nrrd,
    Nifti { gzip: bool },
    MetaImage { data: Option<PathBuf> },
    Vti,
    Zarr,
    Raw,
    Slices(SliceFiles),
}

impl Target {
    fn of(path: &Path, grid: &GridVolume) -> Result<Self, WriteError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        let ending = |ending: &str| name.strip_suffix(ending).is_some_and(|stem| !stem.is_empty());
        // Folders, too, but not of slices.
        if ending(".zarr") {
            return Ok(Self::Zarr);
        }
        if let Some(slices) = SliceFiles::of(path, grid.dims()[2])? {
            return Ok(Self::Slices(slices));
        }
        Ok(match () {
            () if ending(".nrrd") => Self::Nrrd,
            () if ending(".nii") => Self::Nifti { gzip: false },
            () if ending(".nii.gz") => Self::Nifti { gzip: true },
            () if ending(".mha") => Self::MetaImage { data: None },
            () if ending(".mhd") => Self::MetaImage { data: Some(metaimage::data_file(path)?) },
            () if ending(".vti") => Self::Vti,
            () if ending(".raw") => Self::Raw,
            () => return Err(refused(path, format!("no format of volumes that are written; name it {ENDINGS}"))),
        })
    }

    fn files(&self, path: &Path) -> Vec<PathBuf> {
        match self {
            Self::Slices(slices) => slices.files(),
            Self::MetaImage { data: Some(data) } => vec![path.into(), data.clone()],
            _ => vec![path.into()],
        }
    }
}

/// Everything that a format's writer needs.
struct Job<'a> {
    path: &'a Path,
    grid: &'a GridVolume,
    options: &'a WriteVolumeOptions,
    notes: Vec<String>,
}

impl<'a> Job<'a> {
    /// The calibrated values, for a format without a calibration that all readers honour; a note says so.
    fn values(&mut self, format: &str) -> Numbers<'a> {
        let numbers = Numbers::values(self.grid);
        let Calibration { slope, intercept } = self.grid.calibration();
        if self.grid.calibration() != Calibration::default() {
            let scalar = numbers.scalar();
            self.notes.push(format!(
                "{format} has no calibration that all readers honour: {slope} · stored + {intercept} is applied, the values are written as {scalar}"
            ));
        }
        numbers
    }
}

/// Writes a volume in the format that the name asks for: `.nrrd`, `.nii`, `.nii.gz`, `.mha`, `.mhd` with a `.raw` beside it, `.vti`, `.zarr`, `.raw`,
/// or PNG slices for a pattern such as `out_%03d.png`, an existing folder, or a name that ends with a separator.
///
/// Voxels, placement and calibration are kept as far as the format holds them, and the notes tell what it does not. A calibration that
/// a format does not hold is applied.
///
/// # Errors
/// A [`WriteError`] naming the file, also for a volume that is no uniform grid, for a name of another format, and for what the format
/// cannot hold and is no volume without; nothing is left behind then.
pub fn write_volume(
    path: impl AsRef<Path>,
    volume: &Volume,
    options: &WriteVolumeOptions,
) -> Result<WrittenVolume, WriteError> {
    let path = path.as_ref();
    let grid = grid_of(path, volume)?;
    let target = Target::of(path, grid)?;
    if let (Some(count), false) = (options.levels.count, matches!(target, Target::Zarr)) {
        return Err(refused(path, format!("levels: found {count}; only OME-Zarr (.zarr) holds several resolutions")));
    }
    let mut job = Job { path, grid, options, notes: Vec::new() };
    let (format, scalar) = match &target {
        Target::Nrrd => ("NRRD", nrrd::write(&mut job)?),
        Target::Nifti { gzip } => ("NIfTI-1", nifti::write(&mut job, *gzip)?),
        Target::MetaImage { data } => ("MetaImage", metaimage::write(&mut job, data.as_deref())?),
        Target::Vti => ("VTK ImageData", vti::write(&mut job)?),
        Target::Zarr => ("OME-Zarr", zarr::write(&mut job)?),
        Target::Raw => ("raw", raw::write(&mut job)?),
        Target::Slices(slices) => ("PNG slices", slices.write(&mut job)?),
    };
    Ok(WrittenVolume { format, scalar, files: target.files(path), notes: job.notes })
}

/// The files that [`write_volume`] writes for this name: what must not be read meanwhile.
///
/// # Errors
/// A [`WriteError`] for a volume that is no uniform grid, or a name of another format.
pub fn volume_files(path: impl AsRef<Path>, volume: &Volume) -> Result<Vec<PathBuf>, WriteError> {
    let path = path.as_ref();
    Ok(Target::of(path, grid_of(path, volume)?)?.files(path))
}

fn grid_of<'a>(path: &Path, volume: &'a Volume) -> Result<&'a GridVolume, WriteError> {
    let no_grid = || {
        let hint = if volume.colors().is_some() { ", such as one component of the colours" } else { "" };
        refused(path, format!("{} cannot be written as voxels: it must be a uniform grid{hint}", volume.kind()))
    };
    volume.grid().map(|grid| &**grid).ok_or_else(no_grid)
}

fn refused(path: &Path, message: impl Into<String>) -> WriteError {
    WriteError::Encode { path: path.into(), message: message.into() }
}
