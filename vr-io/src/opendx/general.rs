//! Headers of the General Array Importer: lines of `keyword = values` that describe a file of numbers.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use glam::{DMat3, DVec3};
use vr_core::{Calibration, Placement};

use crate::encoding::Encoding;
use crate::error::{FieldError, FileError, FileErrorKind, shown_path};
use crate::header_text::HeaderText;
use crate::layout::{Axis, Layout, Role};
use crate::notes::Notes;
use crate::payload::{Payload, Segment, Skip};
use crate::read::{Description, ReadOptions, file_head};
use crate::regular_file;
use crate::scalar::{Endian, ScalarType};
use crate::world::Space;

use super::keyword::{Form, TYPES, scalar_type};

/// Describes the volume of a header.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let in_file = |e: FieldError| e.in_file(path);
    let header = Header::read(path)?;
    let mut notes = Notes::default();
    header.check_unread().map_err(in_file)?;
    let form = header.form().map_err(in_file)?;
    let values = header.values().map_err(in_file)?;
    let layout = header.layout(path, &values, options)?;
    let positions = header.positions().map_err(in_file)?;
    if positions.is_none() {
        notes.push("no positions in the header: the origin 0, 0, 0 and steps of 1, 1, 1 are its default".into());
    }
    let (origin, steps) = positions.unwrap_or((DVec3::ZERO, DVec3::ONE));
    let placement = Placement::new(origin, DMat3::from_diagonal(steps)).map_err(|e| FileError::new(path, e))?;

    let endian = form.endian.unwrap_or_else(|| {
        if form.binary && values.scalar.bytes() > 1 {
            notes.push(format!("no byte order in the header: {} is assumed", Endian::NATIVE));
        }
        Endian::NATIVE
    });
    let segment = header.segment(path)?;
    let packing = match file_head(&segment.path) {
        Ok(head) if segment.path != path => Encoding::of_file(&head),
        // A file that is not there is named when it is opened.
        _ => Encoding::Raw,
    };
    let payload = Payload {
        encoding: if form.binary { packing } else { Encoding::Text },
        segments: vec![segment],
        scalar: values.scalar,
        endian,
        excess_is_error: false,
        hint: " (are grid, type and header right?)",
    };
    Ok(Description {
        format: "OpenDX (general)",
        header: path.into(),
        source: payload.into(),
        layout,
        placement,
        placed_by: if positions.is_some() { "positions" } else { "assumed" },
        calibration: Calibration::default(),
        space: Space::Own,
        units: None,
        scan: None,
        notes,
    })
}

/// The keywords that are understood.
const KEYWORDS: [&str; 16] = [
    "block",
    "dependency",
    "field",
    "file",
    "format",
    "grid",
    "header",
    "interleaving",
    "layout",
    "majority",
    "points",
    "positions",
    "recordseparator",
    "series",
    "structure",
    "type",
];

/// Keywords and their values, as text.
#[derive(Debug, Default)]
struct Header {
    values: BTreeMap<String, String>,
    /// Bytes up to the line after `end`.
    length: u64,
}

/// Numbers at each point of the grid.
#[derive(Debug, PartialEq)]
struct Values {
    scalar: ScalarType,
    /// Fields, or components of the one field.
    count: usize,
    place: Interleaving,
}

/// Place of the fields or components among the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Interleaving {
    /// All values of a point together.
    Point,
    /// All values of a field or component at one time together.
    Record,
    /// All values of a field at all times together.
    Series,
}

impl Header {
    fn read(path: &Path) -> Result<Self, FileError> {
        let mut text = HeaderText::open(path)?;
        loop {
            let line = text.next_line()?;
            if line.is_empty() || line.trim_ascii().eq_ignore_ascii_case(b"end") {
                break;
            }
        }
        Self::parse(&text.into_bytes()).map_err(|e| e.in_file(path))
    }

