//! Cells of VTK's XML files: of UnstructuredGrid (.vtu) and StructuredGrid (.vts).

use std::path::{Path, PathBuf};

use roxmltree::Node;

use crate::error::{FileError, FileErrorKind, shown};
use crate::vtk::{Candidate, DataArray, Extent, Store, XmlFile, exactly, named_arrays, root};

use super::cell_file::{CellFile, Facts, Hidden, Piece};
use super::cell_list::CellList;
use super::ghosts::is_ghost_array;
use super::positions;
use super::xml_cells::listed;

/// The kinds of data with cells that have positions of their own.
pub(super) const KINDS: [&str; 2] = ["UnstructuredGrid", "StructuredGrid"];

/// A file of which everything but numbers has been read.
pub(super) struct XmlCells {
    path: PathBuf,
    format: &'static str,
    store: Store,
    pieces: Vec<XmlPiece>,
    candidates: Vec<Candidate>,
}

/// A piece that has points.
struct XmlPiece {
    /// Points and cells that it claims: not to be believed before their numbers have been found.
    points: usize,
    cells: usize,
    positions: DataArray,
    form: Form,
    /// Arrays of values and marks; `true` for those of cells.
    arrays: Vec<(bool, DataArray)>,
}

enum Form {
    /// The arrays of the section Cells.
    Listed(Vec<DataArray>),
    Lattice([usize; 3]),
}

impl XmlCells {
    /// Reads everything but numbers.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        Self::read(path).map_err(|kind| FileError::new(path, kind))
    }

    fn read(path: &Path) -> Result<Self, FileErrorKind> {
        let file = XmlFile::open(path)?;
        let document = file.document()?;
        let (root, kind) = root(&document, &KINDS)?;
        let store = file.store(root)?;
        let (mut pieces, mut candidates) = (Vec::new(), Vec::new());
        let nodes = root.children().filter(|n| n.has_tag_name(kind)).flat_map(|n| n.children());
        for node in nodes.filter(|n| n.has_tag_name("Piece")) {
            let Some(piece) = XmlPiece::new(node, kind == KINDS[1])? else { continue };
            // The first piece tells what there is to choose.
            if pieces.is_empty() {
                candidates = piece.candidates(node);
            }
            pieces.push(piece);
        }
        let format = if kind == KINDS[0] { "VTK UnstructuredGrid" } else { "VTK StructuredGrid" };
        Ok(Self { path: path.into(), format, store, pieces, candidates })
    }

    /// Numbers of the array of a name in a piece.
    pub fn numbers_of(&self, piece: usize, wanted: &Candidate) -> Result<Vec<f64>, FileError> {
        let XmlPiece { points, cells, arrays, .. } = &self.pieces[piece];
        let in_file = |kind| FileError::new(&self.path, kind);
        let found = arrays.iter().find(|(of_cells, array)| *of_cells == wanted.of_cells && array.name == wanted.name);
        let (_, array) = found.ok_or_else(|| {
            let field = format!("Piece, array {}", wanted.name);
            in_file(FileErrorKind::field(field, "nothing", "every piece must have it, as the first one has"))
        })?;
        let count = if wanted.of_cells { cells } else { points };
        let many = || FileErrorKind::field(format!("array {}", array.name), "too many numbers", "must be fewer");
        let count = count.checked_mul(wanted.components).ok_or_else(many).map_err(in_file)?;
        array.numbers(count, &self.store).map_err(in_file)
    }

    fn read_piece(&self, piece: &XmlPiece) -> Result<Piece, FileErrorKind> {
        let many = || FileErrorKind::field("Piece", "too many points", "must be fewer");
        let count = piece.points.checked_mul(3).ok_or_else(many)?;
        let positions = positions(&piece.positions.numbers(count, &self.store)?);
        let cells = match &piece.form {
            Form::Lattice(dims) => super::lattice("Piece, Extent", *dims, positions.len())?,
            Form::Listed(arrays) => CellList::Listed(listed(arrays, piece.cells, positions.len(), &self.store)?),
        };
        let mut hidden = Hidden::default();
        for (of_cells, array) in piece.arrays.iter().filter(|(_, array)| is_ghost_array(&array.name)) {
            let count = if *of_cells { piece.cells } else { piece.points };
            hidden.mark(&array.name, *of_cells, &array.numbers(count, &self.store)?);
        }
        Ok(Piece { positions, cells, hidden })
    }
}

