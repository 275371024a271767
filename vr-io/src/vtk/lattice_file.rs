//! Lattices of VTK's XML, but for their numbers: ImageData and RectilinearGrid, in one file or in those of a parallel list (.pvti, .pvtr).

use std::path::{Path, PathBuf};
use std::sync::Arc;

use roxmltree::Node;

use crate::error::{FileError, FileErrorKind, shown};
use crate::inside::inside;

use super::data_array::{DataArray, named_arrays};
use super::image::Extent;
use super::words::exactly;
use super::xml::{Store, XmlFile, root};

/// The two kinds of lattices: VTK's names of a file, and of a list of files.
pub(crate) const IMAGE: [&str; 2] = ["ImageData", "PImageData"];
pub(crate) const RECTILINEAR: [&str; 2] = ["RectilinearGrid", "PRectilinearGrid"];

/// A lattice of which everything but numbers has been read.
pub(crate) struct LatticeFile {
    /// True if the file is a list of others.
    pub is_list: bool,
    /// Every file that is read: the list, and those with pieces.
    pub files: Vec<PathBuf>,
    /// The pieces that have points: at least one.
    pub pieces: Vec<LatticePiece>,
    pub attributes: LatticeAttributes,
}

/// Attributes of the lattice as a whole.
#[derive(Clone, Debug, Default)]
pub(crate) struct LatticeAttributes {
    pub whole: Option<[i64; 6]>,
    pub origin: Option<[f64; 3]>,
    pub spacing: Option<[f64; 3]>,
    /// Row by row.
    pub direction: Option<[f64; 9]>,
}

/// A piece that has points.
#[derive(Clone, Debug)]
pub(crate) struct LatticePiece {
    pub store: Arc<Store>,
    pub extent: Extent,
    /// Coordinates of the planes of a rectilinear grid, one array for each axis.
    pub coordinates: Vec<DataArray>,
    pub arrays: Vec<PieceArray>,
}

/// An array of a piece.
#[derive(Clone, Debug)]
pub(crate) struct PieceArray {
    pub of_cells: bool,
    /// True if the file calls it the scalars of its points or cells.
    pub is_scalars: bool,
    pub array: DataArray,
}