    fn parse(text: &[u8]) -> Result<Self, FieldError> {
        let mut header = Self { length: text.len() as u64, ..Self::default() };
        let mut last = String::new();
        for line in text.split(|&c| c == b'\n') {
            let line = String::from_utf8_lossy(line);
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') || line.eq_ignore_ascii_case("end") {
                continue;
            }
            let statement = line.split_once('=').map(|(key, value)| (key.trim().to_lowercase(), value.trim()));
            match statement {
                Some((key, value)) if KEYWORDS.contains(&key.as_str()) => {
                    header.values.insert(key.clone(), value.to_owned());
                    last = key;
                }
                // Numbers of positions may go on for lines.
                None if last == "positions" => {
                    let value = header.values.entry(last.clone()).or_default();
                    *value += " ";
                    *value += line;
                }
                _ => {
                    let allowed = format!("must be 'keyword = values' with one of {}", KEYWORDS.join(", "));
                    return Err(FieldError::new("header line", line, allowed));
                }
            }
        }
        Ok(header)
    }

    fn get(&self, key: &str) -> Option<&str> {
        self.values.get(key).map(String::as_str)
    }

    /// Values between commas.
    fn list(&self, key: &str) -> Vec<&str> {
        self.get(key).map(|value| value.split(',').map(str::trim).collect()).unwrap_or_default()
    }

    /// Refuses what would put numbers elsewhere.
    fn check_unread(&self) -> Result<(), FieldError> {
        for (key, allowed) in [
            ("points", "scattered points are not read from these files; a volume has a grid"),
            ("block", "columns of text are not read"),
            ("layout", "columns of text are not read"),
            ("recordseparator", "numbers must follow each other"),
        ] {
            if let Some(found) = self.get(key) {
                return Err(FieldError::new(key, found, allowed));
            }
        }
        if let Some(found) = self.list("dependency").into_iter().find(|d| !d.eq_ignore_ascii_case("positions")) {
            return Err(FieldError::new("dependency", found, "must be positions: values of cells are not read"));
        }
        if let Some(found) = self.list("field").into_iter().find(|f| f.eq_ignore_ascii_case("locations")) {
            return Err(FieldError::new("field", found, "positions among the data are not read"));
        }
        Ok(())
    }

    fn form(&self) -> Result<Form, FieldError> {
        let mut form = Form::default();
        let text = self.get("format").unwrap_or_default();
        if let Some(word) = text.split_whitespace().find(|word| !form.set(word)) {
            return Err(FieldError::new("format", word, "must be msb or lsb, and ascii, text, binary or ieee"));
        }
        Ok(form)
    }

    fn values(&self) -> Result<Values, FieldError> {
        let types = self.list("type");
        let mut scalar = None;
        for name in &types {
            let found = scalar_type(name.split_whitespace()).ok_or_else(|| FieldError::new("type", name, TYPES))?;
            if scalar.is_some_and(|other| other != found) {
                return Err(FieldError::new("type", types.join(", "), "must be one type for all fields"));
            }
            scalar = Some(found);
        }
        let structures: Vec<usize> = self
            .list("structure")
            .into_iter()
            .map(|text| {
                let length = match text.to_lowercase().as_str() {
                    "scalar" => Some(1),
                    other => other
                        .strip_suffix("-vector")
                        .and_then(|n| n.trim().parse().ok())
                        .filter(|n| (1..=9).contains(n)),
                };
                length.ok_or_else(|| FieldError::new("structure", text, "must be scalar, or 2-vector to 9-vector"))
            })
            .collect::<Result<_, _>>()?;
        let fields = [types.len(), structures.len(), self.list("field").len()].into_iter().fold(1, usize::max);
        let interleaving = self.get("interleaving").unwrap_or("record-vector").to_lowercase();
        let (count, place) = match (fields, structures.iter().copied().max().unwrap_or(1), interleaving.as_str()) {
            (_, 1, "field") => (fields, Interleaving::Point),
            (_, 1, "record" | "record-vector") => (fields, Interleaving::Record),
            (_, 1, "series-vector") => (fields, Interleaving::Series),
            (1, n, "record") => (n, Interleaving::Record),
            (1, n, "field" | "record-vector" | "series-vector") => (n, Interleaving::Point),
            (_, _, "field" | "record" | "record-vector" | "series-vector") => {
                let found = self.get("structure").unwrap_or_default();
                return Err(FieldError::new("structure", found, "must be one vector, or scalars alone"));
            }
            (_, _, other) => {
                let allowed = "must be field, record, record-vector or series-vector";
                return Err(FieldError::new("interleaving", other, allowed));
            }
        };
        Ok(Values { scalar: scalar.unwrap_or(ScalarType::F32), count, place })
    }

    fn sizes(&self) -> Result<[usize; 3], FieldError> {
        let text = self.get("grid").unwrap_or_default();
        let sizes: Option<Vec<usize>> =
            text.split(['x', 'X']).map(|n| n.trim().parse().ok().filter(|&n| n > 0)).collect();
        sizes
            .and_then(|s| s.try_into().ok())
            .ok_or_else(|| FieldError::new("grid", text, "must be three sizes, as in 64x64x32"))
    }

    fn frames(&self) -> Result<usize, FieldError> {
        let Some(text) = self.get("series") else { return Ok(1) };
        if text.to_lowercase().contains("separator") {
            return Err(FieldError::new("series", text, "must be without separator: numbers must follow each other"));
        }
        let frames = text.split(',').next().and_then(|n| n.trim().parse().ok()).filter(|&n: &usize| n > 0);
        frames.ok_or_else(|| FieldError::new("series", text, "must begin with a number of 1 or more"))
    }

    fn layout(&self, path: &Path, values: &Values, options: &ReadOptions) -> Result<Layout, FileError> {
        let in_file = |e: FieldError| e.in_file(path);
        let row_major = match self.get("majority").unwrap_or("row").to_lowercase().as_str() {
            "row" => true,
            "column" => false,
            other => return Err(in_file(FieldError::new("majority", other, "must be row or column"))),
        };
        let mut sizes = self.sizes().map_err(in_file)?;
        if row_major {
            sizes.reverse();
        }
        let mut axes = sizes.map(|size| Axis { size, role: Role::Space }).to_vec();
        axes.push(Axis { size: self.frames().map_err(in_file)?, role: Role::Frame });
        let at = match values.place {
            Interleaving::Point => 0,
            Interleaving::Record => 3,
            Interleaving::Series => 4,
        };
        axes.insert(at, Axis { size: values.count, role: Role::Component });
        let layout = Layout::new(path, &axes, options)?;
        Ok(if row_major { layout.reversed() } else { layout })
    }

    /// Origin and steps, if the header has them.
    fn positions(&self) -> Result<Option<(DVec3, DVec3)>, FieldError> {
        let Some(text) = self.get("positions") else { return Ok(None) };
        let words: Vec<&str> = text.split([',', ' ', '\t']).filter(|w| !w.is_empty()).collect();
        let kinds = words.iter().take_while(|w| w.parse::<f64>().is_err()).count();
        let (kinds, numbers) = words.split_at(kinds);
        let regular = kinds.is_empty() || kinds.len() == 3 && kinds.iter().all(|k| k.eq_ignore_ascii_case("regular"));
        let numbers: Option<Vec<f64>> = numbers.iter().map(|n| n.parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[x, dx, y, dy, z, dz]) if regular => Ok(Some((DVec3::new(x, y, z), DVec3::new(dx, dy, dz)))),
            _ => {
                let allowed = "must be origin and step along each of three axes; irregular positions are not read";
                Err(FieldError::new("positions", text, allowed))
            }
        }
    }

    /// Place of the numbers.
    fn segment(&self, path: &Path) -> Result<Segment, FileError> {
        let in_file = |e: FieldError| e.in_file(path);
        let file = self.get("file").map(|name| name.trim_matches('"'));
        let data = file.map_or_else(|| path.to_path_buf(), |name| path.parent().unwrap_or(Path::new("")).join(name));
        let mut segment = Segment { path: data, start: 0, lines: 0, skip: Skip::Bytes(0) };
        let Some(text) = self.get("header") else {
            if file.is_none() {
                segment.start = self.length;
            }
            return Ok(segment);
        };
        let wrong = || FieldError::new("header", text, "must be bytes N, lines N or marker \"text\"");
        let (word, rest) = text.split_once(char::is_whitespace).ok_or_else(|| in_file(wrong()))?;
        let number = || rest.trim().parse().map_err(|_| in_file(wrong()));
        match word.to_lowercase().as_str() {
            // Where there is no compression, these are the same; text knows no bytes to skip.
            "bytes" if self.form().map_err(in_file)?.binary => segment.skip = Skip::Bytes(number()?),
            "bytes" => segment.start = number()?,
            "lines" => segment.lines = number()?,
            "marker" => segment.start = after_marker(path, &segment.path, &unescaped(rest.trim().trim_matches('"')))?,
            _ => return Err(in_file(wrong())),
        }
        Ok(segment)
    }
}

