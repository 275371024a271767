//! Lists of cells as files have them: vertices by number, or a lattice that needs no list.

use crate::error::FieldError;

use super::cell_kind::CellKind;

/// The cells of a piece.
#[derive(Debug)]
pub(super) enum CellList {
    /// Cells that each name their vertices.
    Listed(Listed),
    /// Hexahedra between the points of a lattice, of this many along each axis, the first the fastest.
    Lattice([usize; 3]),
}

/// Cells that each name their vertices.
#[derive(Debug, Default)]
pub(super) struct Listed {
    kinds: Vec<CellKind>,
    /// End of each cell's numbers.
    ends: Vec<usize>,
    /// Vertices; of a polyhedron the number of faces, then of each face the number of its vertices and the vertices.
    numbers: Vec<u32>,
}

/// A cell: its kind, and its vertices or, of a polyhedron, faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cell<'a> {
    pub kind: CellKind,
    pub numbers: &'a [u32],
}

impl Listed {
    /// Takes in a cell of one of VTK's types.
    ///
    /// # Errors
    /// A type that is not read; too few vertices, vertices that are not there, faces that are not whole.
    pub fn push(&mut self, vtk: f64, numbers: &[f64], vertices: usize) -> Result<(), FieldError> {
        let number = self.kinds.len();
        let kind = (0.0..=255.0).contains(&vtk).then(|| CellKind::of_vtk(vtk as u8)).flatten();
        let kind = kind.ok_or_else(|| {
            let allowed =
                "VTK's types of straight, quadratic and higher cells with corners are read, and polyhedra (42)";
            FieldError::new(format!("cell {number}, type"), vtk, allowed)
        })?;
        // What is left out may be anything.
        if kind.is_solid() {
            let begin = self.numbers.len();
            for &found in numbers {
                self.numbers.push(whole(found).ok_or_else(|| bad_vertex(number, found, vertices))?);
            }
            check(kind, number, &self.numbers[begin..], vertices)?;
        }
        self.kinds.push(kind);
        self.ends.push(self.numbers.len());
        Ok(())
    }

    fn cell(&self, number: usize) -> Cell<'_> {
        let begin = number.checked_sub(1).map_or(0, |before| self.ends[before]);
        Cell { kind: self.kinds[number], numbers: &self.numbers[begin..self.ends[number]] }
    }
}

impl CellList {
    /// Number of cells, flat ones among them.
    pub fn count(&self) -> usize {
        match self {
            Self::Listed(listed) => listed.kinds.len(),
            Self::Lattice(dims) => lattice_cells(*dims),
        }
    }

    /// Number of cells with three dimensions.
    pub fn solids(&self) -> usize {
        match self {
            Self::Listed(listed) => listed.kinds.iter().filter(|kind| kind.is_solid()).count(),
            Self::Lattice(dims) if dims.iter().all(|&n| n > 1) => lattice_cells(*dims),
            Self::Lattice(_) => 0,
        }
    }

    /// True for a lattice.
    pub fn is_lattice(&self) -> bool {
        matches!(self, Self::Lattice(_))
    }

