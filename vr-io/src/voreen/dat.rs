//! Headers of lines `Key: values`; and files without one that begin with their sizes, which end in `.dat` too.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DMat4, DVec3, DVec4};
use vr_core::Calibration;

use crate::encoding::Encoding;
use crate::error::{FieldError, FileError};
use crate::header_text::HeaderText;
use crate::layout::{Axis, Layout, Role};
use crate::notes::{Assumption, Notes};
use crate::payload::{Payload, Segment, Skip};
use crate::read::{Description, ReadOptions, file_head};
use crate::scalar::{Endian, ScalarType};
use crate::world::Space;

use super::{place, raw};

/// True if the beginning of a file is that of such a header.
pub(crate) fn is_dat(head: &[u8]) -> bool {
    head.split(|&c| c == b'\n')
        .map_while(|line| str::from_utf8(line).ok()?.split_once(':'))
        .any(|(key, _)| key.trim() == "ObjectFileName")
}

/// Describes the volume of a header.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let head = file_head(path).map_err(|e| FileError::new(path, e))?;
    if !is_dat(&head) {
        return describe_sizes(path, &head, options);
    }
    let in_file = |e: FieldError| e.in_file(path);
    let header = Header::read(path)?;
    let mut notes = Notes::default();
    let name = header.required("ObjectFileName").map_err(in_file)?;
    let scalar = header.scalar(&mut notes).map_err(in_file)?;
    let components = header.components().map_err(in_file)?;
    let text = header.required("Resolution").map_err(in_file)?;
    let sizes: Option<Vec<usize>> = text.split_whitespace().map(|n| n.parse().ok().filter(|&n| n > 0)).collect();
    let sizes: [usize; 3] = sizes
        .and_then(|s| s.try_into().ok())
        .ok_or_else(|| in_file(FieldError::new("Resolution", text, "must be 3 positive integers")))?;
    let [x, y, z] = sizes.map(|size| Axis { size, role: Role::Space });
    let parts = Axis { size: components, role: Role::of_components(components, scalar) };
    let layout = Layout::new(path, &[parts, x, y, z], options)?;

    let spacing = match header.get("SliceThickness") {
        None => None,
        Some(text) => match numbers(text).as_deref() {
            Some(&[x, y, z]) => Some(DVec3::new(x, y, z)),
            _ => return Err(in_file(FieldError::new("SliceThickness", text, "must be 3 numbers"))),
        },
    };
    if spacing.is_none() {
        notes.assume(Assumption::Spacing, "no SliceThickness in the header: 1, 1, 1 is assumed");
    }
    let matrix = header.matrix().map_err(in_file)?;
    let placement = place(path, DVec3::ZERO, spacing.unwrap_or(DVec3::ONE), matrix)?;
    let data = path.parent().unwrap_or(Path::new("")).join(name.replace('\\', "/"));
    Ok(Description {
        format: "Voreen (dat)",
        header: path.into(),
        source: raw(&data, scalar, &mut notes).into(),
        layout,
        placement,
        placed_by: if spacing.is_some() { "SliceThickness" } else { "assumed" },
        calibration: Calibration::default(),
        space: Space::Own,
        units: header.get("Unit").filter(|u| !u.is_empty()).map(str::to_owned),
        scan: None,
        notes,
    })
}

/// A file of three 16-bit sizes, and as many 16-bit numbers, little-endian.
fn describe_sizes(path: &Path, head: &[u8], options: &ReadOptions) -> Result<Description, FileError> {
    const HEADER: u64 = 6;
    let length = crate::memory_folder::length(path).map_err(|e| FileError::new(path, e))?;
    let sizes = head.as_chunks::<2>().0.first_chunk::<3>().map(|s| s.map(u16::from_le_bytes));
    let fits = |s: &[u16; 3]| s.iter().map(|&n| u64::from(n)).product::<u64>() * 2 + HEADER == length;
    let sizes = sizes.filter(fits).ok_or_else(|| {
        let allowed = "must be lines of text with ObjectFileName, or three 16-bit sizes and as many 16-bit numbers";
        FieldError::new("file", format_args!("{length} bytes that are neither"), allowed).in_file(path)
    })?;
    let layout = Layout::new(path, &sizes.map(|size| Axis { size: size.into(), role: Role::Space }), options)?;
    let payload = Payload {
        segments: vec![Segment { path: path.into(), start: 0, lines: 0, skip: Skip::Bytes(HEADER) }],
        encoding: Encoding::Raw,
        scalar: ScalarType::U16,
        endian: Endian::Little,
        excess_is_error: true,
        hint: "",
    };
    let fits = "three 16-bit sizes and as many 16-bit numbers, little-endian: the length of the file fits";
    let mut notes = Notes::from(vec![fits.to_owned()]);
    notes.assume(Assumption::Spacing, "such files state no spacing: 1, 1, 1 is assumed");
    Ok(Description {
        format: "sizes and u16 (dat)",
        header: path.into(),
        source: payload.into(),
        layout,
        placement: place(path, DVec3::ZERO, DVec3::ONE, DMat4::IDENTITY)?,
        placed_by: "assumed",
        calibration: Calibration::default(),
        space: Space::Own,
        units: None,
        scan: None,
        notes,
    })
}

/// Keys and values, as text.
struct Header {
    values: BTreeMap<String, String>,
    /// Rows of TransformMatrix.
    rows: Vec<String>,
}

impl Header {
    fn read(path: &Path) -> Result<Self, FileError> {
        let mut text = HeaderText::open(path)?;
        text.read_rest()?;
        Self::parse(&text.into_bytes()).map_err(|e| e.in_file(path))
    }

