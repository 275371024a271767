//! Kinds of cells, by the numbers that VTK gives them (`vtkCellType.h`).

use vr_core::cells::split::Shape;

/// Kind of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CellKind {
    /// Vertices, lines and surfaces, or nothing at all.
    Flat,
    /// A shape with straight edges.
    Solid(Shape),
    /// A shape with vertices on its edges, faces or inside besides the corners, which come first.
    Curved(Shape),
    /// A prism over a polygon of this many corners.
    Prism(usize),
    /// Any faces, listed one after the other.
    Polyhedron,
}

impl CellKind {
    /// The kind of one of VTK's numbers; `None` for a number of no kind, or of one whose faces are not told by its vertices.
    pub fn of_vtk(number: u8) -> Option<Self> {
        use Shape::{Hexahedron, Pyramid, Tetrahedron, Voxel, Wedge};
        Some(match number {
            0..=9 | 21..=23 | 28 | 30 | 34..=36 | 51..=54 | 68..=70 | 75..=77 => Self::Flat,
            10 => Self::Solid(Tetrahedron),
            11 => Self::Solid(Voxel),
            12 => Self::Solid(Hexahedron),
            13 => Self::Solid(Wedge),
            14 => Self::Solid(Pyramid),
            15 => Self::Prism(5),
            16 => Self::Prism(6),
            24 | 71 | 78 => Self::Curved(Tetrahedron),
            25 | 29 | 33 | 72 | 79 => Self::Curved(Hexahedron),
            26 | 31 | 32 | 73 | 80 => Self::Curved(Wedge),
            27 | 37 | 74 | 81 => Self::Curved(Pyramid),
            42 => Self::Polyhedron,
            _ => return None,
        })
    }

    /// True if cells of the kind have a volume.
    pub fn is_solid(self) -> bool {
        self != Self::Flat
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_have_vtks_numbers() {
        assert_eq!(CellKind::of_vtk(12), Some(CellKind::Solid(Shape::Hexahedron)));
        assert_eq!(CellKind::of_vtk(25), Some(CellKind::Curved(Shape::Hexahedron)));
        assert_eq!(CellKind::of_vtk(9), Some(CellKind::Flat));
        assert_eq!(CellKind::of_vtk(41), None, "a convex set of points");
        assert_eq!(CellKind::of_vtk(99), None);
        assert!(CellKind::Polyhedron.is_solid() && !CellKind::Flat.is_solid());
    }
}
