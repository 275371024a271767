//! Points of legacy VTK files (.vtk, versions up to 5.1), text and binary: of POLYDATA and UNSTRUCTURED_GRID.
//!
//! Own code: `vtkio`, the crate at hand, does not know fields before the points, and drops, without a word, an array of a type that it does not
//! know and all that follow.

use std::ops::Range;

use crate::error::shown;
use crate::scalar::{Endian, ScalarType};

use super::error::Trouble;
use super::roles::Roles;
use super::{Column, Found, Numbering, PointOptions, Table, numbers};

/// Whether the beginning of a file is that of a legacy VTK file with a kind of data that has points of its own.
pub(super) fn holds_points(head: &[u8]) -> bool {
    let kind = |line: &[u8]| matches!(line.trim_ascii(), b"DATASET POLYDATA" | b"DATASET UNSTRUCTURED_GRID");
    head.starts_with(b"# vtk DataFile") && head.split(|&c| c == b'\n').take(12).any(kind)
}

pub(super) fn read(bytes: &[u8], options: &PointOptions) -> Result<Found, Trouble> {
    let mut scan = Scan { bytes, at: 0, binary: false };
    for _ in 0..2 {
        scan.line();
    }
    let (form, place) = (scan.line(), scan.place());
    scan.binary = match form.as_deref().map(str::to_ascii_uppercase).as_deref() {
        Some("ASCII") => false,
        Some("BINARY") => true,
        other => return Err(Trouble::new(place, other.unwrap_or_default(), "must be ASCII or BINARY")),
    };
    let mut content = Content::default();
    while let Some(line) = scan.line() {
        content.section(&line, &mut scan)?;
    }
    let Content { points, arrays, cells, cell_arrays, .. } = content;
    let points = points.ok_or_else(|| Trouble::new("POINTS", "nothing", "there must be points"))?;

    let mut notes = Vec::new();
    if cells > 0 {
        notes.push(format!("{cells} cells are left out: their points are taken"));
    }
    if cell_arrays > 0 {
        notes.push(format!("{cell_arrays} arrays of cell data are left out"));
    }
    let arrays: Vec<Array> = arrays.into_iter().filter(|a| a.numbers == points.numbers / 3).collect();
    let names: Vec<String> = arrays.iter().map(|a| a.name.clone()).collect();
    let column = |i: usize| {
        let array: &Array = &arrays[i];
        Ok::<_, Trouble>(Column { name: array.name.clone(), numbers: scan.numbers(array)? })
    };
    let columns = Roles::choose(&names, options)?.try_map(column)?;
    let positions = numbers::positions(&scan.numbers(&points)?);
    Ok(Found {
        table: Table { positions, columns, numbering: Numbering::FromZero },
        format: "VTK (legacy)",
        encoding: if scan.binary { "raw" } else { "ascii" },
        scalar: points.scalar,
        endian: Endian::Big,
        names,
        notes,
    })
}

/// Numbers in the file, not looked at yet.
struct Array {
    name: String,
    scalar: ScalarType,
    numbers: usize,
    at: Range<usize>,
}

/// What the file holds, as far as it is of use.
#[derive(Default)]
struct Content {
    points: Option<Array>,
    /// Of the points.
    arrays: Vec<Array>,
    cells: usize,
    cell_arrays: usize,
    /// Points or cells that the arrays to come belong to.
    count: usize,
    of_cells: bool,
}

