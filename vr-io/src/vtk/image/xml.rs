//! ImageData of VTK's XML (.vti).

use std::path::Path;

use glam::{DMat3, DVec3};
use roxmltree::Node;

use crate::error::{FieldError, FileError, FileErrorKind, shown};
use crate::payload::Payload;
use crate::scalar::ScalarType;
use crate::source::{Decoded, Source};
use crate::vtk::words::exactly;
use crate::vtk::{DataArray, Store, XmlFile, named_arrays, root};

use super::choice::Candidate;
use super::lattice::{Extent, Lattice};
use super::{Header, Numbers, pieces};

/// An array, in all pieces.
pub(super) struct PieceArrays {
    store: Store,
    whole: Extent,
    of_cells: bool,
    pieces: Vec<(Extent, Result<DataArray, FileErrorKind>)>,
}

/// Reads everything but numbers.
pub(super) fn header(path: &Path) -> Result<Header<PieceArrays>, FileErrorKind> {
    let file = XmlFile::open(path)?;
    let document = file.document()?;
    let (root, kind) = root(&document, &["ImageData"])?;
    let store = file.store(root)?;
    let missing =
        |what| FileErrorKind::field(what, "nothing", "ImageData has a WholeExtent, and pieces with an Extent");
    let image = root.children().find(|n| n.has_tag_name(kind)).ok_or_else(|| missing("ImageData"))?;

    // Find the pieces that hold points, and the box around them.
    let mut notes = Vec::new();
    let mut filled = Vec::new();
    for piece in image.children().filter(|n| n.has_tag_name("Piece")) {
        let numbers = attribute(piece, "Extent", "six integers")?.ok_or_else(|| missing("Piece, Extent"))?;
        filled.extend(Extent::new("Piece, Extent", numbers)?.map(|extent| (extent, piece)));
    }
    let hull = filled.iter().map(|&(extent, _)| extent).reduce(|a, b| a.hull(&b));
    let whole = hull.ok_or_else(|| FileErrorKind::field("Piece", "none with points", "there must be one"))?;
    if let Some(claimed) = attribute::<i64, 6>(image, "WholeExtent", "six integers")?
        && Extent::new("WholeExtent", claimed)? != Some(whole)
    {
        let claimed = claimed.map(|n| n.to_string()).join(" ");
        notes.push(format!("WholeExtent is {claimed}, which the pieces do not fill: the box around them is taken"));
    }
    if filled.len() > 1 {
        notes.push(format!("the volume is put together from {} pieces", filled.len()));
    }

    // List the arrays of the first piece, and find them in the others.
    let mut arrays = Vec::new();
    let (_, first) = filled[0];
    for (section, of_cells) in [("PointData", false), ("CellData", true)] {
        for data in first.children().filter(|n| n.has_tag_name(section)) {
            let scalars = data.attribute("Scalars").map(shown);
            for (name, node) in named_arrays(data) {
                // Of a type that is not read, such as bits.
                let Ok(DataArray { components, .. }) = DataArray::new(node) else { continue };
                let is_scalars = scalars.as_ref() == Some(&name);
                let of_piece = |&(extent, piece): &(Extent, Node<'_, '_>)| (extent, array_of(piece, section, &name));
                let pieces = filled.iter().map(of_piece).collect();
                let candidate = Candidate { name: name.clone(), components, of_cells, is_scalars };
                arrays.push((candidate, PieceArrays { store: store.clone(), whole, of_cells, pieces }));
            }
        }
    }
    let vector = |numbers: [f64; 3]| DVec3::from_array(numbers);
    let lattice = Lattice {
        extent: whole,
        origin: attribute(image, "Origin", "three numbers")?.map_or(DVec3::ZERO, vector),
        spacing: attribute(image, "Spacing", "three numbers")?.map(vector),
        // Row by row.
        direction: attribute(image, "Direction", "nine numbers")?.map(|m| DMat3::from_cols_array(&m).transpose()),
    };
    Ok(Header { lattice, arrays, notes })
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

fn array_of(piece: Node<'_, '_>, section: &str, name: &str) -> Result<DataArray, FileErrorKind> {
    let mut arrays = piece.children().filter(|n| n.has_tag_name(section)).flat_map(named_arrays);
    let (_, node) = arrays.find(|(found, _)| found == name).ok_or_else(|| {
        let allowed = "every piece must have it, as the first one has";
        FieldError::new(format!("Piece, array {name}"), "nothing", allowed)
    })?;
    DataArray::new(node)
}

impl Numbers for PieceArrays {
    fn scalar(&self) -> Option<ScalarType> {
        self.pieces.first().and_then(|(_, array)| array.as_ref().ok()).map(|array| array.scalar)
    }

    fn source(self, path: &Path, count: usize) -> Result<Source, FileErrorKind> {
        let Self { store, whole, of_cells, pieces } = self;
        let pieces: Vec<(Extent, DataArray)> =
            pieces.into_iter().map(|(extent, array)| Ok((extent, array?))).collect::<Result<_, FileErrorKind>>()?;
        let (_, first) = &pieces[0];
        let (scalar, components, endian) = (first.scalar, first.components, store.endian);
        if let Some((_, other)) = pieces.iter().find(|(_, a)| (a.scalar, a.components) != (scalar, components)) {
            let found = format!("{} of {} components", other.scalar, other.components);
            let allowed = format!("the first piece has {scalar} of {components} components");
            return Err(FileErrorKind::field(format!("Piece, array {}", other.name), found, allowed));
        }

        // Uncompressed numbers of one piece may stay in the file.
        if let [(_, array)] = &pieces[..]
            && let Some(start) = array.place_in_file(count, &store)?
        {
            let payload = Payload::part(path, start, scalar, endian);
            return Ok(payload.into());
        }
        let (encoding, file) = (first.encoding(&store), path.to_path_buf());
        let decode = move || {
            if let [(_, array)] = &pieces[..] {
                return array.bytes(count, &store);
            }
            let load = |(extent, array): &(Extent, DataArray)| {
                let sizes = extent.dims(of_cells);
                let count = sizes.iter().try_fold(components, |n, &size| n.checked_mul(size));
                let many = || FileErrorKind::field("Piece, Extent", "a piece", "must have fewer points");
                Ok((*extent, array.bytes(count.ok_or_else(many)?, &store)?))
            };
            let loaded = pieces.iter().map(load).collect::<Result<Vec<_>, FileErrorKind>>()?;
            Ok(pieces::assemble(&whole, of_cells, components * scalar.bytes(), &loaded)?)
        };
        let files = vec![path.to_path_buf()];
        let decode = Box::new(move |_: &mut Vec<String>| decode().map_err(|kind| FileError::new(&file, kind)));
        Ok(Decoded { decode, scalar, endian, encoding, files }.into())
    }
}
