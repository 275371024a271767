//! MRC and CCP4 maps of electron microscopy and crystallography: <https://www.ccpem.ac.uk/mrc-format/mrc2014/> (Cheng et al. 2015,
//! "MRC2014: Extensions to the MRC format header for electron cryo-microscopy and tomography", J. Struct. Biol. 192(2)).
//!
//! Voxels stay in the order of the file: columns, rows, sections. The placement says along which axes of the cell these run, and shears
//! the grid as the angles of the cell do.

mod cell;
mod header;

use std::path::Path;

use vr_core::Calibration;

use crate::error::{FieldError, FileError};
use crate::float16;
use crate::layout::{Axis, Layout, Role};
use crate::notes::Notes;
use crate::packed::Packed;
use crate::payload::{Payload, Segment, Skip};
use crate::read::{Description, ReadOptions};
use crate::scalar::ScalarType;
use crate::world::Space;

use header::Header;

/// Name of the format.
pub(crate) const FORMAT: &str = "MRC";

/// True if the beginning of a file is that of a map, from the version of 2000 on; older ones are told by their names.
pub(crate) fn is_mrc(head: &[u8]) -> bool {
    head.get(208..).is_some_and(|rest| rest.starts_with(b"MAP "))
}

/// Describes the volume of a header.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let in_file = |e: FieldError| e.in_file(path);
    let mut notes = Notes::default();
    let packed = Packed::new(path)?;
    let header = Header::parse(&packed.head(header::LENGTH)?, &mut notes).map_err(in_file)?;
    let mode = Mode::new(&header, &mut notes).map_err(in_file)?;
    let layout = Layout::new(path, &axes(&header, &mut notes).map_err(in_file)?, options)?;
    let placed = cell::place(&header, &mut notes).map_err(in_file)?;
    let placement = Space::Own.place(placed.origin, placed.axes).map_err(|e| FileError::new(path, e))?;

    let skip = Skip::Bytes(header::LENGTH + header.extended);
    let payload = Payload {
        segments: vec![Segment { path: path.into(), start: 0, lines: 0, skip }],
        encoding: packed.encoding,
        scalar: match mode {
            Mode::Number(scalar) => scalar,
            Mode::Half => ScalarType::U16,
        },
        endian: header.endian,
        // Writers pad.
        excess_is_error: false,
        hint: " (are NX, NY, NZ, MODE and NSYMBT right?)",
    };
    Ok(Description {
        format: FORMAT,
        header: path.into(),
        source: match mode {
            Mode::Number(_) => payload.into(),
            Mode::Half => float16::source(payload, path, &layout, options),
        },
        layout,
        placement,
        placed_by: placed.by,
        calibration: Calibration::default(),
        space: Space::Own,
        units: (placed.by == "cell").then(|| "Å".to_owned()),
        scan: None,
        notes,
    })
}

/// Type of the voxels.
#[derive(Clone, Copy)]
enum Mode {
    Number(ScalarType),
    /// 16-bit floats.
    Half,
}

impl Mode {
    fn new(header: &Header, notes: &mut Vec<String>) -> Result<Self, FieldError> {
        let refuse = |name: &str| {
            let allowed = "must be 0 (i8), 1 (i16), 2 (f32), 6 (u16) or 12 (f16)";
            Err(FieldError::new("MODE", format_args!("{} ({name})", header.mode), allowed))
        };
        Ok(Self::Number(match header.mode {
            0 if header.unsigned_bytes => {
                notes.push("bytes count as unsigned, as IMOD wrote them".into());
                ScalarType::U8
            }
            0 => ScalarType::I8,
            1 => ScalarType::I16,
            2 => ScalarType::F32,
            6 => ScalarType::U16,
            12 => {
                notes.push(float16::NOTE.into());
                return Ok(Self::Half);
            }
            3 => return refuse("complex numbers of two i16"),
            4 => return refuse("complex numbers of two f32"),
            16 => return refuse("colours"),
            101 => return refuse("half bytes"),
            _ => return refuse("unknown"),
        }))
    }
}

