//! Volumes of Voreen, <https://voreen.uni-muenster.de>: a raw file, and a header in XML (`.vvd`, since version 3) or in lines of text
//! (`.dat`). There is no page on either; the names are those that its readers know.

mod dat;
mod vvd;

pub(crate) use dat::{describe as describe_dat, is_dat};
pub(crate) use vvd::{describe as describe_vvd, is_vvd};

use std::path::Path;

use glam::DMat4;
use glam::{DMat3, DVec3};
use vr_core::Placement;

use crate::encoding::Encoding;
use crate::error::FileError;
use crate::payload::{Payload, Segment, Skip};
use crate::read::file_head;
use crate::scalar::{Endian, ScalarType};
use crate::world::Space;

/// A raw file beside a header.
fn raw(data: &Path, scalar: ScalarType, notes: &mut Vec<String>) -> Payload {
    if scalar.bytes() > 1 {
        notes.push("Voreen's headers state no byte order: little-endian is assumed".into());
    }
    // A file that is not there is named when it is opened.
    let encoding = file_head(data).map_or(Encoding::Raw, |head| Encoding::of_file(&head));
    Payload {
        segments: vec![Segment { path: data.into(), start: 0, lines: 0, skip: Skip::Bytes(0) }],
        encoding,
        scalar,
        endian: Endian::Little,
        // Nothing else shows that the header describes its data.
        excess_is_error: true,
        hint: " (are sizes and format right?)",
    }
}

/// Placement of a grid that a matrix turns and moves.
fn place(path: &Path, offset: DVec3, spacing: DVec3, matrix: DMat4) -> Result<Placement, FileError> {
    let axes = DMat3::from_mat4(matrix) * DMat3::from_diagonal(spacing);
    Space::Own.place(matrix.transform_point3(offset), axes).map_err(|e| FileError::new(path, e))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::error::FileError;
    use crate::read::{Description, ReadOptions};
    use crate::voxels::Voxels;

    /// Describes a file and loads its voxels, which are of type u16.
    pub fn described_and_loaded(
        describe: fn(&Path, &ReadOptions) -> Result<Description, FileError>,
        path: &Path,
    ) -> Result<(Description, Vec<u16>), String> {
        let options = ReadOptions { map: false, ..ReadOptions::default() };
        let described = || describe(path, &options).map_err(|e| e.to_string());
        let Description { source, layout, mut notes, .. } = described()?;
        let voxels = source.load(path, &layout, &options, &mut notes).map_err(|e| e.to_string())?;
        let Voxels::U16(found) = voxels else { panic!("u16") };
        Ok((described()?, found.as_ref().to_vec()))
    }
}
