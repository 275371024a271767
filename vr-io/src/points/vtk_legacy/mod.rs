//! Points of legacy VTK files (.vtk, versions up to 5.1), text and binary: of POLYDATA and UNSTRUCTURED_GRID.
//!
//! Own code: `vtkio`, the crate at hand, does not know fields before the points, and drops, without a word, an array of a type that it does not
//! know and all that follow.

mod scan;

use crate::scalar::Endian;

use super::roles::Roles;
use super::{Column, Found, Numbering, PointOptions, Table, numbers};
use crate::error::FileErrorKind;

use scan::{Array, Scan};

/// True if the beginning of a file is that of a legacy VTK file with a kind of data that has points of its own.
pub(super) fn holds_points(head: &[u8]) -> bool {
    let kind = |line: &[u8]| matches!(line.trim_ascii(), b"DATASET POLYDATA" | b"DATASET UNSTRUCTURED_GRID");
    head.starts_with(b"# vtk DataFile") && head.split(|&c| c == b'\n').take(12).any(kind)
}

pub(super) fn read(bytes: &[u8], options: &PointOptions) -> Result<Found, FileErrorKind> {
    // Read the third line: text or binary.
    let mut scan = Scan::new(bytes);
    for _ in 0..2 {
        scan.line();
    }
    let (form, place) = (scan.line(), scan.place());
    scan.binary = match form.as_deref().map(str::to_ascii_uppercase).as_deref() {
        Some("ASCII") => false,
        Some("BINARY") => true,
        other => return Err(FileErrorKind::field(place, other.unwrap_or_default(), "must be ASCII or BINARY")),
    };
    // Collect the sections of use.
    let mut content = Content::default();
    while let Some(line) = scan.line() {
        content.section(&line, &mut scan)?;
    }
    let Content { points, arrays, cells, cell_arrays, .. } = content;
    let points =
        points.ok_or_else(|| FileErrorKind::field("POINTS", "nothing", "the file must have a POINTS section"))?;

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
        Ok::<_, FileErrorKind>(Column { name: array.name.clone(), numbers: scan.numbers(array)? })
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

/// The parts of a file that are of use.
#[derive(Default)]
struct Content {
    points: Option<Array>,
    /// Arrays of the points.
    arrays: Vec<Array>,
    cells: usize,
    cell_arrays: usize,
    /// Points or cells that the arrays to come belong to.
    count: usize,
    of_cells: bool,
}

impl Content {
    /// Takes in what a line begins.
    fn section(&mut self, line: &str, scan: &mut Scan<'_>) -> Result<(), FileErrorKind> {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        // Names of places are for errors alone: they take a look at all lines before.
        let here = *scan;
        let wrong = |allowed: &str| FileErrorKind::field(here.place(), line, allowed);
        let word = |i: usize| words.get(i).copied().ok_or_else(|| wrong("the line must have more words"));
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
                        let wrong = || FileErrorKind::field(scan.place(), &connectivity, "must be CONNECTIVITY");
                        let scalar = scalar.ok_or_else(wrong)?;
                        scan.array("CONNECTIVITY", scalar, size)?;
                        self.cells = self.cells.saturating_add(count.saturating_sub(1));
                    }
                    _ => {
                        scan.at = before;
                        scan.array(&keyword, "int", size)?;
                        self.cells = self.cells.saturating_add(count);
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
    fn attribute(
        &mut self,
        name: &str,
        scalar: &str,
        components: usize,
        scan: &mut Scan<'_>,
    ) -> Result<(), FileErrorKind> {
        let numbers = self.count.checked_mul(components);
        let numbers =
            numbers.ok_or_else(|| FileErrorKind::field(scan.place(), components, "must have fewer components"))?;
        let array = scan.array(name, scalar, numbers)?;
        self.keep(array);
        Ok(())
    }

    fn field_array(&mut self, scan: &mut Scan<'_>) -> Result<(), FileErrorKind> {
        let mut line = scan.line();
        if line.as_deref() == Some("METADATA") {
            scan.skip_paragraph();
            line = scan.line();
        }
        let line = line.unwrap_or_default();
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let parsed = match words[..] {
            [name, components, tuples, scalar] => match (components.parse::<usize>(), tuples.parse::<usize>()) {
                (Ok(components), Ok(tuples)) => components.checked_mul(tuples).map(|numbers| (name, scalar, numbers)),
                _ => None,
            },
            _ => None,
        };
        let allowed = "must be an array of a field: its name, components, tuples and type";
        let (name, scalar, numbers) = parsed.ok_or_else(|| FileErrorKind::field(scan.place(), &line, allowed))?;
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
