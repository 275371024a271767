//! Volumes as files without a header, and the flags that read them back.

use glam::{DMat3, DVec3};

use crate::atomic::write_whole;
use crate::error::WriteError;
use crate::raw::RawDescription;
use crate::scalar::ScalarType;

use super::{Job, refused, shape};

pub(super) fn write(job: &mut Job<'_>) -> Result<ScalarType, WriteError> {
    let numbers = job.values("a raw file");
    let (dims, scalar, placement) = (job.grid.dims(), numbers.scalar(), job.grid.placement());
    let [nx, ny, nz] = dims;
    let is_named = match RawDescription::from_name(job.path) {
        Some(Ok(named)) if named != RawDescription::new(dims, scalar) => {
            let message = format!(
                "the name says {:?} voxels of {}; these are {dims:?} of {scalar}: name it ..._{nx}x{ny}x{nz}_{scalar}.raw",
                named.dims, named.scalar
            );
            return Err(refused(job.path, message));
        }
        Some(Ok(_)) => true,
        _ => false,
    };
    let spaced = placement.spacing() != DVec3::ONE || placement.origin() != DVec3::ZERO;
    if !is_named || spaced {
        let mut flags = format!("--dims {nx}x{ny}x{nz} --type {scalar}");
        let list = |v: DVec3| shape::vector(v).replace(' ', ",");
        if spaced {
            flags += &format!(" --spacing {} --origin {}", list(placement.spacing()), list(placement.origin()));
        }
        job.notes.push(format!("a raw file says nothing of itself: {flags} reads it"));
    }
    if placement.axes() != DMat3::from_diagonal(placement.spacing()) {
        job.notes.push("a raw file holds no orientation: it is lost".into());
    }
    write_whole(job.path, |mut out| {
        numbers.write(&mut out).map_err(|source| WriteError::Io { path: job.path.into(), source })
    })?;
    Ok(scalar)
}
