//! SLC volumes of VolVis (Avila et al. 1994, "VolVis: A Diversified Volume Visualization System", State University of New York at Stony
//! Brook).
//!
//! Numbers as text up to an `X`: the magic number 11111; sizes and bits per voxel; spacings; codes of unit, origin, modification and
//! compression; width and height of a small picture. Then the picture, three bytes a pixel, and one slice after the other: as it is, or as a
//! length, an `X`, and runs: 7 bits of length, and a highest bit that says whether as many bytes follow, or one that is repeated. A run
//! of length 0 is the end of the slice.

use std::io::{self, Read};
use std::path::Path;

use vr_core::{Calibration, Placement};

use crate::encoding::invalid;
use crate::error::{FieldError, FileError, FileErrorKind};
use crate::layout::{Axis, Layout, Role};
use crate::notes::Notes;
use crate::packed::Packed;
use crate::payload::{Payload, Segment, Skip};
use crate::read::{Description, ReadOptions};
use crate::scalar::{Endian, ScalarType};
use crate::source::{Decoded, Source};
use crate::world::Space;

/// True if the beginning of a file is that of an SLC volume.
pub(crate) fn is_slc(head: &[u8]) -> bool {
    head.strip_prefix(b"11111").is_some_and(|rest| rest.first().is_some_and(u8::is_ascii_whitespace))
}

/// Describes the volume of a header.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    const HEAD: u64 = 4096;
    let packed = Packed::new(path)?;
    let header = Header::parse(&packed.head(HEAD)?).map_err(|e| e.in_file(path))?;
    let layout = Layout::new(path, &header.dims.map(|size| Axis { size, role: Role::Space }), options)?;
    let placement = Placement::from_spacing(header.spacing).map_err(|e| FileError::new(path, e))?;
    let source: Source = if header.runs {
        unpack(packed, &header).into()
    } else {
        Payload {
            segments: vec![Segment { path: path.into(), start: 0, lines: 0, skip: Skip::Bytes(header.slices) }],
            encoding: packed.encoding,
            scalar: ScalarType::U8,
            endian: Endian::NATIVE,
            excess_is_error: false,
            hint: "",
        }
        .into()
    };
    Ok(Description {
        format: "SLC",
        header: path.into(),
        source,
        layout,
        placement,
        placed_by: "spacing",
        calibration: Calibration::default(),
        space: Space::Own,
        // The codes of units are not described anywhere that we know.
        units: None,
        scan: None,
        notes: Notes::default(),
    })
}

struct Header {
    dims: [usize; 3],
    spacing: [f64; 3],
    /// True if slices are coded as runs.
    runs: bool,
    /// Offset of the first slice.
    slices: u64,
}

impl Header {
    fn parse(head: &[u8]) -> Result<Self, FieldError> {
        let mut words = Words { rest: head };
        words.next("magic")?;
        let mut size = |field| {
            let found = words.next(field)?;
            found
                .parse()
                .ok()
                .filter(|&n: &usize| n > 0)
                .ok_or_else(|| FieldError::new(field, found, "must be 1 or more"))
        };
        let dims = [size("size along x")?, size("size along y")?, size("size along z")?];
        let bits = words.next("bits per voxel")?;
        if bits != "8" {
            return Err(FieldError::new("bits per voxel", bits, "must be 8"));
        }
        let mut spacing = [0.0; 3];
        for s in &mut spacing {
            let found = words.next("spacing")?;
            *s = found.parse().map_err(|_| FieldError::new("spacing", found, "must be 3 numbers"))?;
        }
        for field in ["unit", "origin", "modification"] {
            words.next(field)?;
        }
        let runs = match words.next("compression")? {
            "0" => false,
            "1" => true,
            other => return Err(FieldError::new("compression", other, "must be 0 (none) or 1 (runs)")),
        };
        let mut picture = 3u64;
        for field in ["width of the picture", "height of the picture"] {
            let found = words.next(field)?;
            let wrong = || FieldError::new(field, found, "must be 0 or more, and not huge");
            let n: u32 = found.parse().map_err(|_| wrong())?;
            picture = picture.checked_mul(n.into()).ok_or_else(wrong)?;
        }
        let text = words.rest.trim_ascii_start();
        let text = text.strip_prefix(b"X").ok_or_else(|| {
            let found = String::from_utf8_lossy(&text[..text.len().min(8)]).into_owned();
            FieldError::new("end of the header", found, "must be X")
        })?;
        let slices = picture.saturating_add((head.len() - text.len()) as u64);
        Ok(Self { dims, spacing, runs, slices })
    }
}

/// Words of text at the beginning of bytes.
struct Words<'a> {
    rest: &'a [u8],
}

impl<'a> Words<'a> {
    fn next(&mut self, field: &str) -> Result<&'a str, FieldError> {
        let text = self.rest.trim_ascii_start();
        let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
        let (word, rest) = text.split_at(end);
        self.rest = rest;
        let word = str::from_utf8(word).ok().filter(|w| !w.is_empty());
        word.ok_or_else(|| FieldError::new(field, "no word", "must be a number"))
    }
}

