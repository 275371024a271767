//! Cells that share a face.

/// Neighbour across a face of the mesh's surface: there is none.
pub const NO_CELL: u32 = u32::MAX;

/// A face of a cell, named by its vertices in ascending order.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Face {
    vertices: [u32; 3],
    cell: u32,
    /// Vertex of the cell across from it.
    across: u8,
    /// True if the vertices, in ascending order, are counterclockwise seen from outside the cell.
    outward: bool,
}

/// Returns, for each vertex of each cell, the cell across the face across from it; and the number of faces that more than two cells share, or two on the
/// same side. These have no neighbours.
pub(super) fn neighbours(cells: &[[u32; 4]]) -> (Vec<[u32; 4]>, usize) {
    let mut faces: Vec<Face> = Vec::with_capacity(4 * cells.len());
    for (number, cell) in cells.iter().enumerate() {
        for (across, face) in super::FACES.iter().enumerate() {
            let (vertices, outward) = ascending(face.map(|i| cell[i]));
            faces.push(Face { vertices, cell: number as u32, across: across as u8, outward });
        }
    }
    faces.sort_unstable();
    let mut neighbours = vec![[NO_CELL; 4]; cells.len()];
    let mut crowded = 0;
    for same in faces.chunk_by(|a, b| a.vertices == b.vertices) {
        match same {
            [_] => {}
            [a, b] if a.outward != b.outward => {
                neighbours[a.cell as usize][usize::from(a.across)] = b.cell;
                neighbours[b.cell as usize][usize::from(b.across)] = a.cell;
            }
            _ => crowded += 1,
        }
    }
    (neighbours, crowded)
}

/// Three vertices in ascending order, and true if that is an even permutation.
pub(super) fn ascending([mut a, mut b, mut c]: [u32; 3]) -> ([u32; 3], bool) {
    let mut even = true;
    if a > b {
        (a, b, even) = (b, a, !even);
    }
    if b > c {
        (b, c, even) = (c, b, !even);
    }
    if a > b {
        (a, b, even) = (b, a, !even);
    }
    ([a, b, c], even)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_cells_meet_in_a_face() {
        let (neighbours, crowded) = neighbours(&[[0, 1, 2, 3], [1, 2, 3, 4]]);
        assert_eq!(crowded, 0);
        assert_eq!(neighbours, [[1, NO_CELL, NO_CELL, NO_CELL], [NO_CELL, NO_CELL, NO_CELL, 0]]);
    }

    #[test]
    fn crowded_faces_are_counted_and_left_open() {
        // The second cell lies on the same side of the face as the first; then a third cell.
        let (found, crowded) = neighbours(&[[0, 1, 2, 3], [4, 1, 2, 3]]);
        assert_eq!((found[0], crowded), ([NO_CELL; 4], 1));
        let (found, crowded) = neighbours(&[[0, 1, 2, 3], [1, 2, 3, 4], [1, 2, 3, 5]]);
        assert_eq!((found, crowded), (vec![[NO_CELL; 4]; 3], 1));
    }

    #[test]
    fn parity_follows_the_order() {
        assert_eq!(ascending([5, 7, 9]), ([5, 7, 9], true));
        assert_eq!(ascending([7, 9, 5]), ([5, 7, 9], true));
        assert_eq!(ascending([9, 7, 5]), ([5, 7, 9], false));
    }
}
