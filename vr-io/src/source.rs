//! Source of a volume's voxels: files that hold them as numbers, or a decoder that makes numbers of what a file holds.

use std::path::{Path, PathBuf};

use vr_core::memory;

use crate::decode::with_scalar;
use crate::error::{FileError, FileErrorKind};
use crate::layout::Layout;
use crate::payload::Payload;
use crate::read::ReadOptions;
use crate::scalar::{Endian, ScalarType};
use crate::voxels::{Remember, Stored, Voxels};

/// Source of the voxels. None of them is read before [`Source::load`].
pub(crate) enum Source {
    /// Numbers in files, one after another.
    Files(Payload),
    /// Numbers behind a coding that only the format knows.
    Decoded(Decoded),
}

/// Gives the bytes of all numbers of a layout, one after another; what is worth a note it adds to the notes.
pub(crate) type Decode = Box<dyn FnOnce(&mut Vec<String>) -> Result<Vec<u8>, FileError>>;

/// Numbers behind a coding that only the format knows.
pub(crate) struct Decoded {
    pub decode: Decode,
    pub scalar: ScalarType,
    /// Byte order of what the decoder gives.
    pub endian: Endian,
    /// Name of the coding.
    pub encoding: &'static str,
    /// Files that hold the coded numbers.
    pub files: Vec<PathBuf>,
}

impl From<Payload> for Source {
    fn from(payload: Payload) -> Self {
        Self::Files(payload)
    }
}

impl From<Decoded> for Source {
    fn from(decoded: Decoded) -> Self {
        Self::Decoded(decoded)
    }
}

impl Source {
    pub fn scalar(&self) -> ScalarType {
        match self {
            Self::Files(payload) => payload.scalar,
            Self::Decoded(decoded) => decoded.scalar,
        }
    }

    pub fn endian(&self) -> Endian {
        match self {
            Self::Files(payload) => payload.endian,
            Self::Decoded(decoded) => decoded.endian,
        }
    }

    pub fn encoding(&self) -> &'static str {
        match self {
            Self::Files(payload) => payload.encoding.name(),
            Self::Decoded(decoded) => decoded.encoding,
        }
    }

    /// The files that hold the voxels.
    pub fn files(&self) -> Vec<PathBuf> {
        match self {
            Self::Files(payload) => payload.segments.iter().map(|s| s.path.clone()).collect(),
            Self::Decoded(decoded) => decoded.files.clone(),
        }
    }

    /// Reads the voxels that `layout` picks; `header` is the file that errors about the whole belong to.
    pub fn load(
        self,
        header: &Path,
        layout: &Layout,
        options: &ReadOptions,
        notes: &mut Vec<String>,
    ) -> Result<Voxels, FileError> {
        match self {
            Self::Files(payload) => payload.load(header, layout, options, notes),
            Self::Decoded(decoded) => {
                let (scalar, endian) = (decoded.scalar, decoded.endian);
                // A decoder gives all numbers, of which the voxels are picked.
                let given = (layout.total as u64).saturating_add(layout.count() as u64);
                memory::check("the volume", given.saturating_mul(scalar.bytes() as u64))
                    .map_err(|e| FileError::new(header, e))?;
                let bytes = (decoded.decode)(notes)?;
                with_scalar!(scalar, S => numbers::<S>(&bytes, endian, header, layout, notes))
            }
        }
    }
}

fn numbers<S: Remember>(
    bytes: &[u8],
    endian: Endian,
    header: &Path,
    layout: &Layout,
    notes: &mut Vec<String>,
) -> Result<Voxels, FileError> {
    let claimed = layout.total.saturating_mul(size_of::<S>());
    if bytes.len() != claimed {
        let kind = FileErrorKind::Length { claimed: claimed as u64, found: bytes.len() as u64, hint: "" };
        return Err(FileError::new(header, kind));
    }
    let mut out = Vec::new();
    if layout.is_contiguous() {
        let at = |i: usize| i * size_of::<S>();
        out.reserve_exact(layout.count());
        S::append(&bytes[at(layout.offset)..at(layout.offset + layout.count())], endian, &mut out);
    } else {
        let mut all = Vec::with_capacity(layout.total);
        S::append(bytes, endian, &mut all);
        out = layout.pick(&all);
    }
    Ok(S::remember(Stored::Owned(out), notes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{Axis, Role};

    fn decoded(bytes: Vec<u8>) -> Source {
        let files = vec![];
        let decode = Box::new(move |_: &mut Vec<String>| Ok(bytes));
        Decoded { decode, scalar: ScalarType::U16, endian: Endian::Big, encoding: "test", files }.into()
    }

    #[test]
    fn decoded_numbers_are_picked_like_any_others() {
        let axes = [(2, Role::Component), (2, Role::Space), (2, Role::Space), (2, Role::Space)];
        let axes = axes.map(|(size, role)| Axis { size, role });
        let options = ReadOptions { component: Some(1), ..Default::default() };
        let layout = Layout::new(Path::new("x"), &axes, &options).unwrap();
        let bytes: Vec<u8> = (0..16u16).flat_map(|i| (300 + i).to_be_bytes()).collect();
        let load = |bytes| decoded(bytes).load(Path::new("x"), &layout, &options, &mut Vec::new());
        let Voxels::U16(voxels) = load(bytes.clone()).unwrap() else { panic!("u16") };
        assert_eq!(voxels.as_ref(), [301, 303, 305, 307, 309, 311, 313, 315]);
        assert!(load(bytes[1..].to_vec()).is_err());
    }
}