impl Content {
    /// Takes in what a line begins.
    fn section(&mut self, line: &str, scan: &mut Scan<'_>) -> Result<(), Trouble> {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let place = scan.place();
        let wrong = |allowed: &str| Trouble::new(place.clone(), line, allowed);
        let word = |i: usize| words.get(i).copied().ok_or_else(|| wrong("this line must say more"));
        let size = |i: usize| word(i)?.parse::<usize>().map_err(|_| wrong("must hold a whole number"));
        let keyword = word(0)?.to_ascii_uppercase();
        match keyword.as_str() {
            "DATASET" => {
                if !matches!(word(1)?.to_ascii_uppercase().as_str(), "POLYDATA" | "UNSTRUCTURED_GRID") {
                    return Err(wrong("must be POLYDATA or UNSTRUCTURED_GRID"));
                }
            }
            "POINTS" => {
                let count = size(1)?.checked_mul(3).ok_or_else(|| wrong("must be fewer"))?;
                self.points = Some(scan.array("POINTS", word(2)?, count)?);
            }
            "VERTICES" | "LINES" | "POLYGONS" | "TRIANGLE_STRIPS" | "CELLS" => {
                let (count, size) = (size(1)?, size(2)?);
                let before = scan.at;
                match scan.line() {
                    // From version 5.0 on, in two parts, of which the first has one number more than there are cells.
                    Some(offsets) if offsets.starts_with("OFFSETS") => {
                        scan.array("OFFSETS", offsets.split_whitespace().nth(1).unwrap_or_default(), count)?;
                        let connectivity = scan.line().unwrap_or_default();
                        let scalar = connectivity.strip_prefix("CONNECTIVITY").map(str::trim);
                        let place = scan.place();
                        let scalar =
                            scalar.ok_or_else(|| Trouble::new(place, &connectivity, "must be CONNECTIVITY"))?;
                        scan.array("CONNECTIVITY", scalar, size)?;
                        self.cells += count.saturating_sub(1);
                    }
                    _ => {
                        scan.at = before;
                        scan.array(&keyword, "int", size)?;
                        self.cells += count;
                    }
                }
            }
            "CELL_TYPES" => {
                scan.array("CELL_TYPES", "int", size(1)?)?;
            }
            "POINT_DATA" => (self.of_cells, self.count) = (false, size(1)?),
            "CELL_DATA" => (self.of_cells, self.count) = (true, size(1)?),
            "SCALARS" => {
                let components = words.get(3).map_or(Ok(1), |_| size(3))?;
                let before = scan.at;
                if !scan.line().is_some_and(|line| line.to_ascii_uppercase().starts_with("LOOKUP_TABLE")) {
                    scan.at = before;
                }
                self.attribute(word(1)?, word(2)?, components, scan)?;
            }
            "VECTORS" | "NORMALS" => self.attribute(word(1)?, word(2)?, 3, scan)?,
            "TENSORS" => self.attribute(word(1)?, word(2)?, 9, scan)?,
            "TENSORS6" => self.attribute(word(1)?, word(2)?, 6, scan)?,
            "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => self.attribute(word(1)?, word(2)?, 1, scan)?,
            "TEXTURE_COORDINATES" => self.attribute(word(1)?, word(3)?, size(2)?, scan)?,
            "COLOR_SCALARS" => {
                let scalar = if scan.binary { "unsigned_char" } else { "float" };
                self.attribute(word(1)?, scalar, size(2)?, scan)?;
            }
            "LOOKUP_TABLE" => {
                let scalar = if scan.binary { "unsigned_char" } else { "float" };
                let count = size(2)?.checked_mul(4).ok_or_else(|| wrong("must be fewer"))?;
                scan.array("LOOKUP_TABLE", scalar, count)?;
            }
            "FIELD" => {
                for _ in 0..size(2)? {
                    self.field_array(scan)?;
                }
            }
            "METADATA" => scan.skip_paragraph(),
            _ => {
                return Err(wrong(
                    "a section begins here, with a word like POINTS, CELLS, POINT_DATA, SCALARS or FIELD",
                ));
            }
        }
        Ok(())
    }

    /// An array with so many numbers for each point or cell.
    fn attribute(&mut self, name: &str, scalar: &str, components: usize, scan: &mut Scan<'_>) -> Result<(), Trouble> {
        let place = scan.place();
        let numbers = self.count.checked_mul(components);
        let numbers = numbers.ok_or_else(|| Trouble::new(place, components, "must have fewer components"))?;
        let array = scan.array(name, scalar, numbers)?;
        self.keep(array);
        Ok(())
    }

    fn field_array(&mut self, scan: &mut Scan<'_>) -> Result<(), Trouble> {
        let mut line = scan.line();
        if line.as_deref() == Some("METADATA") {
            scan.skip_paragraph();
            line = scan.line();
        }
        let (line, place) = (line.unwrap_or_default(), scan.place());
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let parsed = match words[..] {
            [name, components, tuples, scalar] => match (components.parse::<usize>(), tuples.parse::<usize>()) {
                (Ok(components), Ok(tuples)) => components.checked_mul(tuples).map(|numbers| (name, scalar, numbers)),
                _ => None,
            },
            _ => None,
        };
        let allowed = "an array of a field: its name, components, tuples and type";
        let (name, scalar, numbers) = parsed.ok_or_else(|| Trouble::new(place, &line, allowed))?;
        let array = scan.array(name, scalar, numbers)?;
        self.keep(array);
        Ok(())
    }

    fn keep(&mut self, array: Array) {
        match (self.of_cells, self.count) {
            // A field of the whole file.
            (_, 0) => {}
            (true, _) => self.cell_arrays += 1,
            (false, _) => self.arrays.push(array),
        }
    }
}

/// A place in the file.
struct Scan<'a> {
    bytes: &'a [u8],
    at: usize,
    binary: bool,
}