fn axes(header: &Header, notes: &mut Vec<String>) -> Result<Vec<Axis>, FieldError> {
    let [columns, rows, sections] = header.size;
    // ISPG tells images from volumes, and stacks of volumes from one.
    let sections = match header.space_group {
        401..=630 => {
            let depth = usize::try_from(header.intervals[2]).ok().filter(|&n| n > 0 && sections.is_multiple_of(n));
            let allowed =
                format!("must divide the {sections} sections (NZ) of a stack of volumes (ISPG {})", header.space_group);
            let depth = depth.ok_or_else(|| FieldError::new("MZ", header.intervals[2], allowed))?;
            vec![(depth, Role::Space), (sections / depth, Role::Frame)]
        }
        0 if sections > 1 => {
            notes.push("ISPG is 0: a stack of images, or a tomogram; it is read as a volume".into());
            vec![(sections, Role::Space)]
        }
        _ => vec![(sections, Role::Space)],
    };
    let all = [(columns, Role::Space), (rows, Role::Space)].into_iter().chain(sections);
    Ok(all.map(|(size, role)| Axis { size, role }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scalar::Endian;
    use crate::voxels::Voxels;
    use glam::DVec3;
    use vr_core::Placement;

    /// A header of 4 columns, 3 rows and 2 sections in a cell of 8×9×10 Å with 4×3×2 intervals, of numbers by their offsets.
    fn header(endian: Endian, numbers: &[(usize, i32)]) -> Vec<u8> {
        let mut bytes = vec![0; 1024];
        let mut put = |offset: usize, n: i32| {
            let b = if endian == Endian::Big { n.to_be_bytes() } else { n.to_le_bytes() };
            bytes[offset..offset + 4].copy_from_slice(&b);
        };
        let float = |x: f32| x.to_bits() as i32;
        for (i, n) in [4, 3, 2, 1].into_iter().enumerate() {
            put(4 * i, n);
        }
        for (i, n) in [4, 3, 2].into_iter().enumerate() {
            put(28 + 4 * i, n);
            put(40 + 4 * i, float([8.0, 9.0, 10.0][i]));
            put(52 + 4 * i, float(90.0));
            put(64 + 4 * i, i as i32 + 1);
        }
        put(88, 1);
        for &(offset, n) in numbers {
            put(offset, n);
        }
        bytes[208..212].copy_from_slice(b"MAP ");
        bytes[212..214].copy_from_slice(if endian == Endian::Big { &[0x11, 0x11] } else { &[0x44, 0x44] });
        bytes
    }

    type Read = (Placement, Voxels, [usize; 3], Vec<String>);

    fn load(file: &[u8], options: &ReadOptions) -> Result<Read, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mrc");
        std::fs::write(&path, file).unwrap();
        let options = ReadOptions { map: false, ..options.clone() };
        let Description { source, layout, placement, mut notes, .. } =
            describe(&path, &options).map_err(|e| e.to_string())?;
        let voxels = source.load(&path, &layout, &options, &mut notes).map_err(|e| e.to_string())?;
        Ok((placement, voxels, layout.dims, notes.into_lines()))
    }

    fn plain(file: &[u8]) -> Read {
        load(file, &ReadOptions::default()).unwrap()
    }

    fn shorts(endian: Endian, count: i16) -> Vec<u8> {
        (0..count)
            .flat_map(|i| if endian == Endian::Big { (i - 5).to_be_bytes() } else { (i - 5).to_le_bytes() })
            .collect()
    }

    #[test]
    fn both_byte_orders_and_an_extended_header() {
        for endian in [Endian::Little, Endian::Big] {
            let file = [header(endian, &[(92, 3)]), vec![9; 3], shorts(endian, 24)].concat();
            let (placement, voxels, dims, notes) = plain(&file);
            let Voxels::I16(found) = voxels else { panic!("i16") };
            assert_eq!((dims, found.as_ref()), ([4, 3, 2], (-5..19).collect::<Vec<i16>>().as_slice()));
            assert_eq!(placement.spacing(), DVec3::new(2.0, 3.0, 5.0));
            assert!(notes.is_empty(), "{notes:?}");
            // Without a stamp, the sizes tell.
            let mut file = file;
            file[212..216].fill(0);
            assert!(plain(&file).3[0].contains(&format!("{endian} numbers are assumed")));
        }
    }

    #[test]
    fn modes() {
        let file = |mode, data: &[u8]| [&header(Endian::Little, &[(12, mode)]), data].concat();
        assert!(matches!(plain(&file(0, &[255; 24])).1, Voxels::I8(v) if v.as_ref() == [-1; 24]));
        assert!(matches!(plain(&file(2, &[0; 96])).1, Voxels::F32(_)));
        assert!(matches!(plain(&file(6, &[255; 48])).1, Voxels::U16(v) if v.as_ref() == [65535; 24]));
        let (_, voxels, _, notes) = plain(&file(12, &[0x00, 0x3c].repeat(24)));
        assert!(matches!(voxels, Voxels::F32(v) if v.as_ref() == [1.0; 24]));
        assert!(notes[0].contains("16-bit floats"), "{notes:?}");
        let imod = header(Endian::Little, &[(12, 0), (152, 0x444f_4d49)]);
        assert!(matches!(plain(&[imod, vec![255; 24]].concat()).1, Voxels::U8(_)));
    }

    #[test]
    fn axes_are_permuted_and_moved() {
        // Columns along Z, rows along X, sections along Y; first column 7, row −1, section 2.
        let numbers = [(64, 3), (68, 1), (72, 2), (16, 7), (20, -1), (24, 2)];
        let file = |more: &[(usize, i32)]| {
            [header(Endian::Little, &[&numbers, more].concat()), shorts(Endian::Little, 24)].concat()
        };
        let (placement, ..) = plain(&file(&[]));
        let steps = [DVec3::Z * 5.0, DVec3::X * 2.0, DVec3::Y * 3.0];
        let axes = placement.axes();
        assert_eq!([axes.x_axis, axes.y_axis, axes.z_axis], steps);
        assert_eq!(placement.origin(), DVec3::new(-2.0, 6.0, 35.0));
        // ORIGIN is along X, Y and Z.
        let (placement, _, _, notes) = plain(&file(&[(196, 1.5f32.to_bits() as i32)]));
        assert_eq!(placement.origin(), DVec3::new(1.5, 0.0, 0.0));
        assert!(notes[0].contains("ORIGIN places the volume"), "{notes:?}");
    }

    #[test]
    fn stacks_of_volumes_have_frames() {
        let header = header(Endian::Little, &[(88, 401), (8, 6), (36, 2)]);
        let file = [header, shorts(Endian::Little, 72)].concat();
        let (_, voxels, dims, _) = load(&file, &ReadOptions { frame: Some(2), ..ReadOptions::default() }).unwrap();
        let Voxels::I16(found) = voxels else { panic!("i16") };
        assert_eq!((dims, found.as_ref()[0]), ([4, 3, 2], 43));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (numbers, word) in [
            (vec![(8, 3)], "claims 72 bytes of voxels, found 48"),
            (vec![(8, 0)], "NZ: found 0"),
            (vec![(0, -4)], "NX: found -4"),
            (vec![(0, i32::MAX), (4, i32::MAX), (8, i32::MAX)], "dims"),
            (vec![(12, 3)], "MODE: found 3 (complex"),
            (vec![(12, 4)], "MODE: found 4 (complex"),
            (vec![(12, 101)], "MODE: found 101 (half bytes)"),
            (vec![(12, 99)], "MODE: found 99 (unknown)"),
            (vec![(64, 2)], "MAPC, MAPR, MAPS: found [2, 2, 3]"),
            (vec![(92, -1)], "NSYMBT: found -1"),
            (vec![(92, i32::MAX)], "claims 48 bytes of voxels, found 0"),
            (vec![(28, 0)], "MX: found 0"),
            (vec![(40, 0)], "CELLA: found 0"),
            (vec![(52, 180f32.to_bits() as i32)], "CELLB: found"),
            (vec![(196, f32::NAN.to_bits() as i32)], "origin"),
            (vec![(88, 401), (36, 0)], "MZ: found 0"),
        ] {
            let file = [header(Endian::Little, &numbers), shorts(Endian::Little, 24)].concat();
            let message = load(&file, &ReadOptions::default()).map(|_| ()).unwrap_err();
            assert!(message.contains(word), "no {word:?} in {message}");
        }
        let cut = load(&header(Endian::Little, &[])[..1000], &ReadOptions::default());
        assert!(cut.map(|_| ()).unwrap_err().contains("header: found 1000 bytes"));
    }
}
