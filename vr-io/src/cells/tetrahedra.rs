//! Cells of files, split into tetrahedra, and the count of what became of them.

use vr_core::cells::split::split_polyhedron;

use super::cell_file::Piece;
use super::cell_kind::CellKind;
use super::cell_list::{Cell, faces};

/// Tetrahedra of all pieces.
#[derive(Debug, Default)]
pub(super) struct Tetrahedra {
    pub cells: Vec<[u32; 4]>,
    /// Number of the cell of the file, counted through all pieces, that each is a part of.
    pub parents: Vec<usize>,
    pub census: Census,
    /// Cells of the pieces before.
    before: usize,
}

/// Number of cells of each sort.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Census {
    /// Cells that are drawn.
    pub drawn: usize,
    /// Those among them that are no tetrahedra, and are split.
    pub split: usize,
    /// Those among them that are taken by their corners.
    pub curved: usize,
    /// Cells without three dimensions: left out.
    pub flat: usize,
    /// Cells that the file hides: left out.
    pub hidden: usize,
}

impl Tetrahedra {
    /// Takes in the cells of a piece, whose vertices have these numbers in the mesh.
    pub fn add(&mut self, piece: &Piece, numbers: &[u32]) {
        let mut renumbered = Vec::new();
        piece.cells.for_each(|number, cell| {
            if !cell.kind.is_solid() {
                self.census.flat += 1;
                return;
            }
            let is_hidden = match cell.kind {
                CellKind::Polyhedron => faces(cell.numbers).flatten().any(|face| piece.hidden.hides(number, face)),
                _ => piece.hidden.hides(number, cell.numbers),
            };
            if is_hidden {
                self.census.hidden += 1;
                return;
            }
            self.split(cell, numbers, &mut renumbered);
            self.parents.resize(self.cells.len(), self.before + number);
        });
        self.before += piece.cells.count();
    }

    fn split(&mut self, Cell { kind, numbers: cell }: Cell<'_>, numbers: &[u32], renumbered: &mut Vec<u32>) {
        renumbered.clear();
        renumbered.extend(cell.iter().map(|&v| numbers.get(v as usize).copied().unwrap_or(v)));
        let all = &renumbered[..];
        self.census.drawn += 1;
        let before = self.cells.len();
        match kind {
            CellKind::Flat => {}
            CellKind::Solid(shape) => shape.split(all, &mut self.cells),
            CellKind::Curved(shape) => {
                self.census.curved += 1;
                shape.split(&all[..shape.vertices()], &mut self.cells);
            }
            CellKind::Prism(n) => {
                let (below, above) = all.split_at(n);
                let bottom: Vec<u32> = below.iter().rev().copied().collect();
                let sides: Vec<[u32; 4]> =
                    (0..n).map(|i| (i, (i + 1) % n)).map(|(i, j)| [below[i], below[j], above[j], above[i]]).collect();
                let mut around: Vec<&[u32]> = sides.iter().map(|side| &side[..]).collect();
                around.extend([&bottom[..], above]);
                split_polyhedron(&around, &mut self.cells);
            }
            CellKind::Polyhedron => {
                let named: Vec<Vec<u32>> = faces(cell)
                    .flatten()
                    .map(|face| face.iter().map(|&v| numbers.get(v as usize).copied().unwrap_or(v)).collect())
                    .collect();
                let around: Vec<&[u32]> = named.iter().map(|face| &face[..]).collect();
                split_polyhedron(&around, &mut self.cells);
            }
        }
        self.census.split += usize::from(self.cells.len() > before + 1);
    }
}

impl Census {
    /// Notes on what was left out or changed.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let mut note = |count: usize, what: &str| {
            if count > 0 {
                notes.push(format!("{count} cells {what}"));
            }
        };
        note(self.flat, "of fewer than three dimensions (vertices, lines, surfaces) are left out");
        note(self.hidden, "that the file marks as ghosts or hidden are left out");
        note(self.curved, "of higher order are taken by their corners, with straight edges");
        notes
    }
}
