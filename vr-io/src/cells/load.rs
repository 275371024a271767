//! The mesh of a file of cells.

use std::path::Path;
use std::sync::Arc;

use vr_core::cells::{CellMesh, CellRepairs, CellValues};
use vr_core::{Volume, memory};

use crate::chosen::Chosen;
use crate::error::{FieldError, FileError};
use crate::read::{Loaded, ReadOptions};

use super::cell_file::{CellFile, Piece};
use super::tetrahedra::Tetrahedra;
use super::weld::{Merge, Weld};

/// Memory of a tetrahedron while its neighbours are looked for: vertices, neighbours, and four faces with their owners.
const BYTES_PER_TETRAHEDRON: u64 = 128;
/// Memory of a vertex: position, value and gradient.
const BYTES_PER_VERTEX: u64 = 56;

/// Outcome of making a mesh of a file.
pub(super) enum Outcome {
    /// The mesh.
    Mesh(Box<Loaded>),
    /// The reason why there is none.
    None(String),
}

/// Makes a mesh of the cells of a file, or tells why it has none: no cell has three dimensions, or there is no array of values.
///
/// # Errors
/// A choice that the file does not have; anything in the file that is not as it must be.
pub(super) fn load(file: &dyn CellFile, path: &Path, options: &ReadOptions) -> Result<Outcome, FileError> {
    let in_file = |e: FieldError| e.in_file(path);
    let facts = file.facts();
    facts.check_frame(options.frame).map_err(in_file)?;
    let pieces = (0..file.pieces()).map(|k| file.piece(k)).collect::<Result<Vec<_>, _>>()?;
    if pieces.iter().all(|piece| piece.cells.solids() == 0) {
        let cells: usize = pieces.iter().map(|piece| piece.cells.count()).sum();
        return Ok(Outcome::None(format!("none of its {cells} cells has three dimensions")));
    }
    let mut notes = Vec::new();
    let Some(chosen) = Chosen::of_mesh(file.arrays(), options, &mut notes).map_err(in_file)? else {
        return Ok(Outcome::None("it has no array of values for its cells (the value 1 draws them all alike)".into()));
    };
    if facts.frames > 1 && options.frame.is_none() {
        notes.push(format!("frame 0 is taken, of 0 to {}", facts.frames - 1));
    }
    let mesh = mesh(file, pieces, &chosen, path, &mut notes)?;
    let columns = file.arrays().iter().map(|array| array.name.clone()).collect();
    let info = facts.into_info("positions", chosen.components, columns);
    Ok(Outcome::Mesh(Box::new(Loaded { volume: Volume::Cells(Arc::new(mesh)), info, notes })))
}

/// Makes the mesh of all pieces.
fn mesh(
    file: &dyn CellFile,
    pieces: Vec<Piece>,
    chosen: &Chosen,
    path: &Path,
    notes: &mut Vec<String>,
) -> Result<CellMesh, FileError> {
    let is_lattice = pieces.iter().any(|piece| piece.cells.is_lattice());
    let merge = match (pieces.len(), is_lattice) {
        (1, false) => Merge::Nothing,
        (_, false) => Merge::Seams,
        (_, true) => Merge::SeamsAndFolds,
    };
    let several = pieces.len();
    // Gather vertices, cells and values of the pieces, one after the other.
    let (mut weld, mut tetrahedra, mut of_cells) = (Weld::default(), Tetrahedra::default(), Vec::new());
    for (k, mut piece) in pieces.into_iter().enumerate() {
        let positions = std::mem::take(&mut piece.positions);
        let count = if chosen.of_cells { piece.cells.count() } else { positions.len() };
        let values = if count == 0 { Vec::new() } else { values_of(file, chosen, k, count)? };
        let of_vertices = if chosen.of_cells {
            of_cells.extend(values);
            Vec::new()
        } else {
            values
        };
        let numbers = weld.add(positions, of_vertices, merge);
        tetrahedra.add(&piece, &numbers);
    }
    let Tetrahedra { cells, parents, census, .. } = tetrahedra;
    if several > 1 {
        notes.push(format!("{several} pieces are put together, {} vertices on their seams made one", weld.merged));
    }
    if weld.differing > 0 {
        notes.push(format!(
            "{} vertices on seams have other values in a second piece: those of the first are taken",
            weld.differing
        ));
    }
    notes.extend(census.notes());
    if census.split > 0 {
        notes.push(format!(
            "{} cells that are no tetrahedra are split: {} tetrahedra in all",
            census.split,
            cells.len()
        ));
    }
    let values = if chosen.of_cells {
        notes.push(format!("array '{}' belongs to the cells: the value is constant in each", chosen.name));
        CellValues::Cells(parents.iter().map(|&parent| of_cells[parent]).collect())
    } else {
        CellValues::Vertices(weld.values)
    };
    let total = cells.len();
    let bytes = total as u64 * BYTES_PER_TETRAHEDRON + weld.positions.len() as u64 * BYTES_PER_VERTEX;
    memory::check("the mesh of cells", bytes).map_err(|e| FileError::new(path, e))?;
    let mesh = CellMesh::new(weld.positions, cells, values).map_err(|e| FileError::new(path, e))?;
    notes.extend(repairs(mesh.repairs(), total));
    Ok(mesh)
}

/// Notes on what was put right or left out, of `total` tetrahedra.
fn repairs(repairs: &CellRepairs, total: usize) -> Vec<String> {
    let CellRepairs { inverted, degenerate, duplicate, missing, crowded_faces } = *repairs;
    let mut notes = Vec::new();
    // Where all are mirror images, the file counts corners the other way round.
    let some_inverted = if inverted + degenerate + duplicate + missing == total { 0 } else { inverted };
    let texts = [
        (some_inverted, "are inverted, and turned"),
        (degenerate, "have no volume, and are left out"),
        (duplicate, "repeat others, and are left out"),
        (missing, "have a value that is not finite: they are vacuum"),
    ];
    for (count, what) in texts.into_iter().filter(|&(count, _)| count > 0) {
        notes.push(format!("{count} of {total} tetrahedra {what}"));
    }
    if crowded_faces > 0 {
        notes.push(format!(
            "{crowded_faces} faces belong to more than two tetrahedra, or to two on one side: cells overlap there"
        ));
    }
    notes
}

/// Values of all vertices or cells of a piece, of which there are `count`.
fn values_of(file: &dyn CellFile, chosen: &Chosen, piece: usize, count: usize) -> Result<Vec<f64>, FileError> {
    let Some(array) = chosen.array else { return Ok(vec![1.0; count]) };
    let in_file = |e: FieldError| e.in_file(&file.facts().files.first().cloned().unwrap_or_default());
    chosen.values(file.numbers(piece, array)?, count).map_err(in_file)
}