    /// Gives all cells with their numbers, in order.
    pub fn for_each(&self, mut take: impl FnMut(usize, Cell<'_>)) {
        match self {
            Self::Listed(listed) => (0..listed.kinds.len()).for_each(|number| take(number, listed.cell(number))),
            Self::Lattice(_) if self.solids() == 0 => {
                let flat = Cell { kind: CellKind::Flat, numbers: &[] };
                (0..self.count()).for_each(|number| take(number, flat));
            }
            &Self::Lattice([nx, ny, nz]) => {
                let (row, layer) = (nx as u32, (nx * ny) as u32);
                let mut number = 0;
                for (z, y) in (0..nz - 1).flat_map(|z| (0..ny - 1).map(move |y| (z, y))) {
                    for x in 0..nx - 1 {
                        let v = (x + nx * (y + ny * z)) as u32;
                        let face = [v, v + 1, v + 1 + row, v + row];
                        let [a, b, c, d] = face;
                        let [e, f, g, h] = face.map(|v| v + layer);
                        let kind = CellKind::Solid(vr_core::cells::split::Shape::Hexahedron);
                        take(number, Cell { kind, numbers: &[a, b, c, d, e, f, g, h] });
                        number += 1;
                    }
                }
            }
        }
    }
}

/// Number of cells between the points of a lattice: a flat axis has one layer of them.
fn lattice_cells(dims: [usize; 3]) -> usize {
    dims.iter().map(|&n| n.saturating_sub(1).max(1)).product()
}

/// The faces of a polyhedron's numbers, as far as they are whole.
pub(super) fn faces(numbers: &[u32]) -> impl Iterator<Item = Option<&[u32]>> {
    let count = numbers.first().copied().unwrap_or(0);
    let mut rest = numbers.get(1..).unwrap_or_default();
    (0..count).map(move |_| {
        let (&length, after) = rest.split_first()?;
        let (face, after) = after.split_at_checked(length as usize)?;
        rest = after;
        Some(face)
    })
}

/// A whole number of 32 bits.
fn whole(number: f64) -> Option<u32> {
    (number >= 0.0 && number < f64::from(u32::MAX) && number.fract() == 0.0).then_some(number as u32)
}

fn bad_vertex(cell: usize, found: f64, vertices: usize) -> FieldError {
    FieldError::new(format!("cell {cell}"), format!("vertex {found}"), format!("there are {vertices}, counted from 0"))
}

/// Checks the numbers of a solid cell.
fn check(kind: CellKind, cell: usize, numbers: &[u32], vertices: usize) -> Result<(), FieldError> {
    let there = |all: &[u32]| match all.iter().find(|&&v| v as usize >= vertices) {
        Some(&v) => Err(bad_vertex(cell, f64::from(v), vertices)),
        None => Ok(()),
    };
    let counted = |right: bool, needed: usize| {
        let found = format!("{} vertices", numbers.len());
        if right {
            Ok(())
        } else {
            Err(FieldError::new(format!("cell {cell}"), found, format!("its type needs {needed}")))
        }
    };
    match kind {
        CellKind::Flat => Ok(()),
        CellKind::Solid(shape) => {
            counted(numbers.len() == shape.vertices(), shape.vertices()).and_then(|()| there(numbers))
        }
        CellKind::Curved(shape) => {
            counted(numbers.len() >= shape.vertices(), shape.vertices()).and_then(|()| there(numbers))
        }
        CellKind::Prism(n) => counted(numbers.len() == 2 * n, 2 * n).and_then(|()| there(numbers)),
        CellKind::Polyhedron => {
            let broken = || {
                FieldError::new(format!("cell {cell}"), "faces that end early", "all faces of a polyhedron are listed")
            };
            let mut used = 1;
            for face in faces(numbers) {
                let face = face.ok_or_else(broken)?;
                used += 1 + face.len();
                there(face)?;
            }
            if used == numbers.len() { Ok(()) } else { Err(broken()) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_that_are_not_there_are_named() {
        let mut list = Listed::default();
        list.push(10.0, &[0.0, 1.0, 2.0, 3.0], 4).unwrap();
        // Left out, whatever it names.
        list.push(5.0, &[7.0, 8.0, -1.0], 4).unwrap();
        let error = |vtk, numbers: &[f64]| Listed::default().push(vtk, numbers, 4).unwrap_err().to_string();
        assert_eq!(error(10.0, &[0.0, 1.0, 2.0, 4.0]), "cell 0: found vertex 4; there are 4, counted from 0");
        assert_eq!(error(10.0, &[0.0, 1.0, 2.0, -1.0]), "cell 0: found vertex -1; there are 4, counted from 0");
        assert_eq!(error(12.0, &[0.0, 1.0, 2.0, 3.0]), "cell 0: found 4 vertices; its type needs 8");
        assert!(error(99.0, &[]).starts_with("cell 0, type: found 99"));
        assert!(error(f64::NAN, &[]).contains("found NaN"));
        let list = CellList::Listed(list);
        assert_eq!((list.count(), list.solids()), (2, 1));
    }

    #[test]
    fn faces_must_be_whole() {
        let push = |numbers: &[f64]| Listed::default().push(42.0, numbers, 9).map_err(|e| e.to_string());
        assert!(push(&[2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).is_ok());
        for bad in [&[2.0, 3.0, 0.0, 1.0, 2.0, 4.0, 4.0, 5.0, 6.0][..], &[1.0, 3.0, 0.0, 1.0, 2.0, 9.0], &[4e9], &[]] {
            assert!(push(bad).unwrap_err().contains("faces that end early"), "{bad:?}");
        }
        assert!(push(&[1.0, 3.0, 0.0, 1.0, 9.0]).unwrap_err().contains("vertex 9"));
    }

    #[test]
    fn a_lattice_is_hexahedra_unless_it_is_flat() {
        let mut cells = Vec::new();
        CellList::Lattice([3, 2, 2]).for_each(|number, cell| cells.push((number, cell.numbers.to_vec())));
        assert_eq!(cells, [(0, vec![0, 1, 4, 3, 6, 7, 10, 9]), (1, vec![1, 2, 5, 4, 7, 8, 11, 10])]);
        let flat = CellList::Lattice([3, 2, 1]);
        assert_eq!((flat.count(), flat.solids()), (2, 0));
        flat.for_each(|_, cell| assert_eq!(cell.kind, CellKind::Flat));
    }
}
