//! The section Cells of VTK's XML: types, vertices and faces of unstructured cells.

use crate::error::FileErrorKind;
use crate::vtk::{DataArray, Store};

use super::cell_list::Listed;

/// VTK's number of a polyhedron.
const POLYHEDRON: f64 = 42.0;

/// Reads the cells of a piece.
pub(super) fn listed(
    arrays: &[DataArray],
    cells: usize,
    vertices: usize,
    store: &Store,
) -> Result<Listed, FileErrorKind> {
    let mut listed = Listed::default();
    if cells == 0 {
        return Ok(listed);
    }
    let find = |name: &str| arrays.iter().find(|array| array.name == name);
    let needed = |name: &str| {
        find(name).ok_or_else(|| FileErrorKind::field(format!("Cells, array {name}"), "nothing", "cells must have it"))
    };
    let types = needed("types")?.numbers(cells, store)?;
    let ends = needed("offsets")?.numbers(cells, store)?;
    let connectivity = needed("connectivity")?.numbers(last_end("offsets", &ends)?, store)?;
    let has_polyhedra = types.contains(&POLYHEDRON);
    let faces = if has_polyhedra { faces(&find, cells, store)? } else { Faces::default() };
    let mut begin = 0;
    for (cell, (&vtk, &end)) in types.iter().zip(&ends).enumerate() {
        let end = end_of("offsets", cell, end)?;
        let part = connectivity.get(begin..end).ok_or_else(|| bad_end("offsets", cell, end as f64))?;
        begin = end;
        let part = if vtk == POLYHEDRON { faces.of_cell(cell)? } else { part };
        listed.push(vtk, part, vertices)?;
    }
    Ok(listed)
}

/// Faces of polyhedra: of each cell their number, then of each face the number of its vertices, and the vertices.
#[derive(Default)]
struct Faces {
    numbers: Vec<f64>,
    /// Begin and end of those of each cell; none for cells without.
    parts: Vec<Option<[usize; 2]>>,
}

impl Faces {
    fn of_cell(&self, cell: usize) -> Result<&[f64], FileErrorKind> {
        let part = self.parts.get(cell).copied().flatten();
        let numbers = part.and_then(|[from, to]| self.numbers.get(from..to));
        numbers.ok_or_else(|| FileErrorKind::field(format!("Cells, cell {cell}"), "no faces", "a polyhedron has faces"))
    }
}

/// Reads the faces, as VTK writes them up to version 9.3, or later in four arrays.
fn faces<'a>(
    find: &dyn Fn(&str) -> Option<&'a DataArray>,
    cells: usize,
    store: &Store,
) -> Result<Faces, FileErrorKind> {
    let mut faces = Faces::default();
    if let (Some(numbers), Some(ends)) = (find("faces"), find("faceoffsets")) {
        let ends = ends.numbers(cells, store)?;
        faces.numbers = numbers.numbers(last_end("faceoffsets", &ends)?, store)?;
        let mut begin = 0;
        for (cell, &end) in ends.iter().enumerate() {
            // -1 for cells that are no polyhedra.
            let part = if end < 0.0 { None } else { Some([begin, end_of("faceoffsets", cell, end)?]) };
            begin = part.map_or(begin, |[_, end]| end);
            faces.parts.push(part);
        }
        return Ok(faces);
    }
    let needed = |name: &str| {
        let allowed = "polyhedra need faces and faceoffsets; or polyhedron_to_faces, polyhedron_offsets, face_connectivity and face_offsets";
        find(name).ok_or_else(|| FileErrorKind::field(format!("Cells, array {name}"), "nothing", allowed))
    };
    let ends = needed("polyhedron_offsets")?.numbers(cells, store)?;
    let of_cells = needed("polyhedron_to_faces")?.numbers(last_end("polyhedron_offsets", &ends)?, store)?;
    let face_count = of_cells.iter().copied().fold(-1.0, f64::max) + 1.0;
    let face_count = end_of("polyhedron_to_faces", 0, face_count)?;
    let face_ends = needed("face_offsets")?.numbers(face_count, store)?;
    let connectivity = needed("face_connectivity")?.numbers(last_end("face_offsets", &face_ends)?, store)?;
    let mut begin = 0;
    for (cell, &end) in ends.iter().enumerate() {
        let end = end_of("polyhedron_offsets", cell, end)?;
        let list = of_cells.get(begin..end).ok_or_else(|| bad_end("polyhedron_offsets", cell, end as f64))?;
        begin = end;
        let from = faces.numbers.len();
        faces.numbers.push(list.len() as f64);
        for &face in list {
            let number = end_of("polyhedron_to_faces", cell, face)?;
            let bound = |k: usize| face_ends.get(k).map(|&end| end_of("face_offsets", k, end)).transpose();
            let first = if number == 0 { Some(0) } else { bound(number - 1)? };
            let part = first.zip(bound(number)?).and_then(|(from, to)| connectivity.get(from..to));
            let part = part.ok_or_else(|| bad_end("face_offsets", number, face))?;
            faces.numbers.push(part.len() as f64);
            faces.numbers.extend(part);
        }
        faces.parts.push(Some([from, faces.numbers.len()]));
    }
    Ok(faces)
}

/// The largest end of a list: the count of what the ends divide.
fn last_end(name: &str, ends: &[f64]) -> Result<usize, FileErrorKind> {
    let largest = ends.iter().copied().fold(0.0, f64::max);
    end_of(name, ends.len().saturating_sub(1), largest)
}

fn end_of(name: &str, cell: usize, end: f64) -> Result<usize, FileErrorKind> {
    let right = (0.0..9e15).contains(&end) && end.fract() == 0.0;
    if right { Ok(end as usize) } else { Err(bad_end(name, cell, end)) }
}

fn bad_end(name: &str, cell: usize, found: f64) -> FileErrorKind {
    let allowed = "must be whole numbers that grow, up to the length of the list that they divide";
    FileErrorKind::field(format!("Cells, array {name}, entry {cell}"), found, allowed)
}
