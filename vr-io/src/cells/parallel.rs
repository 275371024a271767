//! VTK's parallel files (.pvtu, .pvts): lists of files, each of which holds pieces.

use std::path::{Path, PathBuf};

use crate::error::{FileError, FileErrorKind};
use crate::vtk::{Candidate, XmlFile, root};

use super::cell_file::{CellFile, Facts, Piece};
use super::vtk_xml::XmlCells;

/// The kinds of lists whose files hold cells.
pub(super) const KINDS: [&str; 2] = ["PUnstructuredGrid", "PStructuredGrid"];

/// A list, and the files that it names.
pub(super) struct ParallelCells {
    path: PathBuf,
    format: &'static str,
    files: Vec<XmlCells>,
    /// Number of the file, and of the piece in it, of each piece.
    pieces: Vec<(usize, usize)>,
    candidates: Vec<Candidate>,
}

impl ParallelCells {
    /// Reads a list, and everything but numbers of its files.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let (format, sources) = sources(path).map_err(|kind| FileError::new(path, kind))?;
        let (mut files, mut pieces) = (Vec::new(), Vec::new());
        let mut candidates = Vec::new();
        for source in sources {
            if let Err(e) = std::fs::metadata(&source) {
                return Err(FileError::new(path, FileErrorKind::DataFile { data: source, source: e }));
            }
            let file = XmlCells::open(&source)?;
            // The first file with points tells what there is to choose.
            if pieces.is_empty() {
                candidates = file.arrays().to_vec();
            }
            pieces.extend((0..file.pieces()).map(|piece| (files.len(), piece)));
            files.push(file);
        }
        Ok(Self { path: path.into(), format, files, pieces, candidates })
    }
}

/// The kind of list, and the paths of its files, which are relative to its folder.
fn sources(path: &Path) -> Result<(&'static str, Vec<PathBuf>), FileErrorKind> {
    let file = XmlFile::open(path)?;
    let document = file.document()?;
    let (root, kind) = root(&document, &KINDS)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let pieces = root.children().filter(|n| n.has_tag_name(kind)).flat_map(|n| n.children());
    let sources = pieces.filter(|n| n.has_tag_name("Piece")).map(|piece| {
        let source = piece.attribute("Source").filter(|source| !source.is_empty());
        let missing = || FileErrorKind::field("Piece, Source", "nothing", "must name a file");
        source.map(|source| folder.join(source)).ok_or_else(missing)
    });
    let sources: Vec<PathBuf> = sources.collect::<Result<_, _>>()?;
    if sources.is_empty() {
        return Err(FileErrorKind::field("Piece", "none", "the list must name files"));
    }
    Ok((if kind == KINDS[0] { "VTK PUnstructuredGrid" } else { "VTK PStructuredGrid" }, sources))
}

impl CellFile for ParallelCells {
    fn facts(&self) -> Facts {
        let facts: Vec<Facts> = self.files.iter().map(CellFile::facts).collect();
        let first = self.pieces.first().map_or(0, |&(file, _)| file);
        let Facts { encoding, scalar, endian, .. } = facts[first];
        let files = std::iter::once(self.path.clone()).chain(facts.into_iter().flat_map(|facts| facts.files));
        Facts { format: self.format, encoding, scalar, endian, frames: 1, files: crate::read::each_once(files) }
    }

    fn arrays(&self) -> &[Candidate] {
        &self.candidates
    }

    fn pieces(&self) -> usize {
        self.pieces.len()
    }

    fn piece(&self, piece: usize) -> Result<Piece, FileError> {
        let (file, piece) = self.pieces[piece];
        self.files[file].piece(piece)
    }

    fn numbers(&self, piece: usize, array: usize) -> Result<Vec<f64>, FileError> {
        let (file, piece) = self.pieces[piece];
        self.files[file].numbers_of(piece, &self.candidates[array])
    }
}
