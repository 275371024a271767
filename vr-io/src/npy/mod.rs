//! NumPy's `.npy` (NEP 1, "A simple file format for NumPy arrays"): volumes, in arrays of three axes and more. Arrays of N×3 are points, which
//! [`crate::points`] reads.
//!
//! Indices are taken as `[z, y, x]`, in C order and in Fortran order alike. Of four axes, the last counts components if it has at most four of
//! them, `[z, y, x, component]`, and the first counts frames otherwise, `[frame, z, y, x]`. Five are `[frame, z, y, x, component]`.
//!
//! Own code: the header is one line, and the crates at hand bring a parser of Python for it.

mod header;

use std::path::Path;

use vr_core::{Calibration, Placement};

use crate::error::{FileError, FileErrorKind};
use crate::float16;
use crate::layout::{Axis, Layout, Role};
use crate::notes::{Assumption, Notes};
use crate::packed::Packed;
use crate::payload::{Payload, Segment, Skip};
use crate::read::{Description, ReadOptions};
use crate::scalar::ScalarType;
use crate::world::Space;

pub(crate) use header::{Element, Header, is_npy};

/// Most components of an array of four axes.
const MAX_COMPONENTS: u64 = 4;

/// True if the beginning of a file is that of an array with at least three axes.
pub(crate) fn holds_volume(head: &[u8]) -> bool {
    is_npy(head) && Header::parse(head).is_ok_and(|header| header.shape.len() >= 3)
}

/// Describes the volume of a header.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    // Beyond the longest header of the first version; the later ones are for arrays of records.
    const HEAD: u64 = 1 << 17;
    let in_file = |kind: FileErrorKind| FileError::new(path, kind);
    let packed = Packed::new(path)?;
    let header = Header::parse(&packed.head(HEAD)?).map_err(in_file)?;
    let roles = roles(&header).map_err(in_file)?;
    let axis = |(&size, &role): (&u64, &Role)| Ok(Axis { size: usize::try_from(size).map_err(|_| size)?, role });
    let mut axes: Vec<Axis> = header
        .shape
        .iter()
        .zip(roles)
        .map(axis)
        .collect::<Result<_, u64>>()
        .map_err(|size| in_file(FileErrorKind::field("shape", size, "must be sizes that memory can hold")))?;
    // The last axis of bytes may count the parts of a colour.
    if let (Some(last), Element::Number(scalar)) =
        (axes.last_mut().filter(|a| a.role == Role::Component), &header.element)
    {
        last.role = Role::of_components(last.size, *scalar);
    }
    // The fastest axis first.
    let layout = if header.by_column {
        Layout::new(path, &axes, options)?.reversed()
    } else {
        axes.reverse();
        Layout::new(path, &axes, options)?
    };
    let placement = Placement::from_spacing([1.0; 3]).map_err(|e| FileError::new(path, e))?;
    let order = format!("NumPy arrays do not name their axes: {} is assumed", names(roles));
    let mut notes = Notes::from(vec![order]);
    notes.assume(Assumption::Spacing, "NumPy arrays state no spacing: 1, 1, 1 is assumed");

    let skip = Skip::Bytes(header.length as u64);
    let payload = Payload {
        segments: vec![Segment { path: path.into(), start: 0, lines: 0, skip }],
        encoding: packed.encoding,
        scalar: match header.element {
            Element::Number(scalar) => scalar,
            Element::Half => ScalarType::U16,
        },
        endian: header.endian,
        excess_is_error: false,
        hint: "",
    };
    let source = match header.element {
        Element::Number(_) => payload.into(),
        Element::Half => {
            notes.push(float16::NOTE.into());
            float16::source(payload, path, &layout, options)
        }
    };
    Ok(Description {
        format: "NumPy",
        header: path.into(),
        source,
        layout,
        placement,
        placed_by: "assumed",
        calibration: Calibration::default(),
        space: Space::Own,
        units: None,
        scan: None,
        notes,
    })
}

/// Roles of the axes of a shape.
fn roles(header: &Header) -> Result<&'static [Role], FileErrorKind> {
    use Role::{Component, Frame, Space};
    match *header.shape.as_slice() {
        [_, _, _] => Ok(&[Space, Space, Space]),
        [_, _, _, last] if last <= MAX_COMPONENTS => Ok(&[Space, Space, Space, Component]),
        [_, _, _, _] => Ok(&[Frame, Space, Space, Space]),
        [_, _, _, _, _] => Ok(&[Frame, Space, Space, Space, Component]),
        _ => Err(FileErrorKind::field(
            "shape",
            header.shape_text(),
            "a volume has three axes; four or five with frames or components",
        )),
    }
}

