//! Files without a header: described by the caller, or by their name.

use std::path::Path;

use glam::{DMat3, DVec3};
use vr_core::{Calibration, Placement};

use crate::encoding::Encoding;
use crate::error::{FieldError, FileError};
use crate::layout::{Axis, Layout, Role};
use crate::notes::{Assumption, Notes};
use crate::payload::{Payload, Segment, Skip};
use crate::read::{Description, ReadOptions};
use crate::scalar::{Endian, ScalarType};
use crate::world::Space;

/// Description of a file without a header.
#[derive(Clone, Debug, PartialEq)]
pub struct RawDescription {
    /// Voxels along x, y, z; x runs fastest.
    pub dims: [usize; 3],
    /// Type of the voxels.
    pub scalar: ScalarType,
    /// Byte order of the voxels.
    pub endian: Endian,
    /// World units between voxels; `None` counts as 1, and a note says so.
    pub spacing: Option<[f64; 3]>,
    /// World position of the first voxel.
    pub origin: [f64; 3],
    /// World directions of the x, y and z axis, one after the other; they need not be normalised.
    pub direction: [[f64; 3]; 3],
    /// Bytes before the first voxel, after decompression.
    pub skip: u64,
    /// Calibration from stored numbers to values.
    pub calibration: Calibration,
}

impl RawDescription {
    /// Describes little-endian voxels from the first byte on, spacing unknown, at the origin.
    pub fn new(dims: [usize; 3], scalar: ScalarType) -> Self {
        Self {
            dims,
            scalar,
            endian: Endian::Little,
            spacing: None,
            origin: [0.0; 3],
            direction: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            skip: 0,
            calibration: Calibration::default(),
        }
    }

    /// Reads a description from a file name, as in `foot_256x256x256_uint8.raw.gz`: `None` where it has no `NXxNYxNZ` in it.
    ///
    /// # Errors
    /// The name of the field that is missing or wrong.
    pub(crate) fn from_name(path: &Path) -> Option<Result<Self, FieldError>> {
        let name = &path.file_name()?.to_str()?.to_lowercase();
        let mut words = name.split(['_', '.', '-', ' ']).skip_while(|w| dims_of(w).is_none());
        let dims = dims_of(words.next()?)?;
        Some(match words.find_map(ScalarType::from_name) {
            Some(scalar) => Ok(Self::new(dims, scalar)),
            None => Err(FieldError::new(
                "type in the file name",
                name,
                "must be dims and type, as in foot_256x256x256_uint8.raw",
            )),
        })
    }
}

fn dims_of(word: &str) -> Option<[usize; 3]> {
    let numbers: Vec<usize> = word.split('x').map(|n| n.parse().ok()).collect::<Option<_>>()?;
    numbers.try_into().ok()
}

/// A raw file, its description given.
pub(crate) fn describe(
    path: &Path,
    raw: &RawDescription,
    encoding: Encoding,
    options: &ReadOptions,
) -> Result<Description, FileError> {
    let axes = raw.dims.map(|size| Axis { size, role: Role::Space });
    let layout = Layout::new(path, &axes, options)?;
    let direction = DMat3::from_cols_array_2d(&raw.direction);
    let placement = Placement::oriented(DVec3::from_array(raw.origin), raw.spacing.unwrap_or([1.0; 3]), direction)
        .map_err(|e| FileError::new(path, e))?;
    let mut notes = Notes::default();
    if raw.spacing.is_none() {
        notes.assume(Assumption::Spacing, "raw files state no spacing: 1, 1, 1 is assumed");
    }
    let segment = Segment { path: path.into(), start: 0, lines: 0, skip: Skip::Bytes(raw.skip) };
    let payload = Payload {
        segments: vec![segment],
        encoding,
        scalar: raw.scalar,
        endian: raw.endian,
        // The length is all that can tell a wrong description.
        excess_is_error: true,
        hint: " (are dims and type right?)",
    };
    Ok(Description {
        format: "raw",
        header: path.into(),
        source: payload.into(),
        layout,
        placement,
        placed_by: if raw.spacing.is_some() { "description" } else { "assumed" },
        calibration: raw.calibration,
        space: Space::Own,
        units: None,
        scan: None,
        notes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_names() {
        let of = |n: &str| RawDescription::from_name(Path::new(n));
        assert_eq!(of("a/foot_256x128x64_uint8.raw"), Some(Ok(RawDescription::new([256, 128, 64], ScalarType::U8))));
        assert_eq!(of("x.4x5x6.int16.raw.gz"), Some(Ok(RawDescription::new([4, 5, 6], ScalarType::I16))));
        assert_eq!(of("X_4X5X6_UINT8.RAW"), Some(Ok(RawDescription::new([4, 5, 6], ScalarType::U8))));
        assert_eq!(of("nucleon.raw"), None);
        assert_eq!(of("ax2x3_4x5.raw"), None);
        assert!(of("foot_256x256x256.raw").unwrap().unwrap_err().allowed.contains("uint8.raw"));
    }
}
