//! Volumes as NRRD files.

use std::fmt::Write as _;
use std::io;
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::DVec3;
use vr_core::{Calibration, GridVolume, Volume};

use crate::atomic::write_whole;
use crate::error::WriteError;
use crate::nrrd::{INTERCEPT_KEY, SLOPE_KEY};
use crate::scalar::ScalarType;
use crate::world::Space;

use super::numbers::Numbers;
use super::{Job, grid_of};

/// Options of an NRRD file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NrrdOptions {
    /// Packing of the voxels.
    pub encoding: NrrdEncoding,
    /// Numbers that are written.
    pub values: NrrdValues,
    /// Name of the world: [`Space::Ras`] for a volume that was read from a patient space, else [`Space::Own`].
    pub space: Space,
}

impl Default for NrrdOptions {
    /// gzip, calibrated values, the volume's own frame.
    fn default() -> Self {
        Self { encoding: NrrdEncoding::Gzip, values: NrrdValues::Calibrated, space: Space::Own }
    }
}

/// Packing of the voxels of an NRRD file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NrrdEncoding {
    /// Bytes as they are.
    Raw,
    /// Compressed.
    #[default]
    Gzip,
}

/// Numbers that go into an NRRD file, which has no field for a calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NrrdValues {
    /// Calibrated values: the stored numbers in their type where slope is 1 and intercept 0; else integers of 8 or 16 bits where all values
    /// are whole and fit, 32-bit floats, or 64-bit ones where 32 bits would lose digits. Every reader understands them.
    #[default]
    Calibrated,
    /// The stored numbers in their type; slope and intercept follow as keys, which [`crate::read()`] honours and others do not.
    Stored,
}

/// Writes a volume as an NRRD file.
///
/// # Errors
/// A [`WriteError`] naming the file, also for a volume that is no uniform grid; no part of it is left behind then.
pub fn write_nrrd(path: impl AsRef<Path>, volume: &Volume, options: &NrrdOptions) -> Result<(), WriteError> {
    let path = path.as_ref();
    write_grid(path, grid_of(path, volume)?, options).map(drop)
}

pub(super) fn write(job: &mut Job<'_>) -> Result<ScalarType, WriteError> {
    // Says what becomes of the calibration.
    job.values("NRRD");
    let space = if job.options.patient { Space::Ras } else { Space::Own };
    write_grid(job.path, job.grid, &NrrdOptions { space, ..NrrdOptions::default() })
}

fn write_grid(path: &Path, grid: &GridVolume, options: &NrrdOptions) -> Result<ScalarType, WriteError> {
    let failed = |source: io::Error| WriteError::Io { path: path.into(), source };
    let numbers = Numbers::new(grid, options.values == NrrdValues::Calibrated);
    let header = header(grid, options, numbers.scalar());
    write_whole(path, |mut out| {
        out.write_all(header.as_bytes()).map_err(failed)?;
        match options.encoding {
            NrrdEncoding::Raw => numbers.write(&mut out).map_err(failed),
            NrrdEncoding::Gzip => {
                let mut packed = GzEncoder::new(&mut out, Compression::default());
                numbers.write(&mut packed).map_err(failed)?;
                packed.finish().map(drop).map_err(failed)
            }
        }
    })?;
    Ok(numbers.scalar())
}

fn header(uniform: &GridVolume, options: &NrrdOptions, scalar: ScalarType) -> String {
    let type_name = match scalar {
        ScalarType::U8 => "uint8",
        ScalarType::I8 => "int8",
        ScalarType::U16 => "uint16",
        ScalarType::I16 => "int16",
        ScalarType::F64 => "double",
        _ => "float",
    };
    let space = match options.space {
        Space::Ras => "space: right-anterior-superior",
        Space::Las => "space: left-anterior-superior",
        Space::Lps => "space: left-posterior-superior",
        Space::Own => "space dimension: 3",
    };
    let encoding = match options.encoding {
        NrrdEncoding::Raw => "raw",
        NrrdEncoding::Gzip => "gzip",
    };
    let [nx, ny, nz] = uniform.dims();
    let placement = uniform.placement();
    // The world of a volume is RAS; another space is the same turn away in both directions.
    let vector = |v: DVec3| {
        let [x, y, z] = (options.space.to_ras() * v).to_array();
        format!("({x},{y},{z})")
    };
    let axes = placement.axes();
    let mut text = format!(
        "NRRD0004\ntype: {type_name}\ndimension: 3\n{space}\nsizes: {nx} {ny} {nz}\nspace directions: {} {} {}\n\
         space origin: {}\nkinds: domain domain domain\nencoding: {encoding}\n",
        vector(axes.x_axis),
        vector(axes.y_axis),
        vector(axes.z_axis),
        vector(placement.origin()),
    );
    if scalar.bytes() > 1 {
        text.push_str("endian: little\n");
    }
    let Calibration { slope, intercept } = uniform.calibration();
    if options.values == NrrdValues::Stored && (slope, intercept) != (1.0, 0.0) {
        // Writing into a string cannot fail.
        let _ = write!(text, "{SLOPE_KEY}:={slope}\n{INTERCEPT_KEY}:={intercept}\n");
    }
    text.push('\n');
    text
}