fn names(roles: &[Role]) -> &'static str {
    match (roles.first(), roles.last()) {
        (Some(Role::Frame), Some(Role::Component)) => "[frame, z, y, x, component]",
        (Some(Role::Frame), _) => "[frame, z, y, x]",
        (_, Some(Role::Component)) => "[z, y, x, component]",
        _ => "[z, y, x]",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxels::Voxels;

    fn file(descr: &str, by_column: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let header = format!("{{'descr': '{descr}', 'fortran_order': {by_column}, 'shape': {shape}, }}\n");
        let length = u16::try_from(header.len()).unwrap().to_le_bytes();
        [b"\x93NUMPY\x01\0", length.as_slice(), header.as_bytes(), data].concat()
    }

    fn load(file: &[u8], options: &ReadOptions) -> Result<([usize; 3], Voxels), String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        std::fs::write(&path, file).unwrap();
        let options = ReadOptions { map: false, ..options.clone() };
        let Description { source, layout, mut notes, .. } = describe(&path, &options).map_err(|e| e.to_string())?;
        let voxels = source.load(&path, &layout, &options, &mut notes).map_err(|e| e.to_string())?;
        Ok((layout.dims, voxels))
    }

    fn bytes(file: &[u8], options: &ReadOptions) -> Vec<u8> {
        let (dims, Voxels::U8(voxels)) = load(file, options).unwrap() else { panic!("u8") };
        assert_eq!(dims, [4, 3, 2]);
        voxels.as_ref().to_vec()
    }

    #[test]
    fn c_order_and_fortran_order_are_the_same_array() {
        let c: Vec<u8> = (0..24).collect();
        // a[z, y, x] = 12 z + 4 y + x, written with z the fastest.
        let fortran: Vec<u8> = (0..24).map(|i| 12 * (i % 2) + 4 * (i / 2 % 3) + i / 6).collect();
        let options = ReadOptions::default();
        assert_eq!(bytes(&file("|u1", "False", "(2, 3, 4)", &c), &options), c);
        assert_eq!(bytes(&file("|u1", "True", "(2, 3, 4)", &fortran), &options), c);
    }

    #[test]
    fn components_are_few_and_last_and_frames_are_first() {
        let all: Vec<u8> = (0..120).collect();
        let options = ReadOptions { component: Some(1), ..ReadOptions::default() };
        let green = bytes(&file("|u1", "False", "(2, 3, 4, 2)", &all[..48]), &options);
        assert_eq!(green, (0..24).map(|i| 2 * i + 1).collect::<Vec<u8>>());
        // In Fortran order the components come one after the other.
        let planes = file("|u1", "True", "(2, 3, 4, 2)", &all[..48]);
        assert_eq!(bytes(&planes, &options)[..2], [24, 30]);
        let options = ReadOptions { frame: Some(3), ..ReadOptions::default() };
        // A last axis of 4 is one of components; of 5 it is x, so this one is told by its sizes.
        let message = load(&file("|u1", "False", "(5, 2, 3, 4)", &all), &options).map(|_| ()).unwrap_err();
        assert!(message.contains("frame: found 3"), "{message}");
        let (dims, Voxels::U8(third)) = load(&file("|u1", "False", "(4, 2, 3, 5)", &all), &options).unwrap() else {
            panic!("u8")
        };
        assert_eq!((dims, third.as_ref()), ([5, 3, 2], &all[90..]));
        let options = ReadOptions { frame: Some(1), component: Some(1), ..ReadOptions::default() };
        let both = bytes(&file("|u1", "False", "(2, 2, 3, 4, 2)", &(0..96).collect::<Vec<u8>>()), &options);
        assert_eq!(both, (0..24).map(|i| 48 + 2 * i + 1).collect::<Vec<u8>>());
    }

    #[test]
    fn half_floats_of_both_byte_orders() {
        let halves = [0x3c00u16, 0xc000, 0x0001, 0x7bff, 0x3800, 0, 0x4000, 0x4200];
        let expected = [1.0, -2.0, 2f32.powi(-24), 65504.0, 0.5, 0.0, 2.0, 3.0];
        let little: Vec<u8> = halves.iter().flat_map(|h| h.to_le_bytes()).collect();
        let big: Vec<u8> = halves.iter().flat_map(|h| h.to_be_bytes()).collect();
        for (descr, data) in [("<f2", &little), (">f2", &big)] {
            let (_, voxels) = load(&file(descr, "False", "(2, 2, 2)", data), &ReadOptions::default()).unwrap();
            let Voxels::F32(found) = voxels else { panic!("f32") };
            assert_eq!(found.as_ref(), expected);
        }
        let short = load(&file("<f2", "False", "(2, 2, 2)", &little[1..]), &ReadOptions::default());
        assert!(short.map(|_| ()).unwrap_err().contains("claims 16 bytes of voxels, found 15"));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (bytes, word) in [
            (file("|u1", "False", "(2, 2, 2)", &[0; 7]), "claims 8 bytes of voxels, found 7"),
            (file("|u1", "False", "(2, 0, 2)", &[]), "dims [2, 0, 2]"),
            (file("|u1", "False", "(1, 2, 2, 2, 2, 2)", &[0; 32]), "shape: found 1, 2, 2, 2, 2, 2; a volume has"),
            (file("<f8", "False", "(4294967296, 4294967296, 4294967296)", &[]), "dims"),
            (file("<f8", "False", "(2147483647, 2, 2147483647)", &[]), "dims"),
            (file("<f8", "False", "(-1, 2, 2)", &[]), "shape: found -1, 2, 2"),
            (file("<c8", "False", "(2, 2, 2)", &[0; 64]), "descr: found <c8"),
        ] {
            let error = load(&bytes, &ReadOptions::default()).map(|_| ()).unwrap_err();
            assert!(error.contains(word), "no {word:?} in {error}");
        }
    }
}
