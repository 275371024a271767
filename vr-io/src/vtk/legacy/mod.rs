//! Legacy VTK files (.vtk, versions up to 5.1), text and binary: the sections of a file, and where in it their numbers are.
//!
//! Own code: `vtkio`, the crate at hand, does not know fields before the points, and drops, without a word, an array of a type that it does not
//! know and all that follow.

mod scan;

use std::path::Path;

use crate::error::FileErrorKind;
use crate::vtk::words::exactly;

pub(crate) use scan::Array;

use scan::Scan;

/// The parts of a file that are of use.
#[derive(Debug, Default)]
pub(crate) struct Legacy {
    pub points: Option<Array>,
    /// Arrays of the points and of the cells.
    pub attributes: Vec<Attribute>,
    /// Cells that are listed.
    pub cells: usize,
    /// Lists of an unstructured grid.
    pub cell_lines: CellLines,
    pub lattice: LatticeLines,
    /// Claim of POINT_DATA.
    pub point_count: Option<usize>,
    /// Claim of CELL_DATA.
    pub cell_count: Option<usize>,
    /// Points or cells that the arrays to come belong to.
    count: usize,
    of_cells: bool,
}

/// The lists of cells of UNSTRUCTURED_GRID.
#[derive(Debug, Default)]
pub(crate) struct CellLines {
    /// Number of cells.
    pub count: usize,
    /// Vertices; up to version 4 of each cell their number first.
    pub cells: Option<Array>,
    /// From version 5.0 on: begin of each cell, and end of the last one.
    pub offsets: Option<Array>,
    /// VTK's number for the type of each cell.
    pub types: Option<Array>,
}

/// The lattice of STRUCTURED_POINTS, RECTILINEAR_GRID and STRUCTURED_GRID.
#[derive(Debug, Default)]
pub(crate) struct LatticeLines {
    pub dimensions: Option<[usize; 3]>,
    /// First and last index along each axis, in place of dimensions.
    pub extent: Option<[i64; 6]>,
    pub origin: Option<[f64; 3]>,
    pub spacing: Option<[f64; 3]>,
    /// Coordinates of the planes of RECTILINEAR_GRID, of each axis.
    pub coordinates: [Option<Array>; 3],
}

/// An array with some numbers for each point or cell.
#[derive(Debug)]
pub(crate) struct Attribute {
    pub array: Array,
    pub components: usize,
    pub of_cells: bool,
    /// True if it was announced as SCALARS or COLOR_SCALARS.
    pub is_scalars: bool,
}

/// The word that announces an array.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Scalars,
    Colors,
    Other,
}

impl Legacy {
    /// Reads a file that holds one of some kinds of data: the lines, not the numbers between them.
    pub fn read(path: &Path, data_sets: &[&str]) -> Result<Self, FileErrorKind> {
        // Read the three lines of the header, of which the second is a title, and may be empty.
        let mut scan = Scan::open(path)?;
        let magic = scan.any_line()?.unwrap_or_default();
        if !magic.starts_with("# vtk DataFile") {
            return Err(FileErrorKind::field("line 1", magic, "must begin with # vtk DataFile Version"));
        }
        scan.any_line()?;
        let (form, place) = (scan.line()?, scan.place());
        scan.binary = match form.as_deref().map(str::to_ascii_uppercase).as_deref() {
            Some("ASCII") => false,
            Some("BINARY") => true,
            other => return Err(FileErrorKind::field(place, other.unwrap_or_default(), "must be ASCII or BINARY")),
        };
        // Collect the sections of use.
        let mut content = Self::default();
        while let Some(line) = scan.line()? {
            content.section(&line, &mut scan, data_sets)?;
        }
        Ok(content)
    }

