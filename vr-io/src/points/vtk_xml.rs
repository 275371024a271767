//! Points of VTK's XML files: PolyData (.vtp) and UnstructuredGrid (.vtu), with arrays as text, base64 or appended, raw or compressed.
//!
//! Own code over a parser of XML: `vtkio`, the crate at hand, reads no raw appended data, which is how ParaView writes, panics on offsets beyond the
//! end, and allocates what headers claim.

use std::path::Path;

use roxmltree::Node;

use crate::error::{FieldError, FileErrorKind};
use crate::vtk::{DataArray, XmlFile, named_arrays, root};

use super::roles::Roles;
use super::{Column, Found, Numbering, PointOptions, Table, numbers};

/// The kinds of data that have points of their own.
pub(super) const KINDS: [&str; 2] = ["PolyData", "UnstructuredGrid"];

pub(super) fn read(path: &Path, options: &PointOptions) -> Result<Found, FileErrorKind> {
    let file = XmlFile::open(path)?;
    let document = file.document()?;
    let (root, kind) = root(&document, &KINDS)?;
    // Find the pieces that hold points.
    let store = file.store(root)?;
    let pieces: Vec<Piece<'_, '_>> = root
        .children()
        .filter(|n| n.has_tag_name(kind))
        .flat_map(|n| n.children())
        .filter(|n| n.has_tag_name("Piece"))
        .map(Piece::new)
        .collect::<Result<_, _>>()?;
    let notes = left_out(&pieces);
    let filled: Vec<&Piece<'_, '_>> = pieces.iter().filter(|p| p.count > 0).collect();
    let Some(first) = filled.first() else {
        return Err(vr_core::PointError::Empty.into());
    };

    // Choose columns by the first piece, and append every piece to them.
    let names: Vec<String> = first.scalars().map(|(name, _)| name).collect();
    let mut positions = Vec::new();
    let mut columns = Roles::choose(&names, options)?
        .try_map(|i| Ok::<_, FileErrorKind>(Column { name: names[i].clone(), numbers: Vec::new() }))?;
    let place = first.positions()?;
    let (scalar, encoding) = (place.scalar, place.encoding(&store));
    for piece in filled {
        let all = piece.positions()?.numbers(piece.count * 3, &store)?;
        positions.extend(numbers::positions(&all));
        columns = columns.try_map(|mut column| {
            let (_, array) = piece.scalars().find(|(name, _)| *name == column.name).ok_or_else(|| {
                let place = format!("Piece, array {}", column.name);
                FieldError::new(place, "nothing", "every piece must have it, as the first one has")
            })?;
            column.numbers.extend(DataArray::new(array)?.numbers(piece.count, &store)?);
            Ok::<_, FileErrorKind>(column)
        })?;
    }
    Ok(Found {
        table: Table { positions, columns, numbering: Numbering::FromZero },
        format: if kind == "PolyData" { "VTK PolyData" } else { "VTK UnstructuredGrid" },
        encoding,
        scalar,
        endian: store.endian,
        names,
        notes,
    })
}

/// Notes on cells, which are left out.
fn left_out(pieces: &[Piece<'_, '_>]) -> Vec<String> {
    let cells: u64 = pieces.iter().map(Piece::cells).fold(0, u64::saturating_add);
    let cell_arrays = pieces.iter().map(|p| p.sections("CellData").flat_map(named_arrays).count()).max();
    let mut notes = Vec::new();
    if cells > 0 {
        notes.push(format!("{cells} cells are left out: their points are taken"));
    }
    if let Some(count) = cell_arrays.filter(|&count| count > 0) {
        notes.push(format!("{count} arrays of cell data are left out"));
    }
    notes
}

/// A part of the data.
struct Piece<'d, 't> {
    node: Node<'d, 't>,
    /// Points that it claims: not to be believed before their numbers have been found.
    count: usize,
}

impl<'d, 't> Piece<'d, 't> {
    fn new(node: Node<'d, 't>) -> Result<Self, FileErrorKind> {
        let text = node.attribute("NumberOfPoints").unwrap_or_default();
        let count = text.trim().parse().ok().filter(|&count: &usize| count <= u32::MAX as usize);
        let wrong = || FileErrorKind::field("Piece, NumberOfPoints", text, "must be a whole number below 2^32");
        Ok(Self { node, count: count.ok_or_else(wrong)? })
    }

    fn sections(&self, name: &'static str) -> impl Iterator<Item = Node<'d, 't>> {
        self.node.children().filter(move |n| n.has_tag_name(name))
    }

    /// The arrays with one number for each point, by name.
    fn scalars(&self) -> impl Iterator<Item = (String, Node<'d, 't>)> {
        let single =
            |n: &Node<'_, '_>| n.attribute("NumberOfComponents").is_none_or(|c| matches!(c.trim(), "1" | "0" | ""));
        self.sections("PointData").flat_map(named_arrays).filter(move |(_, n)| single(n))
    }

    fn positions(&self) -> Result<DataArray, FileErrorKind> {
        let array = self.sections("Points").flat_map(|n| n.children()).find(|n| n.has_tag_name("DataArray"));
        DataArray::new(
            array
                .ok_or_else(|| FileErrorKind::field("Piece", "no Points with a DataArray", "points have positions"))?,
        )
    }

    fn cells(&self) -> u64 {
        let kinds = ["NumberOfCells", "NumberOfVerts", "NumberOfLines", "NumberOfStrips", "NumberOfPolys"];
        let count = |kind| self.node.attribute(kind).and_then(|n| n.trim().parse::<u64>().ok()).unwrap_or(0);
        kinds.into_iter().map(count).fold(0, u64::saturating_add)
    }
}
