//! PLOT3D: curvilinear grids in one file, the flow at their points in another (Walatka, Buning, Pierce & Elson, NASA TM 101067, 1990).
//!
//! Binary files of three dimensions, whole grids, of 32 or 64 bits in either byte order, with or without the marks that Fortran puts around records,
//! of one grid or several, with or without marks of holes (`iblank`). The form is told by the length of the file alone.

mod layout;

use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use glam::DVec3;

use crate::decode::numbers_as_f64;
use crate::error::{FileError, FileErrorKind};
use crate::regular_file;
use crate::scalar::ScalarType;
use crate::vtk::Candidate;

use super::cell_file::{CellFile, Facts, Hidden, Piece};

use layout::{Content, Layout};

/// True if the length of a file is what PLOT3D's sizes at its beginning add up to.
pub(crate) fn is_plot3d(path: &Path) -> bool {
    Layout::find(path, Content::Grid).or_else(|| Layout::find(path, Content::Solution)).is_some()
}

/// Arrays of a solution, with the place of their first component among the five numbers of each point.
const ARRAYS: [(&str, usize, usize); 3] = [("Density", 0, 1), ("Momentum", 1, 3), ("Energy", 4, 1)];

/// A grid and, where there is one beside it, its solution.
pub(super) struct Plot3d {
    grid: PathBuf,
    layout: Layout,
    solution: Option<(PathBuf, Layout)>,
    candidates: Vec<Candidate>,
}

impl Plot3d {
    /// Finds the layout of a grid, or of the grid of a solution, and of the solution beside it.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let wrong = |found: &str, allowed: String| FileError::new(path, FileErrorKind::field("PLOT3D", found, allowed));
        let Some(layout) = Layout::find(path, Content::Grid) else {
            let grid = beside(path, &[("q", "xyz")], &["xyz", "x", "g", "p3d", "grd"], Content::Grid);
            let allowed = || "the grid must lie beside it, as .xyz, or with xyz in its name in place of q".to_owned();
            let (grid, _) = grid.ok_or_else(|| wrong("a solution without its grid", allowed()))?;
            return Self::open(&grid);
        };
        let solution = beside(path, &[("xyz", "q"), ("grid", "q"), ("_x", "_q")], &["q"], Content::Solution);
        if let Some((place, found)) = &solution {
            let sizes = |layout: &Layout| layout.grids.iter().map(|grid| grid.dims).collect::<Vec<_>>();
            if sizes(found) != sizes(&layout) {
                let allowed = "must be those of the grid in its other file".to_owned();
                return Err(FileError::new(place, FileErrorKind::field("sizes", "other grids", allowed)));
            }
        }
        let candidate = |(name, _, components): (&str, usize, usize)| Candidate {
            name: name.into(),
            components,
            of_cells: false,
            is_scalars: name == "Density",
        };
        let candidates = if solution.is_some() { ARRAYS.map(candidate).to_vec() } else { Vec::new() };
        Ok(Self { grid: path.into(), layout, solution, candidates })
    }
}

/// The file beside another whose name has a part in place of another, or another ending, and whose layout is right.
fn beside(path: &Path, parts: &[(&str, &str)], endings: &[&str], content: Content) -> Option<(PathBuf, Layout)> {
    let name = path.file_name()?.to_str()?;
    let replaced = parts.iter().filter_map(|(from, to)| {
        let at = name.to_lowercase().rfind(from)?;
        name.is_char_boundary(at)
            .then(|| format!("{}{to}{}", &name[..at], name.get(at + from.len()..).unwrap_or_default()))
    });
    let other_endings =
        endings.iter().map(|ending| PathBuf::from(name).with_extension(ending).to_string_lossy().into_owned());
    let names: Vec<String> = replaced.chain(other_endings).collect();
    let places = names.into_iter().map(|name| path.with_file_name(name)).filter(|place| place != path);
    places.into_iter().find_map(|place| Layout::find(&place, content).map(|layout| (place, layout)))
}

/// Numbers of a part of a file, whose layout has said that they are there.
fn numbers(path: &Path, layout: &Layout, at: u64, scalar: ScalarType, count: usize) -> Result<Vec<f64>, FileError> {
    let read = || -> std::io::Result<Vec<u8>> {
        let length = count as u64 * scalar.bytes() as u64;
        let mut file = regular_file::open(path)?;
        file.seek(SeekFrom::Start(at))?;
        let mut bytes = Vec::new();
        file.take(length).read_to_end(&mut bytes)?;
        // It may have become shorter.
        if (bytes.len() as u64) < length { Err(std::io::ErrorKind::UnexpectedEof.into()) } else { Ok(bytes) }
    };
    Ok(numbers_as_f64(&read().map_err(|e| FileError::new(path, e))?, scalar, layout.endian))
}

impl CellFile for Plot3d {
    fn facts(&self) -> Facts {
        let files = std::iter::once(&self.grid).chain(self.solution.iter().map(|(path, _)| path)).cloned().collect();
        let Layout { endian, scalar, has_marks, .. } = self.layout;
        let encoding = if has_marks { "raw with record marks" } else { "raw" };
        Facts { format: "PLOT3D", encoding, scalar, endian, frames: 1, files }
    }

    fn arrays(&self) -> &[Candidate] {
        &self.candidates
    }

    fn pieces(&self) -> usize {
        self.layout.grids.len()
    }

    fn piece(&self, piece: usize) -> Result<Piece, FileError> {
        let Layout { scalar, has_blanks, ref grids, .. } = self.layout;
        let (dims, at) = (grids[piece].dims, grids[piece].at);
        let points: usize = dims.iter().product();
        let all = numbers(&self.grid, &self.layout, at, scalar, 3 * points)?;
        let [x, y, z] = [0, 1, 2].map(|axis| &all[axis * points..(axis + 1) * points]);
        let positions = (0..points).map(|i| DVec3::new(x[i], y[i], z[i])).collect();
        let mut hidden = Hidden::default();
        if has_blanks {
            let marks = at + 3 * points as u64 * scalar.bytes() as u64;
            let marks = numbers(&self.grid, &self.layout, marks, ScalarType::I32, points)?;
            hidden.vertices = marks.into_iter().map(|mark| mark == 0.0).collect();
        }
        let cells = super::lattice("sizes", dims, points).map_err(|e| e.in_file(&self.grid))?;
        Ok(Piece { positions, cells, hidden })
    }

    fn numbers(&self, piece: usize, array: usize) -> Result<Vec<f64>, FileError> {
        let Some((path, layout)) = &self.solution else { return Ok(Vec::new()) };
        let grid = &layout.grids[piece];
        let points: usize = grid.dims.iter().product();
        let (_, first, components) = ARRAYS[array];
        let at = grid.at + (first * points) as u64 * layout.scalar.bytes() as u64;
        let all = numbers(path, layout, at, layout.scalar, components * points)?;
        // Each component stands alone in the file.
        Ok((0..points).flat_map(|i| (0..components).map(move |c| (i, c))).map(|(i, c)| all[c * points + i]).collect())
    }
}