    /// Takes in what a line begins.
    fn section(&mut self, line: &str, scan: &mut Scan, data_sets: &[&str]) -> Result<(), FileErrorKind> {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let here = scan.place();
        let wrong = |allowed: &str| FileErrorKind::field(&here, line, allowed);
        let word = |i: usize| words.get(i).copied().ok_or_else(|| wrong("the line must have more words"));
        let size = |i: usize| word(i)?.parse::<usize>().map_err(|_| wrong("must hold a whole number"));
        let keyword = word(0)?.to_ascii_uppercase();
        match keyword.as_str() {
            "DATASET" => {
                if !data_sets.contains(&word(1)?.to_ascii_uppercase().as_str()) {
                    return Err(wrong(&format!("must be {}", data_sets.join(" or "))));
                }
            }
            "DIMENSIONS" => self.lattice.dimensions = Some([size(1)?, size(2)?, size(3)?]),
            "EXTENT" => {
                self.lattice.extent =
                    Some(exactly(words[1..].iter().copied()).ok_or_else(|| wrong("must hold six integers"))?)
            }
            "ORIGIN" => {
                self.lattice.origin =
                    Some(exactly(words[1..].iter().copied()).ok_or_else(|| wrong("must hold three numbers"))?)
            }
            // As the first version called it.
            "SPACING" | "ASPECT_RATIO" => {
                self.lattice.spacing =
                    Some(exactly(words[1..].iter().copied()).ok_or_else(|| wrong("must hold three numbers"))?);
            }
            "POINTS" => {
                let count = size(1)?.checked_mul(3).ok_or_else(|| wrong("must be fewer"))?;
                self.points = Some(scan.array("POINTS", word(2)?, count)?);
            }
            "X_COORDINATES" | "Y_COORDINATES" | "Z_COORDINATES" => {
                let axis = usize::from(keyword.as_bytes()[0] - b'X');
                self.lattice.coordinates[axis] = Some(scan.array(&keyword, word(2)?, size(1)?)?);
            }
            "VERTICES" | "LINES" | "POLYGONS" | "TRIANGLE_STRIPS" | "CELLS" => {
                let (count, size) = (size(1)?, size(2)?);
                match scan.line_of("OFFSETS")? {
                    // From version 5.0 on, in two parts, of which the first has one number more than there are cells.
                    Some(offsets) => {
                        let scalar = offsets.split_whitespace().nth(1).unwrap_or_default();
                        let offsets = scan.array("OFFSETS", scalar, count)?;
                        let connectivity = scan.line()?.unwrap_or_default();
                        let scalar = connectivity.strip_prefix("CONNECTIVITY").map(str::trim);
                        let wrong = || FileErrorKind::field(scan.place(), &connectivity, "must be CONNECTIVITY");
                        let scalar = scalar.ok_or_else(wrong)?;
                        let cells = scan.array("CONNECTIVITY", scalar, size)?;
                        self.cells = self.cells.saturating_add(count.saturating_sub(1));
                        if keyword == "CELLS" {
                            self.cell_lines.count = count.saturating_sub(1);
                            (self.cell_lines.cells, self.cell_lines.offsets) = (Some(cells), Some(offsets));
                        }
                    }
                    None => {
                        let cells = scan.array(&keyword, "int", size)?;
                        self.cells = self.cells.saturating_add(count);
                        if keyword == "CELLS" {
                            (self.cell_lines.cells, self.cell_lines.count) = (Some(cells), count);
                        }
                    }
                }
            }
            "CELL_TYPES" => {
                self.cell_lines.types = Some(scan.array("CELL_TYPES", "int", size(1)?)?);
            }
            "POINT_DATA" => {
                (self.of_cells, self.count) = (false, size(1)?);
                self.point_count = Some(self.count);
            }
            "CELL_DATA" => {
                (self.of_cells, self.count) = (true, size(1)?);
                self.cell_count = Some(self.count);
            }
            "SCALARS" => {
                let components = words.get(3).map_or(Ok(1), |_| size(3))?;
                scan.line_of("LOOKUP_TABLE")?;
                self.attribute(Kind::Scalars, word(1)?, word(2)?, components, scan)?;
            }
            "VECTORS" | "NORMALS" => self.attribute(Kind::Other, word(1)?, word(2)?, 3, scan)?,
            "TENSORS" => self.attribute(Kind::Other, word(1)?, word(2)?, 9, scan)?,
            "TENSORS6" => self.attribute(Kind::Other, word(1)?, word(2)?, 6, scan)?,
            "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => self.attribute(Kind::Other, word(1)?, word(2)?, 1, scan)?,
            "TEXTURE_COORDINATES" => self.attribute(Kind::Other, word(1)?, word(3)?, size(2)?, scan)?,
            "COLOR_SCALARS" => {
                let scalar = if scan.binary { "unsigned_char" } else { "float" };
                self.attribute(Kind::Colors, word(1)?, scalar, size(2)?, scan)?;
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
            "METADATA" => scan.skip_paragraph()?,
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
        kind: Kind,
        name: &str,
        scalar: &str,
        components: usize,
        scan: &mut Scan,
    ) -> Result<(), FileErrorKind> {
        let numbers = self.count.checked_mul(components);
        let numbers =
            numbers.ok_or_else(|| FileErrorKind::field(scan.place(), components, "must have fewer components"))?;
        let array = scan.array(name, scalar, numbers)?;
        self.keep(kind, array, components);
        Ok(())
    }

    fn field_array(&mut self, scan: &mut Scan) -> Result<(), FileErrorKind> {
        let mut line = scan.line()?;
        if line.as_deref() == Some("METADATA") {
            scan.skip_paragraph()?;
            line = scan.line()?;
        }
        let line = line.unwrap_or_default();
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let parsed = match words[..] {
            [name, components, tuples, scalar] => match (components.parse::<usize>(), tuples.parse::<usize>()) {
                (Ok(components), Ok(tuples)) => {
                    components.checked_mul(tuples).map(|numbers| (name, scalar, components, numbers))
                }
                _ => None,
            },
            _ => None,
        };
        let allowed = "must be an array of a field: its name, components, tuples and type";
        let (name, scalar, components, numbers) =
            parsed.ok_or_else(|| FileErrorKind::field(scan.place(), &line, allowed))?;
        let array = scan.array(name, scalar, numbers)?;
        self.keep(Kind::Other, array, components);
        Ok(())
    }

    fn keep(&mut self, kind: Kind, array: Array, components: usize) {
        // Without a count it is of a field of the whole file.
        if self.count > 0 {
            let array = if kind == Kind::Colors { array.of_shares() } else { array };
            let is_scalars = kind != Kind::Other;
            self.attributes.push(Attribute { array, components, of_cells: self.of_cells, is_scalars });
        }
    }
}
