//! Neighbours of a mesh, as a vector of rays wants them: what lies behind each side of a cell in one row of four numbers.

use vr_core::CellMesh;
use vr_core::cancel::SparsePoll;
use vr_core::cells::{FACES, NO_CELL};

/// For each side of each cell, by which a ray enters: the vertex across, and where the ray goes through each of the other three sides.
///
/// The corners of side `across` of a cell are [`FACES`]`[across]`, counterclockwise from outside. Beyond the side with corners i and i + 1 and the
/// vertex across, a ray enters another cell, by a side whose corners are named from another one on: `4 · side + turn` says both.
pub(crate) struct Links {
    rows: Vec<[u32; 4]>,
}

/// Place of a side that nothing lies beyond.
pub(crate) const OUTSIDE: u32 = u32::MAX;

/// Cells at most: a place takes four bits besides.
const MAX_CELLS: usize = 1 << 28;

impl Links {
    /// Bytes that the links of a mesh take.
    pub(crate) fn bytes(mesh: &CellMesh) -> u64 {
        (mesh.cells().len() * 4 * size_of::<[u32; 4]>()) as u64
    }

    /// The links of a mesh; `None` if it has too many cells.
    pub(crate) fn new(mesh: &CellMesh) -> Option<Self> {
        let (cells, neighbours) = (mesh.cells(), mesh.neighbours());
        if cells.len() >= MAX_CELLS {
            return None;
        }
        let mut rows = Vec::with_capacity(4 * cells.len());
        let mut poll = SparsePoll::default();
        for (cell, names) in cells.iter().enumerate() {
            poll.turn();
            for (across, corners) in FACES.iter().enumerate() {
                let beyond = [0, 1, 2].map(|i| {
                    let next = neighbours[cell][corners[(i + 2) % 3]];
                    if next == NO_CELL {
                        return OUTSIDE;
                    }
                    // The side of the next cell that has the same three vertices, and which of them comes first.
                    let shared = [names[corners[i]], names[corners[(i + 1) % 3]], names[across]];
                    let there = cells[next as usize];
                    let side = (0..4).find(|&i| !shared.contains(&there[i])).unwrap_or(0);
                    let turn = FACES[side].iter().position(|&i| there[i] == shared[0]).unwrap_or(0);
                    16 * next + 4 * side as u32 + turn as u32
                });
                rows.push([names[across], beyond[0], beyond[1], beyond[2]]);
            }
        }
        Some(Self { rows })
    }

    /// Rows by side: 4 · cell + the vertex across.
    #[inline(always)]
    pub(crate) fn rows(&self) -> &[[u32; 4]] {
        &self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, Filter, GridVolume, Placement, UniformGrid};

    #[test]
    fn a_link_leads_to_the_side_with_the_same_corners() {
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid = UniformGrid::new([4; 3], vec![0u8; 64], placement, Calibration::default()).unwrap();
        let mesh = CellMesh::of_grid(&GridVolume::new(grid.into(), Filter::default())).unwrap();
        let links = Links::new(&mesh).unwrap();
        let mut inner = 0;
        for (i, row) in links.rows().iter().enumerate() {
            let names = mesh.cells()[i / 4];
            assert_eq!(row[0], names[i % 4]);
            for (exit, &place) in row[1..].iter().enumerate() {
                if place == OUTSIDE {
                    continue;
                }
                inner += 1;
                let [a, b] = [exit, (exit + 1) % 3].map(|k| names[FACES[i % 4][k]]);
                let (side, turn) = (place as usize / 4, place as usize % 4);
                let there = FACES[side % 4].map(|k| mesh.cells()[side / 4][k]);
                assert_eq!([0, 1, 2].map(|k| there[(turn + k) % 3]), [a, b, row[0]]);
            }
        }
        // Each inner side is the way out of its cell by three entrances, from either cell.
        let surface = mesh.neighbours().iter().flatten().filter(|&&n| n == NO_CELL).count();
        assert_eq!(inner, 3 * (4 * mesh.cells().len() - surface));
    }
}