impl XmlPiece {
    /// A piece; `None` for one without points.
    fn new(node: Node<'_, '_>, is_lattice: bool) -> Result<Option<Self>, FileErrorKind> {
        let section = |name: &'static str| node.children().filter(move |n| n.has_tag_name(name));
        let (points, cells, form) = if is_lattice {
            let text = node.attribute("Extent").unwrap_or_default();
            let numbers = exactly(text.split_ascii_whitespace());
            let numbers = numbers.ok_or_else(|| FileErrorKind::field("Piece, Extent", text, "must be six integers"))?;
            let Some(extent) = Extent::new("Piece, Extent", numbers)? else { return Ok(None) };
            let [points, cells] = [false, true]
                .map(|of_cells| extent.dims(of_cells).into_iter().try_fold(1usize, |n, d| n.checked_mul(d)));
            let many = || FileErrorKind::field("Piece, Extent", text, "must have fewer points");
            (points.ok_or_else(many)?, cells.ok_or_else(many)?, Form::Lattice(extent.dims(false)))
        } else {
            let arrays = section("Cells").flat_map(named_arrays);
            let arrays = arrays.map(|(_, array)| DataArray::new(array)).collect::<Result<_, _>>()?;
            (counted(node, "NumberOfPoints")?, counted(node, "NumberOfCells")?, Form::Listed(arrays))
        };
        if points == 0 {
            return Ok(None);
        }
        let place = section("Points").flat_map(|n| n.children()).find(|n| n.has_tag_name("DataArray"));
        let place = place
            .ok_or_else(|| FileErrorKind::field("Piece", "no Points with a DataArray", "points have positions"))?;
        let mut arrays = Vec::new();
        for (name, of_cells) in [("PointData", false), ("CellData", true)] {
            // An array of a type that is not read, such as bits, cannot be chosen.
            let read = section(name).flat_map(named_arrays).filter_map(|(_, array)| DataArray::new(array).ok());
            arrays.extend(read.map(|array| (of_cells, array)));
        }
        Ok(Some(Self { points, cells, positions: DataArray::new(place)?, form, arrays }))
    }

    /// The arrays that may be chosen.
    fn candidates(&self, node: Node<'_, '_>) -> Vec<Candidate> {
        let scalars = |section: &str| {
            let section = node.children().find(|n| n.has_tag_name(section));
            section.and_then(|n| n.attribute("Scalars")).map(shown)
        };
        let active = [scalars("PointData"), scalars("CellData")];
        let chooseable = self.arrays.iter().filter(|(_, array)| !is_ghost_array(&array.name) && array.components > 0);
        chooseable
            .map(|(of_cells, array)| Candidate {
                name: array.name.clone(),
                components: array.components,
                of_cells: *of_cells,
                is_scalars: active[usize::from(*of_cells)].as_ref() == Some(&array.name),
            })
            .collect()
    }
}

/// A count among the attributes of a piece.
fn counted(node: Node<'_, '_>, name: &str) -> Result<usize, FileErrorKind> {
    let text = node.attribute(name).unwrap_or_default();
    let count = text.trim().parse().ok().filter(|&count: &usize| count < u32::MAX as usize);
    count.ok_or_else(|| FileErrorKind::field(format!("Piece, {name}"), text, "must be a whole number below 2^32"))
}

impl CellFile for XmlCells {
    fn facts(&self) -> Facts {
        let first = self.pieces.first();
        Facts {
            format: self.format,
            encoding: first.map_or("ascii", |piece| piece.positions.encoding(&self.store)),
            scalar: first.map_or(crate::ScalarType::F32, |piece| piece.positions.scalar),
            endian: self.store.endian,
            frames: 1,
            files: vec![self.path.clone()],
        }
    }

    fn arrays(&self) -> &[Candidate] {
        &self.candidates
    }

    fn pieces(&self) -> usize {
        self.pieces.len()
    }

    fn piece(&self, piece: usize) -> Result<Piece, FileError> {
        self.read_piece(&self.pieces[piece]).map_err(|kind| FileError::new(&self.path, kind))
    }

    fn numbers(&self, piece: usize, array: usize) -> Result<Vec<f64>, FileError> {
        self.numbers_of(piece, &self.candidates[array])
    }
}
