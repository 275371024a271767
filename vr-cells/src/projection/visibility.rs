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
    /// Bytes that each cell takes: its place in the order, the number of cells before it, and its place among those that are free.
    pub(super) const BYTES_PER_CELL: usize = 3 * size_of::<u32>();

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera_space::CameraSpace;
    use crate::entries::surface;
    use crate::projection::surface_pairs::SurfacePairs;
    use crate::projection::tiling::Tiling;
    use crate::screen::Screen;
    use glam::DVec3;
    use vr_core::cells::{CellMesh, CellValues};
    use vr_core::{Camera, Control, Projection, View};

    /// The order of a mesh as seen from above.
    fn order(mesh: &CellMesh) -> Visibility {
        let camera = Camera {
            eye: DVec3::Z * 9.0,
            target: DVec3::ZERO,
            up: DVec3::Y,
            projection: Projection::Orthographic { height: 3.0 },
        };
        let view = View::new(camera, [80; 2]);
        let screen = Screen::new(&view, 1, mesh.mean_spacing());
        let vertices = CameraSpace::new(&view).unwrap().vertices::<1>(mesh);
        let on_screen = ScreenMesh::new(mesh, &vertices, &screen, |value| value);
        let tiling = Tiling::new(&view).unwrap();
        let pairs = SurfacePairs::new(&on_screen, &surface(mesh), &tiling, &Control::default()).unwrap();
        assert!(!pairs.unsure.contains(&true));
        Visibility::new(&on_screen, &pairs.pairs)
    }

    /// Cells of four corners each, apart from one another.
    fn apart(cells: &[[DVec3; 4]]) -> CellMesh {
        let vertices: Vec<DVec3> = cells.iter().flatten().copied().collect();
        let names = (0..cells.len() as u32).map(|i| [0, 1, 2, 3].map(|k| 4 * i + k)).collect();
        CellMesh::new(vertices, names, CellValues::Cells(vec![1.0; cells.len()])).unwrap()
    }

    #[test]
    fn cells_apart_are_sorted_by_the_samples_that_see_both() {
        let at = |height: f64| [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|v| v + DVec3::Z * height);
        let found = order(&apart(&[at(-2.0), at(3.0), at(0.0), at(-5.0)]));
        assert_eq!((found.order, found.tangled.len()), (vec![1, 2, 0, 3], 0));
    }

    #[test]
    fn a_ring_is_told_and_what_is_behind_it_comes_later() {
        // Three beams, each of which begins below the one before and ends above the next, over a fourth cell.
        let beam = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / 3.0;
            let (ahead, aside) =
                (DVec3::new(angle.cos(), angle.sin(), 0.0), DVec3::new(-angle.sin(), angle.cos(), 0.0));
            let place = |along: f64, across: f64, up: f64| aside * (0.3 + across) + ahead * along + DVec3::Z * up;
            [place(-1.0, -0.15, -0.3), place(-1.0, 0.15, -0.3), place(1.0, 0.0, 0.25), place(1.0, 0.05, 0.45)]
        };
        let below =
            [DVec3::new(-1.0, -1.0, -3.0), DVec3::new(1.0, -1.0, -3.0), DVec3::Y - DVec3::Z * 3.0, DVec3::Z * -4.0];
        let mut found = order(&apart(&[below, beam(0), beam(1), beam(2)]));
        found.tangled.sort_unstable();
        assert_eq!((found.order[3], found.tangled), (0, vec![1, 2, 3]));
    }
}
