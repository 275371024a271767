//! PVM volumes, plain or packed as a Differential Data Stream: Stefan Röttger's V³ volume renderer and volume library,
//! <http://schorsch.efi.fh-nuernberg.de/data/volume/>; the format is described in the renderer's `readme.html`, appendix B.
//!
//! `PVM`, then sizes and the number of components on lines of text, then the voxels: bytes, or 16-bit numbers, the higher byte first, where
//! there are two components. `PVM2` has a line of spacings too, and `PVM3` four texts after the voxels, which are left unread.

mod dds;

use std::path::Path;

use vr_core::{Calibration, Placement};

use crate::error::{FieldError, FileError, FileErrorKind};
use crate::layout::{Axis, Layout, Role};
use crate::notes::{Assumption, Notes};
use crate::packed::Packed;
use crate::payload::{Payload, Segment, Skip};
use crate::read::{Description, ReadOptions};
use crate::scalar::{Endian, ScalarType};
use crate::source::{Decoded, Source};
use crate::world::Space;

use dds::Dds;

/// Length that no header reaches.
const HEAD: usize = 4096;

/// True if the beginning of a file is that of a PVM volume, packed or not.
pub(crate) fn is_pvm(head: &[u8]) -> bool {
    dds::is_dds(head) || Version::of(head).is_some()
}

/// Describes the volume of a header. Of a packed volume with more than one byte a voxel, all is unpacked for that: the header is spread
/// over the stream.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let packed = Packed::new(path)?;
    let mut head = packed.head(HEAD as u64)?;
    let mut whole = None;
    let is_dds = dds::is_dds(&head);
    if is_dds {
        let mut stream = open(&packed)?;
        if stream.skip == 1 {
            head = stream.decode(HEAD).map_err(|e| damaged(path, e))?.to_vec();
        } else {
            let bytes = stream.into_bytes().map_err(|e| damaged(path, e))?;
            head = bytes[..bytes.len().min(HEAD)].to_vec();
            whole = Some(bytes);
        }
    }
    let header = Header::parse(&head).map_err(|e| e.in_file(path))?;
    let mut notes = Notes::default();
    if header.spacing.is_none() {
        notes.assume(Assumption::Spacing, "PVM files of the first version state no spacing: 1, 1, 1 is assumed");
    }
    let (scalar, components) = match header.components {
        2 => (ScalarType::U16, 1),
        n => (ScalarType::U8, n),
    };
    let space = header.dims.map(|size| Axis { size, role: Role::Space });
    let axes: Vec<Axis> = [Axis { size: components, role: Role::Component }].into_iter().chain(space).collect();
    let layout = Layout::new(path, &axes, options)?;
    let placement = Placement::from_spacing(header.spacing.unwrap_or([1.0; 3])).map_err(|e| FileError::new(path, e))?;
    let source: Source = if is_dds {
        unpack(packed, whole, header.length, layout.total, scalar).into()
    } else {
        let skip = Skip::Bytes(header.length as u64);
        Payload {
            segments: vec![Segment { path: path.into(), start: 0, lines: 0, skip }],
            encoding: packed.encoding,
            scalar,
            endian: Endian::Big,
            // Texts may follow.
            excess_is_error: false,
            hint: "",
        }
        .into()
    };
    Ok(Description {
        format: "PVM",
        header: path.into(),
        source,
        layout,
        placement,
        placed_by: if header.spacing.is_some() { "spacing" } else { "assumed" },
        calibration: Calibration::default(),
        space: Space::Own,
        units: None,
        scan: None,
        notes,
    })
}

fn open(packed: &Packed) -> Result<Dds<Box<dyn std::io::Read>>, FileError> {
    Dds::new(packed.reader()?).map_err(|e| damaged(&packed.path, e))
}

fn damaged(path: &Path, source: std::io::Error) -> FileError {
    FileError::new(path, FileErrorKind::Damaged { encoding: "DDS", source })
}

/// The voxels behind a header of `start` bytes; those of `whole` where they were unpacked already.
fn unpack(packed: Packed, whole: Option<Vec<u8>>, start: usize, total: usize, scalar: ScalarType) -> Decoded {
    let files = vec![packed.path.clone()];
    let decode = Box::new(move |_: &mut Vec<String>| {
        let claimed = total.saturating_mul(scalar.bytes());
        let end = start.saturating_add(claimed);
        let mut bytes = match whole {
            Some(bytes) => bytes,
            None => {
                let mut stream = open(&packed)?;
                stream.decode(end).map_err(|e| damaged(&packed.path, e))?.to_vec()
            }
        };
        if bytes.len() < end {
            let found = bytes.len().saturating_sub(start) as u64;
            let kind = FileErrorKind::Length { claimed: claimed as u64, found, hint: "" };
            return Err(FileError::new(&packed.path, kind));
        }
        bytes.truncate(end);
        bytes.drain(..start);
        Ok(bytes)
    });
    Decoded { decode, scalar, endian: Endian::Big, encoding: "DDS", files }
}

#[derive(Clone, Copy, PartialEq)]
enum Version {
    One,
    /// Versions 2 and 3, which have spacings.
    Later,
}

impl Version {
    fn of(head: &[u8]) -> Option<(Self, usize)> {
        if head.starts_with(b"PVM\n") {
            Some((Self::One, 4))
        } else if head.starts_with(b"PVM2\n") || head.starts_with(b"PVM3\n") {
            Some((Self::Later, 5))
        } else {
            None
        }
    }
}

