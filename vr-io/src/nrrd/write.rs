//! Volumes as NRRD files.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::DVec3;
use vr_core::{AnyGrid, Calibration, GridVolume, Volume, with_grid};

use crate::atomic::write_whole;
use crate::error::WriteError;
use crate::scalar::{Endian, ScalarType};
use crate::world::Space;

use super::{INTERCEPT_KEY, SLOPE_KEY};

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
    /// Calibrated values: the stored numbers in their type where slope is 1 and intercept 0, else 32-bit floats. Every
    /// reader understands them.
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
    let Some(uniform) = volume.grid() else {
        let message = format!("a {} is no NRRD: it must be a uniform grid", volume.kind());
        return Err(WriteError::Encode { path: path.into(), message });
    };
    let failed = |source: io::Error| WriteError::Io { path: path.into(), source };
    let as_floats = options.values == NrrdValues::Calibrated && uniform.calibration() != Calibration::default();
    let header = header(uniform, options, as_floats);
    write_whole(path, |mut out| {
        out.write_all(header.as_bytes()).map_err(failed)?;
        match options.encoding {
            NrrdEncoding::Raw => write_voxels(&mut out, uniform, as_floats).map_err(failed),
            NrrdEncoding::Gzip => {
                let mut packed = GzEncoder::new(&mut out, Compression::default());
                write_voxels(&mut packed, uniform, as_floats).map_err(failed)?;
                packed.finish().map_err(failed)?;
                Ok(())
            }
        }
    })
}

fn header(uniform: &GridVolume, options: &NrrdOptions, as_floats: bool) -> String {
    let scalar = if as_floats { ScalarType::F32 } else { uniform.voxel_type().into() };
    let type_name = match scalar {
        ScalarType::U8 => "uint8",
        ScalarType::I8 => "int8",
        ScalarType::U16 => "uint16",
        ScalarType::I16 => "int16",
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
        text.push_str(if Endian::NATIVE == Endian::Little { "endian: little\n" } else { "endian: big\n" });
    }
    let Calibration { slope, intercept } = uniform.calibration();
    if !as_floats && (slope, intercept) != (1.0, 0.0) {
        // Writing into a string cannot fail.
        let _ = write!(text, "{SLOPE_KEY}:={slope}\n{INTERCEPT_KEY}:={intercept}\n");
    }
    text.push('\n');
    text
}

/// Writes the voxels in the machine's byte order.
fn write_voxels(out: &mut impl Write, uniform: &GridVolume, as_floats: bool) -> io::Result<()> {
    if as_floats {
        let calibration = uniform.calibration();
        return with_grid!(uniform.values(), g => {
            g.samples().chunks(1 << 14).try_for_each(|chunk| {
                let values: Vec<f32> = chunk.iter().map(|&s| calibration.value(f64::from(s)) as f32).collect();
                out.write_all(bytemuck::cast_slice(&values))
            })
        });
    }
    match uniform.values() {
        AnyGrid::U8(g) => out.write_all(g.samples()),
        AnyGrid::I8(g) => out.write_all(bytemuck::cast_slice(g.samples())),
        AnyGrid::U16(g) => out.write_all(bytemuck::cast_slice(g.samples())),
        AnyGrid::I16(g) => out.write_all(bytemuck::cast_slice(g.samples())),
        AnyGrid::F32(g) => out.write_all(bytemuck::cast_slice(g.samples())),
    }
}