/// The voxels of slices that are coded as runs.
fn unpack(packed: Packed, header: &Header) -> Decoded {
    let files = vec![packed.path.clone()];
    let ([nx, ny, nz], start) = (header.dims, header.slices);
    let decode = Box::new(move |_: &mut Vec<String>| {
        let mut reader = packed.reader_after(start)?;
        let mut out = Vec::new();
        for z in 0..nz {
            let slice = slice(&mut reader, nx.saturating_mul(ny), &mut out);
            slice.map_err(|e| {
                let source = io::Error::new(e.kind(), format!("slice {z}: {e}"));
                FileError::new(&packed.path, FileErrorKind::Damaged { encoding: "run-length", source })
            })?;
        }
        Ok(out)
    });
    Decoded { decode, scalar: ScalarType::U8, endian: Endian::NATIVE, encoding: "run-length", files }
}

/// Appends the `count` voxels of a slice.
fn slice(reader: &mut impl Read, count: usize, out: &mut Vec<u8>) -> io::Result<()> {
    // Read the length of the coded slice: a number, and X.
    let mut length = 0u64;
    loop {
        let mut byte = [0];
        reader.read_exact(&mut byte)?;
        match byte[0] {
            digit @ b'0'..=b'9' => {
                let next = length.checked_mul(10).and_then(|n| n.checked_add(u64::from(digit - b'0')));
                length = next.ok_or_else(|| invalid("its length is not a number".into()))?;
            }
            b'X' => break,
            white if white.is_ascii_whitespace() => {}
            other => return Err(invalid(format!("its length has a {:?} in it", char::from(other)))),
        }
    }
    let mut coded = Vec::new();
    reader.take(length).read_to_end(&mut coded)?;
    if (coded.len() as u64) < length {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }

    // Unpack the runs.
    let first = out.len();
    let mut rest = coded.as_slice();
    let cut = || invalid("its last run is cut off".into());
    while let Some((&code, after)) = rest.split_first() {
        let n = usize::from(code & 0x7f);
        if n == 0 {
            break;
        }
        if code & 0x80 != 0 {
            let (bytes, after) = after.split_at_checked(n).ok_or_else(cut)?;
            out.extend_from_slice(bytes);
            rest = after;
        } else {
            let (&byte, after) = after.split_first().ok_or_else(cut)?;
            out.resize(out.len() + n, byte);
            rest = after;
        }
        if out.len() - first > count {
            break;
        }
    }
    match out.len() - first {
        n if n == count => Ok(()),
        n if n > count => Err(invalid(format!("its runs give more than {count} voxels"))),
        n => Err(invalid(format!("its runs give {n} voxels of {count}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxels::Voxels;

    fn load(file: &[u8]) -> Result<Vec<u8>, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.slc");
        std::fs::write(&path, file).unwrap();
        let options = ReadOptions { map: false, ..ReadOptions::default() };
        let Description { source, layout, placement, mut notes, .. } =
            describe(&path, &options).map_err(|e| e.to_string())?;
        assert_eq!(placement.spacing().to_array(), [1.0, 2.0, 3.5]);
        let voxels = source.load(&path, &layout, &options, &mut notes).map_err(|e| e.to_string())?;
        let Voxels::U8(found) = voxels else { panic!("u8") };
        Ok(found.as_ref().to_vec())
    }

    fn file(compression: &str, slices: &[u8]) -> Vec<u8> {
        [format!("11111\n3 2 2 8\n1 2 3.5\n2 5 0 {compression}\n2 1 X").as_bytes(), b"picpic", slices].concat()
    }

    const CODED: &[u8] = b"7 X\x03\x09\x83abc\x0010 X\x86uvwxyz\x00..";

    #[test]
    fn slices_as_they_are_and_as_runs() {
        assert_eq!(load(&file("0", b"abcdefghijkl")).unwrap(), b"abcdefghijkl");
        assert_eq!(load(&file("1", CODED)).unwrap(), b"\x09\x09\x09abcuvwxyz");
    }

    #[test]
    fn what_is_wrong_is_named() {
        let text = |text: &str| text.as_bytes().to_vec();
        for (file, word) in [
            (file("0", b"abcdefghijk"), "claims 12 bytes of voxels, found 11"),
            (file("1", &CODED[..12]), "slice 1: "),
            (file("1", b"7 X\x04\x09\x83abc\x00"), "slice 0: its runs give more than 6"),
            (file("1", b"7 X\x02\x09\x83abc\x00"), "slice 0: its runs give 5 voxels of 6"),
            (file("1", b"3 X\x83ab"), "slice 0: its last run is cut off"),
            (file("1", b"99999999999999999999999 X"), "slice 0: its length is not a number"),
            (file("2", b""), "compression: found 2"),
            (text("11111 3 0 2 8"), "size along y: found 0"),
            (text("11111 3 -1 2 8"), "size along y: found -1"),
            (text("11111 3 2 2 16"), "bits per voxel: found 16"),
            (text("11111 3 2 2 8 1 1"), "spacing: found no word"),
            (text("11111 3 2 2 8 1 2 3.5 0 0 0 1 4000000000 4000000000 X"), "height of the picture: found 4000000000"),
            (text("11111 3 2 2 8 1 2 3.5 0 0 0 1 40000 40000 X"), "raw data are damaged"),
        ] {
            let message = load(&file).unwrap_err();
            assert!(message.contains(word), "no {word:?} in {message}");
        }
    }
}