/// The lines before the voxels.
#[derive(Debug, PartialEq)]
struct Header {
    dims: [usize; 3],
    spacing: Option<[f64; 3]>,
    components: usize,
    /// Bytes up to the voxels.
    length: usize,
}

impl Header {
    fn parse(head: &[u8]) -> Result<Self, FieldError> {
        let (version, mut length) = Version::of(head).ok_or_else(|| {
            let found = String::from_utf8_lossy(&head[..head.len().min(5)]).into_owned();
            FieldError::new("magic", found, "must be PVM, PVM2 or PVM3 on a line")
        })?;
        let mut line = |field: &str| loop {
            let rest = &head[length..];
            let end = rest
                .iter()
                .position(|&c| c == b'\n')
                .ok_or_else(|| FieldError::new(field, "no end of its line", format!("must be within {HEAD} bytes")))?;
            length += end + 1;
            if !rest.starts_with(b"#") {
                return Ok::<_, FieldError>(String::from_utf8_lossy(&rest[..end]).trim().to_owned());
            }
        };
        let sizes = line("sizes")?;
        let dims = three(&sizes, |&n: &usize| n > 0)
            .ok_or_else(|| FieldError::new("sizes", sizes, "must be 3 positive integers"))?;
        let spacing = match version {
            Version::One => None,
            Version::Later => {
                let text = line("spacing")?;
                let spacing = three(&text, |&s: &f64| s > 0.0 && s.is_finite());
                Some(spacing.ok_or_else(|| FieldError::new("spacing", text, "must be 3 positive numbers"))?)
            }
        };
        let text = line("components")?;
        let components = text.parse().ok().filter(|&n: &usize| n > 0);
        let components = components.ok_or_else(|| FieldError::new("components", text, "must be 1 or more"))?;
        Ok(Self { dims, spacing, components, length })
    }
}

/// Exactly three numbers of a kind.
fn three<T: std::str::FromStr>(text: &str, allowed: impl Fn(&T) -> bool) -> Option<[T; 3]> {
    let numbers: Option<Vec<T>> = text.split_whitespace().map(|w| w.parse().ok().filter(&allowed)).collect();
    numbers?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxels::Voxels;

    fn load(file: &[u8]) -> Result<(Voxels, Vec<String>), String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.pvm");
        std::fs::write(&path, file).unwrap();
        let options = ReadOptions { map: false, ..ReadOptions::default() };
        let Description { source, layout, mut notes, .. } = describe(&path, &options).map_err(|e| e.to_string())?;
        let voxels = source.load(&path, &layout, &options, &mut notes).map_err(|e| e.to_string())?;
        Ok((voxels, notes.into_lines()))
    }

    /// 4×3×2 voxels that tell their places.
    fn numbers() -> Vec<u16> {
        (0..24).map(|i| 1000 + i * 77).collect()
    }

    #[test]
    fn sixteen_bits_plain_and_packed() {
        let bytes: Vec<u8> = numbers().iter().flat_map(|x| x.to_be_bytes()).collect();
        let plain = [b"PVM3\n4 3 2\n1 2 3.5\n2\n".as_slice(), &bytes, b"a text\0\0\0\0"].concat();
        let packed = |magic: &[u8]| dds::tests::encode(&plain, magic, 2, 4, 1 << 24);
        for file in [plain.clone(), packed(b"DDS v3d\n"), packed(b"DDS v3e\n")] {
            let (Voxels::U16(found), _) = load(&file).unwrap() else { panic!("u16") };
            assert_eq!(found.as_ref(), numbers());
        }
    }

    #[test]
    fn bytes_of_the_first_version() {
        let bytes: Vec<u8> = numbers().iter().map(|&x| x as u8).collect();
        let plain = [b"PVM\n# made here\n4 3 2\n1\n".as_slice(), &bytes].concat();
        for file in [plain.clone(), dds::tests::encode(&plain, b"DDS v3d\n", 1, 4, 1 << 24)] {
            let (Voxels::U8(found), notes) = load(&file).unwrap() else { panic!("u8") };
            assert_eq!(found.as_ref(), bytes);
            assert!(notes[0].contains("1, 1, 1 is assumed"), "{notes:?}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let pack = |text: &[u8]| dds::tests::encode(text, b"DDS v3d\n", 1, 4, 1 << 24);
        for (file, word) in [
            (b"PVM\n4 3 0\n1\n".to_vec(), "sizes: found 4 3 0"),
            (b"PVM\n4 3 -2\n1\n".to_vec(), "sizes: found 4 3 -2"),
            (b"PVM2\n4 3 2\n1 nan 1\n1\n".to_vec(), "spacing: found 1 nan 1"),
            (b"PVM2\n4 3 2\n1 1 1\n0\n".to_vec(), "components: found 0"),
            (b"PVM2\n4 3 2\n1 1 1".to_vec(), "spacing: found no end of its line"),
            (b"PVM\n4 3 2\n1\nshort".to_vec(), "claims 24 bytes of voxels, found 5"),
            (pack(b"PVM\n4 3 2\n1\nshort"), "claims 24 bytes of voxels, found 5"),
            (pack(b"PVM\n99999 99999 99999\n1\nshort"), "claims 999970000299999 bytes of voxels, found 5"),
            (pack(b"PVM\n4294967295 4294967295 4294967295\n1\n"), "dims"),
            (pack(b"no volume"), "magic: found no vo"),
            (b"DDS v3d\n".to_vec(), "DDS data are damaged"),
            (b"DDS v3d\n\0".to_vec(), "magic: found nothing"),
        ] {
            let message = load(&file).map(|_| ()).unwrap_err();
            assert!(message.contains(word), "no {word:?} in {message}");
        }
    }
}
