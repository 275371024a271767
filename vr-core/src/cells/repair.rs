//! Cells that make no sense, put right or left out.

use glam::DVec3;

use super::FACES;
use super::mesh::CellValues;

/// Number of cells that were put right or left out when a mesh was made.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::cells::{CellMesh, CellRepairs, CellValues};
///
/// let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
/// let cells = vec![[0, 1, 2, 3], [0, 2, 1, 3], [0, 1, 2, 2]];
/// let mesh = CellMesh::new(vertices, cells, CellValues::Vertices(vec![0.0, 1.0, 2.0, 3.0]))?;
/// assert_eq!(mesh.cells().len(), 1);
/// assert_eq!(*mesh.repairs(), CellRepairs { duplicate: 1, degenerate: 1, ..CellRepairs::default() });
/// # Ok::<(), vr_core::cells::CellError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CellRepairs {
    /// Cells whose vertices were given in the order of their mirror image: turned.
    pub inverted: usize,
    /// Cells without a volume: left out.
    pub degenerate: usize,
    /// Cells with the same vertices as one before: left out.
    pub duplicate: usize,
    /// Cells with a value that is not finite, their own or one of a vertex: left out, as vacuum.
    pub missing: usize,
    /// Faces that more than two cells share, or two on the same side: taken for faces of the mesh's surface.
    pub crowded_faces: usize,
}

impl CellRepairs {
    /// True if nothing had to be done.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// A cell is flat if its height above its widest face is this part of its longest edge: rounding leaves nothing of its shape.
const FLAT: f64 = 1e-12;

/// Returns the cells that have a volume and finite values, each once and none inverted, with their numbers in the list that was given.
pub(super) fn sound_cells(
    vertices: &[DVec3],
    cells: &[[u32; 4]],
    values: &CellValues,
) -> (Vec<[u32; 4]>, Vec<u32>, CellRepairs) {
    let mut repairs = CellRepairs::default();
    let is_repeated = repeated(cells);
    let (mut sound, mut numbers) = (Vec::with_capacity(cells.len()), Vec::with_capacity(cells.len()));
    for (number, &cell) in cells.iter().enumerate() {
        let has_value = match values {
            CellValues::Vertices(values) => cell.iter().all(|&v| values[v as usize].is_finite()),
            CellValues::Cells(values) => values[number].is_finite(),
        };
        let volume = volume(cell.map(|v| vertices[v as usize]));
        if volume == 0.0 {
            repairs.degenerate += 1;
        } else if is_repeated[number] {
            repairs.duplicate += 1;
        } else if !has_value {
            repairs.missing += 1;
        } else {
            let [a, b, c, d] = cell;
            repairs.inverted += usize::from(volume < 0.0);
            sound.push(if volume < 0.0 { [a, b, d, c] } else { cell });
            numbers.push(number as u32);
        }
    }
    (sound, numbers, repairs)
}

/// Six times the volume of a tetrahedron, negative for the mirror image; 0 if it is flat.
fn volume(at: [DVec3; 4]) -> f64 {
    let [a, b, c, d] = at;
    let volume = (b - a).cross(c - a).dot(d - a);
    let edges = [b - a, c - a, d - a, c - b, d - b, d - c];
    let longest = edges.into_iter().map(DVec3::length).fold(0.0, f64::max);
    let widest = FACES.map(|[e, f, g]| (at[f] - at[e]).cross(at[g] - at[e]).length()).into_iter().fold(0.0, f64::max);
    // NaN, of numbers beyond what squares can hold, is flat as well.
    if volume.abs() > FLAT * longest * widest { volume } else { 0.0 }
}

/// Tells of each cell if one before it has the same vertices.
fn repeated(cells: &[[u32; 4]]) -> Vec<bool> {
    let key = |number: u32| {
        let mut key = cells[number as usize];
        key.sort_unstable();
        (key, number)
    };
    let mut keys: Vec<_> = (0..cells.len() as u32).map(key).collect();
    keys.sort_unstable();
    let mut is_repeated = vec![false; cells.len()];
    for pair in keys.windows(2) {
        is_repeated[pair[1].1 as usize] = pair[0].0 == pair[1].0;
    }
    is_repeated
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flat_and_mirrored_cells_are_told() {
        let at = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        assert_eq!(volume(at), 1.0);
        assert_eq!(volume([at[0], at[2], at[1], at[3]]), -1.0);
        assert_eq!(volume([at[0], at[1], at[2], DVec3::new(0.3, 0.3, 1e-13)]), 0.0);
        // Thin, yet a cell.
        assert!(volume([at[0], at[1], at[2], DVec3::new(0.3, 0.3, 1e-9)]) > 0.0);
        assert_eq!(volume(at.map(|p| p * 1e300)), 0.0, "its square is beyond all numbers");
    }
}
