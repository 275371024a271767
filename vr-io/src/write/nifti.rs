//! Volumes as NIfTI-1 files: <https://nifti.nimh.nih.gov/nifti-1>.

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::{DMat3, DQuat};
use vr_core::{Calibration, GridVolume, Placement};

use crate::atomic::write_whole;
use crate::error::WriteError;
use crate::scalar::ScalarType;

use super::numbers::Numbers;
use super::{Job, refused, shape};

/// Bytes of the header, and of the four flags behind it.
const VOX_OFFSET: usize = 352;
/// Largest error of values by a calibration in 32 bits, relative to their range; beyond it the values are written instead.
const MAX_CALIBRATION_ERROR: f64 = 1e-6;

pub(super) fn write(job: &mut Job<'_>, gzip: bool) -> Result<ScalarType, WriteError> {
    let (path, grid) = (job.path, job.grid);
    if grid.dims().iter().any(|&n| n > i16::MAX as usize) {
        let message =
            format!("dims {:?}: NIfTI-1 holds at most 32767 voxels along an axis; .nrrd holds more", grid.dims());
        return Err(refused(path, message));
    }
    let error = calibration_error(grid);
    let (numbers, calibration) = if error <= MAX_CALIBRATION_ERROR {
        if error > 0.0 {
            let range = error * 100.0;
            job.notes.push(format!(
                "NIfTI-1 holds slope and intercept in 32 bits: values are off by up to {range:.1e} % of their range"
            ));
        }
        (Numbers::stored(grid), grid.calibration())
    } else {
        (job.values("NIfTI-1, which holds slope and intercept in 32 bits,"), Calibration::default())
    };
    let header = header(job, numbers.scalar(), calibration);
    let failed = |source: io::Error| WriteError::Io { path: path.into(), source };
    write_whole(path, |mut out| {
        if gzip {
            let mut packed = GzEncoder::new(&mut out, Compression::default());
            packed.write_all(&header).and_then(|()| numbers.write(&mut packed)).map_err(failed)?;
            packed.finish().map(drop).map_err(failed)
        } else {
            out.write_all(&header).and_then(|()| numbers.write(&mut out)).map_err(failed)
        }
    })?;
    Ok(numbers.scalar())
}

/// Largest error of a value by a calibration in 32 bits, relative to the range of values.
fn calibration_error(grid: &GridVolume) -> f64 {
    let exact = grid.calibration();
    let held = Calibration { slope: f64::from(exact.slope as f32), intercept: f64::from(exact.intercept as f32) };
    if held == exact {
        return 0.0;
    }
    let Some((low, high)) = grid.value_stats().range.map(|(low, high)| (f64::from(low), f64::from(high))) else {
        return 0.0;
    };
    let at = |stored: f64| (held.value(stored) - exact.value(stored)).abs();
    let error = at(low).max(at(high)) / (exact.slope * (high - low)).abs();
    // A slope of 0 counts as none, and a constant has no range.
    if held.slope != 0.0 && error.is_finite() { error } else { f64::INFINITY }
}

fn header(job: &mut Job<'_>, scalar: ScalarType, calibration: Calibration) -> Vec<u8> {
    let mut header = vec![0; VOX_OFFSET];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    let datatype: i16 = match scalar {
        ScalarType::U8 => 2,
        ScalarType::I16 => 4,
        ScalarType::F32 => 16,
        ScalarType::I8 => 256,
        ScalarType::U16 => 512,
        _ => 64,
    };
    let [nx, ny, nz] = job.grid.dims().map(|n| n as i16);
    let placement = *job.grid.placement();
    let [dx, dy, dz] = placement.spacing().to_array().map(|s| s as f32);
    let codes = if job.options.patient { 1 } else { 2 };
    if !job.options.patient {
        job.notes.push(
            "NIfTI knows patients alone: the file's own frame is written as RAS, with the code 2 (aligned to something else)"
                .into(),
        );
    }

    put(0, &348i32.to_le_bytes());
    put(38, b"r");
    for (i, n) in [3, nx, ny, nz, 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * i, &n.to_le_bytes());
    }
    put(70, &datatype.to_le_bytes());
    put(72, &(8 * scalar.bytes() as i16).to_le_bytes());
    put(108, &(VOX_OFFSET as f32).to_le_bytes());
    put(112, &(calibration.slope as f32).to_le_bytes());
    put(116, &(calibration.intercept as f32).to_le_bytes());
    put(123, &[units(job)]);
    put(148, b"written by vr");
    put(344, b"n+1\0");

    // The sform holds every placement; the qform, spacing and a rotation.
    let (axes, origin) = (placement.axes().transpose(), placement.origin());
    for (row, at) in [(axes.x_axis, origin.x), (axes.y_axis, origin.y), (axes.z_axis, origin.z)]
        .iter()
        .enumerate()
        .map(|(i, &(row, origin))| ([row.x, row.y, row.z, origin], 280 + 16 * i))
    {
        for (i, x) in row.into_iter().enumerate() {
            put(at + 4 * i, &(x as f32).to_le_bytes());
        }
    }
    put(254, &i16::to_le_bytes(codes));
    let mut qfac = 1.0f32;
    if shape::shear(&placement).is_none() {
        let (quaternion, turned) = rotation(&placement);
        qfac = turned;
        put(252, &i16::to_le_bytes(codes));
        for (i, x) in quaternion.into_iter().chain(origin.to_array()).enumerate() {
            put(256 + 4 * i, &(x as f32).to_le_bytes());
        }
    } else {
        job.notes.push("the placement is sheared, which the sform alone holds: no qform is written".into());
    }
    for (i, x) in [qfac, dx, dy, dz].into_iter().enumerate() {
        put(76 + 4 * i, &x.to_le_bytes());
    }
    header
}

/// Quaternion b, c, d of a placement without shear, and qfac: −1 where the third axis is turned.
fn rotation(placement: &Placement) -> ([f64; 3], f32) {
    let mut d = shape::directions(placement);
    let qfac = if d.determinant() < 0.0 { -1.0 } else { 1.0 };
    d.z_axis *= f64::from(qfac);
    // Perpendicular to the last digit, as a rotation is.
    let (x, z) = (d.x_axis, d.x_axis.cross(d.y_axis).normalize());
    let q = DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z)).normalize();
    // The real part is not stored, and taken as positive.
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    ([sign * q.x, sign * q.y, sign * q.z], qfac)
}

/// Code of the unit of length.
fn units(job: &mut Job<'_>) -> u8 {
    match job.options.units.as_deref() {
        Some("m") => 1,
        Some("mm") => 2,
        Some("µm" | "um") => 3,
        None if job.options.patient => 2,
        None => 0,
        Some(other) => {
            job.notes.push(format!("NIfTI knows m, mm and µm: the unit {other} is not written"));
            0
        }
    }
}
