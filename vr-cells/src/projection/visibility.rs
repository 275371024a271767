//! Order of cells by visibility: who is seen through whose face (Williams 1992, "Visibility-ordering meshed polyhedra").

use vr_core::cells::NO_CELL;

use super::screen_mesh::ScreenMesh;
use super::strong_components::strong_components;

/// Cells from front to back.
pub(super) struct Visibility {
    /// All cells: none is before one that lies in front of it, but for tangled ones.
    pub(super) order: Vec<u32>,
    /// Cells that lie in front of one another in a ring: no order of them is right for every ray.
    pub(super) tangled: Vec<u32>,
}

/// Pairs of cells, the first of which lies in front of the second though they share no face, in ascending order.
pub(super) type Pairs = Vec<[u32; 2]>;

/// Returns the pairs of a cell.
fn behind(pairs: &Pairs, cell: u32) -> impl Iterator<Item = u32> + '_ {
    let first = if pairs.is_empty() { 0 } else { pairs.partition_point(|p| p[0] < cell) };
    pairs[first..].iter().take_while(move |p| p[0] == cell).map(|p| p[1])
}

impl Visibility {
    /// Sorts the cells of a mesh, of which some pairs are known besides those that share faces.
    pub(super) fn new(mesh: &ScreenMesh<'_>, pairs: &Pairs) -> Self {
        let neighbours = mesh.mesh.neighbours();
        let count = neighbours.len();
        // Cells before each one that have not been taken.
        let mut before = vec![0u32; count];
        for (cell, across) in neighbours.iter().enumerate() {
            let facing = mesh.facing(cell);
            before[cell] = (0..4).filter(|&i| facing.is_front(i) && across[i] != NO_CELL).count() as u32;
        }
        pairs.iter().for_each(|p| before[p[1] as usize] += 1);

        // Take what nothing is before, the last found first: neighbours in the mesh are neighbours in memory.
        let mut order: Vec<u32> = Vec::with_capacity(count);
        let mut free: Vec<u32> = (0..count as u32).filter(|&cell| before[cell as usize] == 0).collect();
        let each_behind = |cell: u32, visit: &mut dyn FnMut(u32)| {
            let facing = mesh.facing(cell as usize);
            for (i, &across) in neighbours[cell as usize].iter().enumerate() {
                if facing.is_back(i) && across != NO_CELL {
                    visit(across);
                }
            }
            behind(pairs, cell).for_each(visit);
        };
        while let Some(cell) = free.pop() {
            order.push(cell);
            each_behind(cell, &mut |next| {
                let left = &mut before[next as usize];
                *left -= 1;
                if *left == 0 {
                    free.push(next);
                }
            });
        }

        // What is left lies in a ring, or behind one.
        let mut tangled = Vec::new();
        if order.len() < count {
            let left: Vec<u32> = (0..count as u32).filter(|&cell| before[cell as usize] > 0).collect();
            for component in strong_components(&left, count, &each_behind).into_iter().rev() {
                if component.len() > 1 {
                    tangled.extend(&component);
                }
                order.extend(component);
            }
        }
        Self { order, tangled }
    }
}
