//! MetaImage (.mha, .mhd): <https://itk.org/Wiki/ITK/MetaIO/Documentation>.
//!
//! A file with a transform, an offset or an anatomical orientation is ITK's way of saying where a patient lies: left,
//! posterior, superior, turned to RAS here. A file with none of them keeps its own frame.

mod header;

use std::path::{Path, PathBuf};

use glam::{DMat3, DVec3};
use vr_core::Calibration;

use crate::encoding::Encoding;
use crate::error::{FieldError, FileError};
use crate::file_pattern::expand;
use crate::layout::{Axis, Layout, Role};
use crate::notes::{Assumption, Notes};
use crate::payload::{Payload, Segment, Skip};
use crate::read::{Description, ReadOptions};
use crate::scalar::{Endian, ScalarType};
use crate::world::Space;

use header::Header;

/// Describes the volume of a header.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let header = Header::read(path)?;
    let in_file = |e: FieldError| e.in_file(path);
    let mut notes = Notes::default();

    if let Some(kind) = header.get("ObjectType").filter(|k| !k.eq_ignore_ascii_case("Image")) {
        return Err(in_file(FieldError::new("ObjectType", kind, "must be Image")));
    }
    let name = header.required("ElementType").map_err(in_file)?;
    let scalar = element_type(name).map_err(in_file)?;
    let axes = axes(&header, scalar).map_err(in_file)?;
    let layout = Layout::new(path, &axes, options)?;
    let frame = Frame::new(&header, &mut notes).map_err(in_file)?;
    let placement = frame.space.place(frame.origin, frame.axes).map_err(|e| FileError::new(path, e))?;
    let payload = payload(path, &header, &layout, scalar).map_err(in_file)?;
    let calibration = Calibration {
        slope: header.number("ElementToIntensityFunctionSlope").map_err(in_file)?.unwrap_or(1.0),
        intercept: header.number("ElementToIntensityFunctionOffset").map_err(in_file)?.unwrap_or(0.0),
    };
    Ok(Description {
        format: "MetaImage",
        header: path.into(),
        source: payload.into(),
        layout,
        placement,
        placed_by: frame.placed_by,
        calibration,
        space: frame.space,
        // The format knows no other.
        units: frame.space.is_patient().then(|| "mm".to_owned()),
        scan: None,
        notes,
    })
}

fn element_type(name: &str) -> Result<ScalarType, FieldError> {
    // An array type only repeats that there are several channels.
    Ok(match name.strip_suffix("_ARRAY").unwrap_or(name) {
        "MET_CHAR" | "MET_ASCII_CHAR" => ScalarType::I8,
        "MET_UCHAR" => ScalarType::U8,
        "MET_SHORT" => ScalarType::I16,
        "MET_USHORT" => ScalarType::U16,
        // MetaIO's long has 32 bits on every machine.
        "MET_INT" | "MET_LONG" => ScalarType::I32,
        "MET_UINT" | "MET_ULONG" => ScalarType::U32,
        "MET_LONG_LONG" => ScalarType::I64,
        "MET_ULONG_LONG" => ScalarType::U64,
        "MET_FLOAT" => ScalarType::F32,
        "MET_DOUBLE" => ScalarType::F64,
        _ => {
            let allowed = "must be MET_CHAR, MET_UCHAR, MET_SHORT, MET_USHORT, MET_INT, MET_UINT, MET_LONG, MET_ULONG, \
                           MET_LONG_LONG, MET_ULONG_LONG, MET_FLOAT or MET_DOUBLE";
            return Err(FieldError::new("ElementType", name, allowed));
        }
    })
}