impl LatticeFile {
    /// Reads everything but numbers.
    ///
    /// # Errors
    /// Faults of the file or of one that it names, and a lattice without points.
    pub fn open(path: &Path, [kind, list]: [&'static str; 2]) -> Result<Self, FileError> {
        let in_file = |kind| FileError::new(path, kind);
        let (found, attributes, mut pieces, sources) = read(path, &[kind, list]).map_err(in_file)?;
        let is_list = found == list;
        let mut files = vec![path.to_path_buf()];
        for source in sources {
            if let Err(e) = std::fs::metadata(&source) {
                return Err(in_file(FileErrorKind::DataFile { data: source, source: e }));
            }
            let (_, _, more, _) = read(&source, &[kind]).map_err(|kind| FileError::new(&source, kind))?;
            pieces.extend(more);
            files.push(source);
        }
        if pieces.is_empty() {
            return Err(in_file(FileErrorKind::field("Piece", "none with points", "there must be one")));
        }
        Ok(Self { is_list, files: crate::read::each_once(files), pieces, attributes })
    }

    /// The smallest extent that holds all pieces.
    pub fn hull(&self) -> Extent {
        self.pieces[1..].iter().fold(self.pieces[0].extent, |hull, piece| hull.hull(&piece.extent))
    }

    /// Notes on pieces that are put together, and on a claim that they do not fill.
    pub fn notes(&self) -> Result<Vec<String>, FileErrorKind> {
        let mut notes = Vec::new();
        if let Some(claimed) = self.attributes.whole
            && Extent::new("WholeExtent", claimed)? != Some(self.hull())
        {
            let claimed = claimed.map(|n| n.to_string()).join(" ");
            notes.push(format!("WholeExtent is {claimed}, which the pieces do not fill: the box around them is taken"));
        }
        if self.pieces.len() > 1 {
            notes.push(format!("the volume is put together from {} pieces", self.pieces.len()));
        }
        Ok(notes)
    }
}

type Contents = (&'static str, LatticeAttributes, Vec<LatticePiece>, Vec<PathBuf>);

/// Kind, attributes and pieces of a file, and the files that it lists.
fn read(path: &Path, kinds: &[&'static str]) -> Result<Contents, FileErrorKind> {
    let file = XmlFile::open(path)?;
    let document = file.document()?;
    let (root, kind) = root(&document, kinds)?;
    let missing = |what, who: &str| {
        FileErrorKind::field(what, "nothing", format!("{who} has a WholeExtent, and pieces with an Extent"))
    };
    let lattice = root.children().find(|n| n.has_tag_name(kind)).ok_or_else(|| missing(kind, kind))?;
    let attributes = LatticeAttributes {
        whole: attribute(lattice, "WholeExtent", "six integers")?,
        origin: attribute(lattice, "Origin", "three numbers")?,
        spacing: attribute(lattice, "Spacing", "three numbers")?,
        direction: attribute(lattice, "Direction", "nine numbers")?,
    };
    let (mut pieces, mut sources) = (Vec::new(), Vec::new());
    let nodes = || lattice.children().filter(|n| n.has_tag_name("Piece"));
    if kind.starts_with('P') {
        let folder = path.parent().unwrap_or(Path::new(""));
        for node in nodes() {
            sources.push(inside(folder, "Piece, Source", node.attribute("Source").unwrap_or_default())?);
        }
        if sources.is_empty() {
            return Err(FileErrorKind::field("Piece", "none", "the list must name files"));
        }
        return Ok((kind, attributes, pieces, sources));
    }
    let store = Arc::new(file.store(root)?);
    for node in nodes() {
        let numbers = attribute(node, "Extent", "six integers")?.ok_or_else(|| missing("Piece, Extent", kind))?;
        let Some(extent) = Extent::new("Piece, Extent", numbers)? else { continue };
        let coordinates = if kind == RECTILINEAR[0] { coordinates(node)? } else { Vec::new() };
        pieces.push(LatticePiece { store: store.clone(), extent, coordinates, arrays: arrays(node) });
    }
    Ok((kind, attributes, pieces, sources))
}

/// The arrays of a piece, without those of a type that is not read, such as bits.
fn arrays(piece: Node<'_, '_>) -> Vec<PieceArray> {
    let mut arrays = Vec::new();
    for (section, of_cells) in [("PointData", false), ("CellData", true)] {
        for data in piece.children().filter(|n| n.has_tag_name(section)) {
            let scalars = data.attribute("Scalars").map(shown);
            let read = named_arrays(data).filter_map(|(name, node)| Some((name, DataArray::new(node).ok()?)));
            arrays.extend(read.map(|(name, array)| {
                let is_scalars = scalars.as_ref() == Some(&name);
                PieceArray { of_cells, is_scalars, array }
            }));
        }
    }
    arrays
}

fn coordinates(piece: Node<'_, '_>) -> Result<Vec<DataArray>, FileErrorKind> {
    let section = piece.children().filter(|n| n.has_tag_name("Coordinates")).flat_map(|n| n.children());
    let nodes: Vec<_> = section.filter(|n| n.has_tag_name("DataArray")).collect();
    if nodes.len() != 3 {
        let found = format!("{} arrays", nodes.len());
        return Err(FileErrorKind::field("Piece, Coordinates", found, "must hold three arrays: of x, y and z"));
    }
    nodes.into_iter().map(DataArray::new).collect()
}

fn attribute<T: std::str::FromStr, const N: usize>(
    node: Node<'_, '_>,
    name: &str,
    what: &str,
) -> Result<Option<[T; N]>, FileErrorKind> {
    let Some(text) = node.attribute(name) else { return Ok(None) };
    let wrong = || FileErrorKind::field(name, text, format!("must be {what}"));
    exactly(text.split_ascii_whitespace()).map(Some).ok_or_else(wrong)
}