    fn parse(text: &[u8]) -> Result<Self, FieldError> {
        let mut header = Self { values: BTreeMap::new(), rows: Vec::new() };
        for line in String::from_utf8_lossy(text).lines().map(str::trim) {
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let (key, value) =
                line.split_once(':').ok_or_else(|| FieldError::new("header line", line, "must be 'Key: values'"))?;
            if key.trim() == "TransformMatrix" {
                header.rows.push(value.trim().to_owned());
            } else {
                header.values.insert(key.trim().to_owned(), value.trim().to_owned());
            }
        }
        Ok(header)
    }

    fn get(&self, key: &str) -> Option<&str> {
        self.values.get(key).map(String::as_str)
    }

    fn required(&self, key: &str) -> Result<&str, FieldError> {
        self.get(key).filter(|v| !v.is_empty()).ok_or_else(|| FieldError::new(key, "nothing", "the field is required"))
    }

    fn scalar(&self, notes: &mut Vec<String>) -> Result<ScalarType, FieldError> {
        let format = self.required("Format")?;
        Ok(match format {
            "UCHAR" => ScalarType::U8,
            "CHAR" => ScalarType::I8,
            "USHORT" => ScalarType::U16,
            "USHORT_12" => {
                notes.push("Format is USHORT_12: values are stored in 16 bits and taken as they are".into());
                ScalarType::U16
            }
            "SHORT" => ScalarType::I16,
            "UINT" => ScalarType::U32,
            "INT" => ScalarType::I32,
            // The other names tell what Voreen makes of the floats.
            "FLOAT" | "FLOAT8" | "FLOAT16" => ScalarType::F32,
            "DOUBLE" => ScalarType::F64,
            _ => {
                let allowed = "must be UCHAR, CHAR, USHORT, USHORT_12, SHORT, UINT, INT, FLOAT or DOUBLE";
                return Err(FieldError::new("Format", format, allowed));
            }
        })
    }

    fn components(&self) -> Result<usize, FieldError> {
        match self.get("ObjectModel").unwrap_or("I") {
            "I" | "DENSITY" => Ok(1),
            "RGB" => Ok(3),
            "RGBA" => Ok(4),
            other => Err(FieldError::new("ObjectModel", other, "must be I (one value), RGB or RGBA")),
        }
    }

    /// Rows as `row0 a b c d`.
    fn matrix(&self) -> Result<DMat4, FieldError> {
        let mut rows = [DVec4::X, DVec4::Y, DVec4::Z, DVec4::W];
        for text in &self.rows {
            let wrong =
                || FieldError::new("TransformMatrix", text, "must be row0 to row3 and 4 numbers; the last row 0 0 0 1");
            let (name, rest) = text.split_once(char::is_whitespace).ok_or_else(wrong)?;
            let index: usize = name.strip_prefix("row").and_then(|n| n.parse().ok()).ok_or_else(wrong)?;
            let numbers: [f64; 4] = numbers(rest).and_then(|n| n.try_into().ok()).ok_or_else(wrong)?;
            *rows.get_mut(index).ok_or_else(wrong)? = DVec4::from_array(numbers);
            if rows[3] != DVec4::W {
                return Err(wrong());
            }
        }
        Ok(DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose())
    }
}

fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split_whitespace().map(|n| n.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voreen::tests::described_and_loaded;

    fn load(file: &[u8], data: &[u8]) -> Result<(Description, Vec<u16>), String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.dat");
        std::fs::write(&path, file).unwrap();
        std::fs::write(folder.path().join("a b.raw"), data).unwrap();
        described_and_loaded(describe, &path)
    }

    const TEXT: &str = "ObjectFileName: a b.raw\nTaggedFileName: ---\nResolution: 4 3 2\nSliceThickness: 1 2 3.5\n\
                        Format: USHORT\nObjectModel: I\nTransformMatrix: row0 0 -1 0 5\nTransformMatrix: row1 1 0 0 0\n";

    #[test]
    fn text_and_sizes() {
        let numbers: Vec<u16> = (0..24).map(|i| 300 * i).collect();
        let data: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        let (description, found) = load(TEXT.as_bytes(), &data).unwrap();
        assert_eq!((found, description.layout.dims), (numbers.clone(), [4, 3, 2]));
        assert_eq!(description.placement.to_world(DVec3::ONE), DVec3::new(3.0, 1.0, 3.5));
        let sizes = [[4u8, 0, 3, 0, 2, 0].as_slice(), &data].concat();
        let (description, found) = load(&sizes, &[]).unwrap();
        assert_eq!((found, description.layout.dims), (numbers, [4, 3, 2]));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (text, word) in [
            (TEXT.to_owned(), "claims 48 bytes of voxels, found 8"),
            (TEXT.replace("a b.raw", "b.raw"), "b.raw"),
            (TEXT.replace("4 3 2", "4 0 2"), "Resolution: found 4 0 2"),
            (TEXT.replace("4 3 2", "4 -3 2"), "Resolution: found 4 -3 2"),
            (TEXT.replace("4 3 2", "4294967295 4294967295 4294967295"), "dims"),
            (TEXT.replace("1 2 3.5", "0 2 3.5"), "spacing of axis 0"),
            (TEXT.replace("1 2 3.5", "1"), "SliceThickness: found 1"),
            (TEXT.replace("USHORT", "STRING"), "Format: found STRING"),
            (TEXT.replace(": I", ": LA"), "ObjectModel: found LA"),
            (TEXT.replace("row0", "row9"), "TransformMatrix: found row9"),
            ("nothing of the kind".to_owned(), "19 bytes that are neither"),
            ("ObjectFileName: a b.raw\nFormat USHORT".to_owned(), "header line: found Format USHORT"),
        ] {
            let message = load(text.as_bytes(), &[0; 8]).map(|_| ()).unwrap_err();
            assert!(message.contains(word), "no {word:?} in {message}");
        }
    }
}