fn axes(header: &Header, scalar: ScalarType) -> Result<Vec<Axis>, FieldError> {
    let text = header.required("DimSize")?;
    let sizes: Option<Vec<usize>> = text.split_whitespace().map(|w| w.parse().ok().filter(|&n| n > 0)).collect();
    let dimension = header.dimension()?;
    let sizes = sizes
        .filter(|s| s.len() == dimension)
        .ok_or_else(|| FieldError::new("DimSize", text, format!("must be {dimension} positive integers (NDims)")))?;
    let channels = match header.get("ElementNumberOfChannels") {
        None => 1,
        Some(text) => text
            .parse()
            .ok()
            .filter(|&n: &usize| n > 0)
            .ok_or_else(|| FieldError::new("ElementNumberOfChannels", text, "must be 1 or more"))?,
    };
    let mut axes = vec![Axis { size: channels, role: Role::of_components(channels, scalar) }];
    axes.extend(
        sizes.iter().enumerate().map(|(i, &size)| Axis { size, role: if i < 3 { Role::Space } else { Role::Frame } }),
    );
    Ok(axes)
}

/// Placement of the voxels in the file's space.
struct Frame {
    space: Space,
    origin: DVec3,
    axes: DMat3,
    placed_by: &'static str,
}

impl Frame {
    fn new(header: &Header, notes: &mut Notes) -> Result<Self, FieldError> {
        let n = header.dimension()?;
        let spacing = match header.numbers(&["ElementSpacing"], n)? {
            Some(s) => Some(s),
            None => header.numbers(&["ElementSize"], n)?,
        };
        let known = spacing.is_some();
        let spacing = spacing.unwrap_or_else(|| vec![1.0; n]);
        if let Some(axis) = spacing[..3].iter().position(|&s| !(s > 0.0 && s.is_finite())) {
            return Err(FieldError::new("ElementSpacing", spacing[axis], "must be positive and finite"));
        }
        let matrix = header.numbers(&["TransformMatrix", "Rotation", "Orientation"], n * n)?;
        let offset = header.numbers(&["Offset", "Position", "Origin"], n)?;
        let letters = header.get("AnatomicalOrientation").filter(|l| !l.contains('?'));

        let (direction, by) = if let Some(m) = &matrix {
            // Row i is the direction of index axis i.
            let row = |i: usize| DVec3::new(m[i * n], m[i * n + 1], m[i * n + 2]);
            (DMat3::from_cols(row(0), row(1), row(2)), "TransformMatrix")
        } else if let Some(letters) = letters {
            (anatomical(letters)?, "AnatomicalOrientation")
        } else {
            (DMat3::IDENTITY, if known { "ElementSpacing" } else { "assumed" })
        };
        if !known {
            notes.assume(Assumption::Spacing, "no ElementSpacing in the header: 1, 1, 1 is assumed");
        }
        let patient = matrix.is_some() || offset.is_some() || letters.is_some();
        Ok(Self {
            space: if patient { Space::Lps } else { Space::Own },
            origin: offset.map_or(DVec3::ZERO, |o| DVec3::new(o[0], o[1], o[2])),
            axes: direction * DMat3::from_diagonal(DVec3::new(spacing[0], spacing[1], spacing[2])),
            placed_by: by,
        })
    }
}

/// Directions, in left-posterior-superior, from the letters of where each axis comes *from*: RAI is the identity.
fn anatomical(letters: &str) -> Result<DMat3, FieldError> {
    let wrong =
        || FieldError::new("AnatomicalOrientation", letters, "must be three letters of R/L, A/P, I/S, as in RAI");
    let columns: Option<Vec<DVec3>> = letters
        .chars()
        .map(|c| match c.to_ascii_uppercase() {
            'R' => Some(DVec3::X),
            'L' => Some(DVec3::NEG_X),
            'A' => Some(DVec3::Y),
            'P' => Some(DVec3::NEG_Y),
            'I' => Some(DVec3::Z),
            'S' => Some(DVec3::NEG_Z),
            _ => None,
        })
        .collect();
    let columns: [DVec3; 3] = columns.and_then(|c| c.try_into().ok()).ok_or_else(wrong)?;
    let m = DMat3::from_cols_slice(&columns.map(|c| c.to_array()).concat());
    if m.determinant() == 0.0 { Err(wrong()) } else { Ok(m) }
}

