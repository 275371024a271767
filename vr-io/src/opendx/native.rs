//! Native files: the regular grid in them, and the numbers of its points, as text or binary, in the file or in another.

use std::io::{BufRead, BufReader};
use std::path::Path;

use glam::DMat3;
use vr_core::{Calibration, Placement};

use crate::decode::with_scalar;
use crate::encoding::invalid;
use crate::error::{FieldError, FileError, FileErrorKind, shown};
use crate::layout::{Axis, Layout, Role};
use crate::notes::Notes;
use crate::packed::Packed;
use crate::payload::{Payload, Segment, Skip};
use crate::read::{Description, ReadOptions};
use crate::scalar::{Endian, ScalarType};
use crate::source::{Decoded, Source};
use crate::world::Space;

use super::objects::{Fault, Objects, Place};

/// Describes the volume of a header.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let in_file = |e: FieldError| e.in_file(path);
    let mut notes = Notes::default();
    let packed = Packed::new(path)?;
    let objects = Objects::read(BufReader::new(packed.reader()?)).map_err(|fault| match fault {
        Fault::Field(e) => in_file(e),
        Fault::Io(e) => packed.damaged(e),
    })?;
    let (grid, array) = objects.data().ok_or_else(|| {
        let (field, found, allowed) = match objects.grids.first() {
            None => (
                "gridpositions",
                "none of three dimensions".to_owned(),
                "must be there: irregular positions are not read".to_owned(),
            ),
            Some(grid) => {
                let items: Vec<String> = objects.arrays.iter().map(|a| a.items.to_string()).collect();
                (
                    "array items",
                    items.join(", "),
                    format!("must be a number for each point of the grid, {:?}", grid.counts),
                )
            }
        };
        in_file(FieldError::new(field, found, allowed))
    })?;

    // The last index of the grid is the fastest.
    let [nx, ny, nz] = grid.counts.map(|size| Axis { size, role: Role::Space });
    let components = usize::try_from(array.components).unwrap_or(usize::MAX);
    let axes = [Axis { size: components, role: Role::Component }, nz, ny, nx];
    let layout = Layout::new(path, &axes, options)?.reversed();
    let [x, y, z] = grid.deltas;
    let placement = Placement::new(grid.origin, DMat3::from_cols(x, y, z)).map_err(|e| FileError::new(path, e))?;

    let folder = path.parent().unwrap_or(Path::new(""));
    let (data, offset) = match &array.place {
        Place::Here(offset) => (packed, *offset),
        Place::Section(offset) => (packed, objects.section.saturating_add(*offset)),
        Place::File(name, offset) => {
            let data = folder.join(name);
            let opened = Packed::new(&data).map_err(|e| match e.kind {
                FileErrorKind::Io(source) => FileError::new(path, FileErrorKind::DataFile { data, source }),
                other => FileError::new(path, other),
            })?;
            (opened, *offset)
        }
    };
    let endian = array.form.endian.unwrap_or_else(|| {
        if array.form.binary && array.scalar.bytes() > 1 {
            // The default of all platforms of old but one.
            notes.push(format!("no byte order in the header: {} is assumed", Endian::Big));
        }
        Endian::Big
    });
    let source: Source = if array.form.binary {
        Payload {
            segments: vec![Segment { path: data.path, start: 0, lines: 0, skip: Skip::Bytes(offset) }],
            encoding: data.encoding,
            scalar: array.scalar,
            endian,
            // Other objects may follow.
            excess_is_error: false,
            hint: "",
        }
        .into()
    } else {
        text(data, offset, array.scalar, layout.total).into()
    };
    Ok(Description {
        format: "OpenDX",
        header: path.into(),
        source,
        layout,
        placement,
        placed_by: "gridpositions",
        calibration: Calibration::default(),
        space: Space::Own,
        units: None,
        scan: None,
        notes,
    })
}

/// Numbers as text, from an offset on; what comes after the last one is no matter.
fn text(data: Packed, offset: u64, scalar: ScalarType, total: usize) -> Decoded {
    let files = vec![data.path.clone()];
    let decode = Box::new(move |_: &mut Vec<String>| {
        let damaged = |source| FileError::new(&data.path, FileErrorKind::Damaged { encoding: "ascii", source });
        let mut lines = BufReader::new(data.reader_after(offset)?);
        let (mut line, mut found, mut out) = (Vec::new(), 0, Vec::new());
        while found < total {
            line.clear();
            if lines.read_until(b'\n', &mut line).map_err(damaged)? == 0 {
                let size = scalar.bytes() as u64;
                let kind = FileErrorKind::Length { claimed: total as u64 * size, found: found as u64 * size, hint: "" };
                return Err(FileError::new(&data.path, kind));
            }
            let words = line.split(|c| c.is_ascii_whitespace() || *c == b',').filter(|w| !w.is_empty());
            for word in words.take(total - found) {
                append(word, scalar, &mut out).ok_or_else(|| {
                    let word = shown(&String::from_utf8_lossy(word));
                    damaged(invalid(format!("number {found} is {word}, no {scalar}")))
                })?;
                found += 1;
            }
        }
        Ok(out)
    });
    Decoded { decode, scalar, endian: Endian::Little, encoding: "ascii", files }
}