/// Offset of the first byte after some text in a file.
fn after_marker(header: &Path, data: &Path, marker: &[u8]) -> Result<u64, FileError> {
    const SEARCHED: u64 = 1 << 24;
    let io = |source| FileError::new(header, FileErrorKind::DataFile { data: data.into(), source });
    let mut head = Vec::new();
    regular_file::open(data).map_err(io)?.take(SEARCHED).read_to_end(&mut head).map_err(io)?;
    // Where the header is in the same file, it names the marker too: that one does not count.
    let own = format!("marker \"{}", String::from_utf8_lossy(marker));
    let found = (!marker.is_empty()).then(|| {
        (0..head.len().saturating_sub(marker.len() - 1))
            .find(|&i| head[i..].starts_with(marker) && !head[..i + marker.len()].ends_with(own.as_bytes()))
    });
    match found.flatten() {
        Some(at) => Ok((at + marker.len()) as u64),
        None => {
            let allowed = format!("must be text in the first {SEARCHED} bytes of {}", shown_path(data));
            Err(FieldError::new("header marker", String::from_utf8_lossy(marker), allowed).in_file(header))
        }
    }
}

/// The bytes that text with backslashes stands for.
fn unescaped(text: &str) -> Vec<u8> {
    let mut out = Vec::new();
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        out.push(match byte {
            b'\\' => match rest.next() {
                Some(b'n') => b'\n',
                Some(b't') => b'\t',
                Some(b'r') => b'\r',
                Some(other) => other,
                None => b'\\',
            },
            other => other,
        });
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxels::Voxels;

    fn load_with(header: &str, data: &[u8], options: &ReadOptions) -> Result<(Description, Vec<i16>), String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.general");
        std::fs::write(&path, header).unwrap();
        std::fs::write(folder.path().join("a.data"), data).unwrap();
        let mut description = describe(&path, options).map_err(|e| e.to_string())?;
        let placeholder = crate::source::Decoded {
            decode: Box::new(|_: &mut Vec<String>| Ok(Vec::new())),
            scalar: ScalarType::U8,
            endian: Endian::NATIVE,
            encoding: "",
            files: Vec::new(),
        };
        let source = std::mem::replace(&mut description.source, placeholder.into());
        let voxels = source.load(&path, &description.layout, options, &mut description.notes);
        let Voxels::I16(found) = voxels.map_err(|e| e.to_string())? else { panic!("i16") };
        let found = found.as_ref().to_vec();
        Ok((description, found))
    }

    fn load(header: &str, data: &[u8]) -> Result<(Description, Vec<i16>), String> {
        load_with(header, data, &ReadOptions { map: false, ..ReadOptions::default() })
    }

    /// Numbers 0 to 23 in an order, from the function of their place.
    fn in_order(place: impl Fn(i16) -> i16) -> Vec<i16> {
        (0..24).map(place).collect()
    }

    /// v(x, y, z) = x + 4 y + 12 z with z the fastest.
    fn row_major() -> Vec<u8> {
        in_order(|i| i / 6 + 4 * (i / 2 % 3) + 12 * (i % 2)).iter().flat_map(|v| v.to_be_bytes()).collect()
    }

    #[test]
    fn rows_columns_and_text() {
        let expected = in_order(|i| i);
        let common = "# made here\nfile = a.data\ngrid = 4 x 3x2\ntype = short\n";
        let positions = "positions = regular, regular, regular,\n 1, 2, 3\n 4 5, 6\nend\n";
        let column: Vec<u8> = expected.iter().flat_map(|v| v.to_be_bytes()).collect();
        let text: Vec<u8> = row_major()
            .as_chunks::<2>()
            .0
            .iter()
            .flat_map(|b| format!("{}\n", i16::from_be_bytes(*b)).into_bytes())
            .collect();
        for (form, data) in [
            ("format = msb binary\n", row_major()),
            ("format = binary msb\nmajority = column\n", column),
            ("header = lines 2\n", [b"two\nlines\n".as_slice(), &text].concat()),
            ("format = ascii\nheader = marker \"voxels:\\n\"\n", [b"voxels\nvoxels:\n".as_slice(), &text].concat()),
            ("format = msb ieee\nheader = bytes 3\n", [b"\0\0\0".as_slice(), &row_major()].concat()),
        ] {
            let (description, found) = load(&format!("{common}{form}{positions}"), &data).unwrap();
            assert_eq!(found, expected, "{form}");
            assert_eq!(description.layout.dims, [4, 3, 2]);
            assert_eq!(description.placement.origin(), DVec3::new(1.0, 3.0, 5.0));
            assert_eq!(description.placement.spacing(), DVec3::new(2.0, 4.0, 6.0));
        }
    }

    #[test]
    fn numbers_after_the_header() {
        let numbers: String =
            row_major().as_chunks::<2>().0.iter().map(|b| format!("{} ", i16::from_be_bytes(*b))).collect();
        let (description, found) = load(&format!("grid = 4x3x2\ntype = short\nend\n{numbers}"), &[]).unwrap();
        assert_eq!(found, in_order(|i| i));
        assert!(description.notes[0].contains("steps of 1, 1, 1"), "{:?}", description.notes);
    }

    #[test]
    fn fields_vectors_and_series() {
        // Two of each: 96 numbers that tell their places in the file.
        let data: Vec<u8> = (0..96i16).flat_map(i16::to_be_bytes).collect();
        let common = "file = a.data\ngrid = 4x3x2\nmajority = column\nformat = msb binary\nseries = 2, 0, 1\n";
        let options = ReadOptions { frame: Some(1), component: Some(1), map: false, ..ReadOptions::default() };
        for (fields, first, step) in [
            ("type = short, short\ninterleaving = field", 49, 2),
            ("type = short, short\ninterleaving = record", 72, 1),
            ("type = short, short\ninterleaving = series-vector", 72, 1),
            ("type = short\nstructure = 2-vector", 49, 2),
            ("type = short\nstructure = 2-vector\ninterleaving = record", 72, 1),
        ] {
            let (_, found) = load_with(&format!("{common}{fields}\n"), &data, &options).unwrap();
            assert_eq!(found, in_order(|i| first + step * i), "{fields}");
        }
        let options = ReadOptions { frame: Some(0), ..options };
        for (place, first) in [("record", 24), ("series-vector", 48)] {
            let header = format!("{common}type = short, short\ninterleaving = {place}\n");
            assert_eq!(load_with(&header, &data, &options).unwrap().1[0], first, "{place}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let common = "file = a.data\ntype = short\nformat = msb binary\n";
        for (lines, word) in [
            ("grid = 4x3x2", "claims 48 bytes of voxels, found 8"),
            ("grid = 4x3", "grid: found 4x3; must be three"),
            ("grid = 4x0x2", "grid: found 4x0x2"),
            ("grid = 4x-3x2", "grid: found 4x-3x2"),
            ("grid = 4294967295x4294967295x4294967295", "dims"),
            ("grid = 4x3x2\ntype = string", "type: found string"),
            ("grid = 4x3x2\ntype = short, float", "type: found short, float; must be one type"),
            ("grid = 4x3x2\nstructure = scalar, 3-vector", "structure: found scalar, 3-vector"),
            ("grid = 4x3x2\nstructure = 10-vector", "structure: found 10-vector"),
            ("grid = 4x3x2\ndependency = connections", "values of cells"),
            ("grid = 4x3x2\nfield = a, locations", "positions among the data"),
            ("grid = 4x3x2\npositions = irregular, regular, regular, 1, 2, 4, 8, 0, 1, 0, 1", "irregular positions"),
            ("grid = 4x3x2\npositions = 0, 1, 0, 1", "positions: found 0, 1, 0, 1"),
            ("grid = 4x3x2\npositions = 0, 0, 0, 1, 0, 1", "spacing of axis 0"),
            ("grid = 4x3x2\nseries = 2, separator = lines 1", "series: found"),
            ("grid = 4x3x2\nmajority = diagonal", "majority: found diagonal"),
            ("grid = 4x3x2\nformat = packed", "format: found packed"),
            ("grid = 4x3x2\nheader = marker \"none\"", "header marker: found none"),
            ("grid = 4x3x2\nheader = bytes -1", "header: found bytes -1"),
            ("points = 24", "points: found 24"),
            ("gird = 4x3x2", "header line: found gird"),
            ("grid = 4x3x2\nfile = missing.data", "missing.data"),
        ] {
            let message = load(&format!("{common}{lines}\n"), &[0; 8]).map(|_| ()).unwrap_err();
            assert!(message.contains(word), "no {word:?} in {message}");
        }
    }
}