fn payload(path: &Path, header: &Header, layout: &Layout, scalar: ScalarType) -> Result<Payload, FieldError> {
    let binary = header.flag(&["BinaryData"])?.unwrap_or(true);
    let compressed = header.flag(&["CompressedData"])?.unwrap_or(false);
    let big = header.flag(&["BinaryDataByteOrderMSB", "ElementByteOrderMSB"])?.unwrap_or(false);
    let skip = match header.get("HeaderSize") {
        None => Skip::Bytes(0),
        Some(text) => match text.parse::<i64>() {
            Ok(-1) => Skip::AllButVoxels,
            Ok(n @ 0..) => Skip::Bytes(n as u64),
            _ => return Err(FieldError::new("HeaderSize", text, "must be 0 or more, or -1 for the last bytes")),
        },
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let segment = |path: PathBuf, start: u64, skip: Skip| Segment { path, start, lines: 0, skip };
    let beside = |name: &str| segment(folder.join(name), 0, skip);
    let file = header.required("ElementDataFile")?;
    let segments = match file.split_whitespace().next() {
        // The voxels follow the header: there is nothing to skip.
        Some("LOCAL" | "Local" | "local") => vec![segment(path.into(), header.length, Skip::Bytes(0))],
        Some("LIST") => header.listed_files(path)?.iter().map(|name| beside(name)).collect(),
        _ if file.contains('%') => {
            expand("ElementDataFile", file, layout.total)?.iter().map(|name| beside(name)).collect()
        }
        _ => vec![beside(file)],
    };
    Ok(Payload {
        segments,
        encoding: match (binary, compressed) {
            (false, _) => Encoding::Text,
            (true, true) => Encoding::Zlib,
            (true, false) => Encoding::Raw,
        },
        scalar,
        endian: if big { Endian::Big } else { Endian::Little },
        // Writers pad.
        excess_is_error: false,
        hint: " (are DimSize and ElementType right?)",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(fields: &str) -> Result<Frame, FieldError> {
        let text = format!("NDims = 3\n{fields}\nElementDataFile = x\n");
        Frame::new(&Header::parse(text.as_bytes()).unwrap(), &mut Notes::default())
    }

    #[test]
    fn rows_of_the_matrix_are_directions_of_the_index_axes() {
        let f = frame("TransformMatrix = 0 1 0 0 0 1 1 0 0\nElementSpacing = 2 3 4\nOffset = 5 6 7").unwrap();
        assert_eq!(f.axes.x_axis, DVec3::new(0.0, 2.0, 0.0));
        assert_eq!(f.axes.y_axis, DVec3::new(0.0, 0.0, 3.0));
        assert_eq!(f.axes.z_axis, DVec3::new(4.0, 0.0, 0.0));
        assert_eq!((f.origin, f.space), (DVec3::new(5.0, 6.0, 7.0), Space::Lps));
    }

    #[test]
    fn letters_count_where_there_is_no_matrix() {
        assert_eq!(frame("AnatomicalOrientation = RAI").unwrap().axes, DMat3::IDENTITY);
        assert_eq!(frame("AnatomicalOrientation = ILP").unwrap().axes.x_axis, DVec3::Z);
        assert_eq!(frame("AnatomicalOrientation = ???").unwrap().space, Space::Own);
        assert!(frame("AnatomicalOrientation = RLI").is_err());
        assert!(frame("AnatomicalOrientation = RA").is_err());
    }

    #[test]
    fn spacing_comes_before_size() {
        assert_eq!(frame("ElementSize = 9 9 9\nElementSpacing = 1 2 3").unwrap().axes.y_axis.y, 2.0);
        assert_eq!(frame("ElementSize = 9 9 9").unwrap().axes.y_axis.y, 9.0);
        for bad in ["0 1 1", "-1 1 1", "nan 1 1", "1 1"] {
            assert!(frame(&format!("ElementSpacing = {bad}")).is_err(), "{bad}");
        }
    }
}