impl Scan<'_> {
    /// The next line that is not empty, without blanks around it.
    fn line(&mut self) -> Option<String> {
        while self.at < self.bytes.len() {
            let rest = &self.bytes[self.at..];
            let end = rest.iter().position(|&c| c == b'\n').unwrap_or(rest.len());
            self.at = (self.at + end + 1).min(self.bytes.len());
            let line = rest[..end].trim_ascii();
            if !line.is_empty() {
                return Some(String::from_utf8_lossy(line).into_owned());
            }
        }
        None
    }

    /// Where that line was: its number in text, the byte after it in binary files.
    fn place(&self) -> String {
        if self.binary {
            format!("byte {}", self.at)
        } else {
            format!("line {}", self.line_of(self.at.saturating_sub(1)))
        }
    }

    fn line_of(&self, at: usize) -> usize {
        1 + self.bytes[..at].iter().filter(|&&c| c == b'\n').count()
    }

    fn skip_paragraph(&mut self) {
        while let Some(end) = self.bytes[self.at..].iter().position(|&c| c == b'\n') {
            let line = &self.bytes[self.at..self.at + end];
            self.at += end + 1;
            if line.trim_ascii().is_empty() {
                return;
            }
        }
        self.at = self.bytes.len();
    }

    /// Passes over the numbers of an array, which must all be there.
    fn array(&mut self, name: &str, scalar: &str, numbers: usize) -> Result<Array, Trouble> {
        let place = self.place();
        let packed = scalar.eq_ignore_ascii_case("bit");
        let scalar = type_of(scalar).ok_or_else(|| {
            Trouble::new(&*place, scalar, "must be a type of numbers, like float, double, int or vtktypeint64")
        })?;
        let begin = self.at;
        let end = if self.binary {
            let length = if packed { Some(numbers.div_ceil(8)) } else { numbers.checked_mul(scalar.bytes()) };
            length.and_then(|length| begin.checked_add(length)).filter(|&end| end <= self.bytes.len())
        } else {
            self.after_words(numbers)
        };
        let short = || {
            let found = format!("{} bytes left", self.bytes.len() - begin);
            Trouble::new(
                format!("array {}", shown(name)),
                found,
                format!("{numbers} numbers of {scalar} are to follow"),
            )
        };
        self.at = end.ok_or_else(short)?;
        Ok(Array { name: shown(&unescaped(name)), scalar, numbers, at: begin..self.at })
    }

    /// Where so many words end.
    fn after_words(&self, count: usize) -> Option<usize> {
        let mut at = self.at;
        for _ in 0..count {
            at += self.bytes[at..].iter().position(|c| !c.is_ascii_whitespace())?;
            at += self.bytes[at..].iter().position(u8::is_ascii_whitespace).unwrap_or(self.bytes.len() - at);
        }
        Some(at)
    }

    fn numbers(&self, array: &Array) -> Result<Vec<f64>, Trouble> {
        let bytes = &self.bytes[array.at.clone()];
        if self.binary {
            return Ok(numbers::numbers(bytes, array.scalar, Endian::Big));
        }
        let words = bytes.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let number = |word: &[u8]| str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        words
            .map(|word| {
                number(word).ok_or_else(|| {
                    let at = array.at.start + word.as_ptr().addr() - bytes.as_ptr().addr();
                    let place = format!("line {}, array {}", self.line_of(at), array.name);
                    Trouble::new(place, String::from_utf8_lossy(word), "must be a number")
                })
            })
            .collect()
    }
}

/// The type of a name; of bits in binary files, which nobody chooses, that of the bytes around them.
fn type_of(name: &str) -> Option<ScalarType> {
    Some(match name.to_ascii_lowercase().as_str() {
        "bit" | "unsigned_char" => ScalarType::U8,
        "char" | "signed_char" => ScalarType::I8,
        "unsigned_short" => ScalarType::U16,
        "short" => ScalarType::I16,
        "unsigned_int" => ScalarType::U32,
        // What VTK calls an id, it writes as an int.
        "int" | "vtkidtype" => ScalarType::I32,
        "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => ScalarType::U64,
        "long" | "long_long" | "vtktypeint64" => ScalarType::I64,
        "float" => ScalarType::F32,
        "double" => ScalarType::F64,
        _ => return None,
    })
}

/// A name as people know it: in the file, blanks and others are written as `%20`.
fn unescaped(name: &str) -> String {
    let mut bytes = Vec::new();
    let mut rest = name;
    while let Some((before, after)) = rest.split_once('%') {
        bytes.extend_from_slice(before.as_bytes());
        match after.get(..2).and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &after[2..];
            }
            None => {
                bytes.push(b'%');
                rest = after;
            }
        }
    }
    bytes.extend_from_slice(rest.as_bytes());
    String::from_utf8_lossy(&bytes).into_owned()
}