/// Appends the number that a word stands for.
fn append(word: &[u8], scalar: ScalarType, out: &mut Vec<u8>) -> Option<()> {
    let word = str::from_utf8(word).ok()?;
    with_scalar!(scalar, S => out.extend(word.parse::<S>().ok()?.to_le_bytes()));
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxels::Voxels;
    use glam::DVec3;

    fn load(file: &[u8], other: &[u8]) -> Result<([usize; 3], Placement, Vec<f32>), String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.dx");
        std::fs::write(&path, file).unwrap();
        std::fs::write(folder.path().join("a b.bin"), other).unwrap();
        let options = ReadOptions { map: false, component: None, ..ReadOptions::default() };
        let Description { source, layout, placement, mut notes, .. } =
            describe(&path, &options).map_err(|e| e.to_string())?;
        let voxels = source.load(&path, &layout, &options, &mut notes).map_err(|e| e.to_string())?;
        let Voxels::F32(found) = voxels else { panic!("f32") };
        Ok((layout.dims, placement, found.as_ref().to_vec()))
    }

    const GRID: &str = "# a comment\nobject 1 class gridpositions counts 4 3 2\norigin 1 2 3\ndelta 2 0.5 0\n\
                        delta 0 3 0\ndelta 0 0 4\nobject 2 class gridconnections counts 4 3 2\n\
                        attribute \"element type\" string \"cubes\"\n";

    /// v(x, y, z) = x + 4 y + 12 z with z the fastest.
    fn numbers() -> Vec<f32> {
        (0..24).map(|i| (i / 6 + 4 * (i / 2 % 3) + 12 * (i % 2)) as f32 + 0.5).collect()
    }

    fn text() -> String {
        numbers().chunks(5).map(|row| row.iter().map(|v| format!("{v} ")).collect::<String>() + "\n").collect()
    }

    const FIELD: &str = "attribute \"dep\" string \"positions\"\nobject \"f\" class field\ncomponent \"positions\" value 1\n\
                         component \"data\" value 3\nend\n";

    #[test]
    fn text_and_binary_in_every_place() {
        let array = "object 3 class array type float rank 0 items 24";
        let big: Vec<u8> = numbers().iter().flat_map(|v| v.to_be_bytes()).collect();
        let little: Vec<u8> = numbers().iter().flat_map(|v| v.to_le_bytes()).collect();
        let join = |parts: &[&[u8]]| parts.concat();
        let grid = GRID.as_bytes();
        let files = [
            join(&[grid, format!("{array} data follows\n{}{FIELD}", text()).as_bytes()]),
            // The array first: its numbers are passed over, and found again.
            join(&[format!("{array}\ndata follows\n{}{GRID}{FIELD}", text()).as_bytes()]),
            join(&[format!("{array} lsb binary data follows\n").as_bytes(), &little, b"\n", grid, FIELD.as_bytes()]),
            join(&[grid, format!("{array} msb ieee data follows\n").as_bytes(), &big, b"\n", FIELD.as_bytes()]),
            join(&[grid, format!("{array} lsb ieee\ndata 2\n{FIELD}").as_bytes(), b"..", &little]),
            join(&[grid, format!("{array} data 0\n{FIELD}").as_bytes(), text().as_bytes()]),
            join(&[grid, format!("{array} binary data file \"a b.bin\",4\n{FIELD}").as_bytes()]),
        ];
        let other = join(&[b"....", &big]);
        let expected: Vec<f32> = (0..24).map(|i| i as f32 + 0.5).collect();
        for (i, file) in files.iter().enumerate() {
            let (dims, placement, found) = load(file, &other).unwrap_or_else(|e| panic!("{i}: {e}"));
            assert_eq!((dims, &found), ([4, 3, 2], &expected), "{i}");
            assert_eq!(placement.to_world(DVec3::new(1.0, 1.0, 1.0)), DVec3::new(3.0, 5.5, 7.0));
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let grid = |rest: &str| format!("{GRID}{rest}");
        for (file, word) in [
            (grid("object 3 class array type float rank 0 items 24 data follows\n1 2 3\n"), "claims 96 bytes of voxels, found 12"),
            (grid("object 3 class array type float rank 0 items 24 data follows\n1 2 x\n"), "number 2 is x, no f32"),
            (grid("object 3 class array type float rank 0 items 6 data follows\n1 2 3 4 5 6\n"), "array items: found 6"),
            (grid("object 3 class array type string rank 1 shape 2 items 24 data follows\n"), "array items: found nothing"),
            (grid("object 3 class array type quaternion items 24 data follows\n"), "type: found quaternion"),
            (grid("object 3 class array type float items many data follows\n"), "items: found many"),
            (grid("object 3 class array type float items 24 data file gone.bin,0\n"), "gone.bin"),
            (grid("object 3 class array type float items 24 msb binary data 10\nend\n"), "claims 96 bytes of voxels, found 0"),
            (grid("object 3 class array type float items 24 binary data -1\nend\n"), "data: found -1"),
            (GRID.replace("4 3 2\norigin", "4 3\norigin"), "gridpositions: found none of three dimensions"),
            (GRID.replace("delta 0 3 0\n", ""), "gridpositions: found 2 lines of delta"),
            (GRID.replace("delta 0 3 0", "delta 0 3"), "delta: found 0 3"),
            (GRID.replace("delta 0 3 0", "delta 4 1 0") + "object 3 class array items 24 data 0\nend\n", "is singular"),
            ("object 1 class gridpositions counts 99999 99999 99999\nobject 3 class array items 999970000299999 data follows\n1\n".into(), "claims 3999880001199996 bytes of voxels, found 4"),
            ("object 1 class array items 18446744073709551615 lsb binary data follows\n....".into(), "gridpositions: found none"),
        ] {
            let message = load(file.as_bytes(), &[]).map(|_| ()).unwrap_err();
            assert!(message.contains(word), "no {word:?} in {message}");
        }
    }
}
