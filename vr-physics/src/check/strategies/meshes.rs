//! Random meshes of cells, and scenes of them.

use glam::DVec3;
use proptest::prelude::*;
use vr_core::cells::{CellMesh, CellValues};
use vr_core::{Calibration, Filter, GridVolume, Placement, UniformGrid};

use super::assembly;
use super::cameras::generic;
use crate::check::TestScene;

/// Vertices and cells of a box of cubes, six cells each, from 0 to 1 on every axis. Inner vertices are moved on each axis by up to `jitter` of a
/// cube's edge: from 0.3 on, some cells are slivers, or turned inside out.
///
/// # Panics
/// Panics if a number of cubes is 0.
pub fn uneven_cubes(cubes: [usize; 3], jitter: f64, seed: u64) -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let edges = cubes.map(|n| 1.0 / n as f64);
    let dims = cubes.map(|n| n + 1);
    let placement = Placement::from_spacing(edges).expect("at least a cube");
    let grid = UniformGrid::new(dims, vec![0u8; dims.iter().product()], placement, Calibration::default());
    let plain = CellMesh::of_grid(&GridVolume::new(grid.expect("a small grid").into(), Filter::default()));
    let plain = plain.expect("a small mesh");
    let mut random = random_numbers(seed);
    let mut moved = |&vertex: &DVec3| {
        let by = DVec3::new(random(), random(), random()) * 2.0 - 1.0;
        let is_inner = vertex.min_element() > 1e-9 && vertex.max_element() < 1.0 - 1e-9;
        if is_inner { vertex + by * jitter * DVec3::from(edges) } else { vertex }
    };
    (plain.vertices().iter().map(&mut moved).collect(), plain.cells().to_vec())
}

/// Numbers from 0 to 1 by a seed, from the upper bits of a linear congruence (Knuth's constants).
fn random_numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f64 / (1u64 << 24) as f64
    }
}

/// Up to 3³ cubes of six cells: even or uneven, whole or with holes, of any size and place, with values of vertices or of cells.
pub fn cell_mesh() -> impl Strategy<Value = CellMesh> {
    let cubes = [1usize..=3, 1usize..=3, 1usize..=3];
    let jitter = prop_oneof![1 => Just(0.0), 2 => 0.0..0.25];
    let kept = prop_oneof![2 => Just(1.0), 1 => 0.5..1.0];
    let of_cells = prop_oneof![3 => Just(false), 1 => Just(true)];
    let values = prop_oneof![3 => Just([0.0, 1.0]), 1 => Just([-2.0, 4.0]), 1 => Just([1e4, 50.0])];
    let place = (-1.5f64..1.5, prop_oneof![3 => Just(0.0), 1 => Just(200.0)]);
    (cubes, jitter, kept, of_cells, values, place, any::<u64>()).prop_map(
        |(cubes, jitter, kept, of_cells, [first, range], (decades, far), seed)| {
            let (vertices, cells) = uneven_cubes(cubes, jitter, seed);
            let mut random = random_numbers(!seed);
            // The first cell stays.
            let cells: Vec<_> = cells.into_iter().enumerate().filter(|(i, _)| *i == 0 || random() < kept).collect();
            let cells: Vec<[u32; 4]> = cells.into_iter().map(|(_, cell)| cell).collect();
            let scale = libm::pow(10.0, decades);
            let vertices: Vec<DVec3> = vertices.into_iter().map(|v| (v + far) * scale).collect();
            let mut value = || first + range * random();
            let values = if of_cells {
                CellValues::Cells(cells.iter().map(|_| value()).collect())
            } else {
                CellValues::Vertices(vertices.iter().map(|_| value()).collect())
            };
            CellMesh::new(vertices, cells, values).expect("strategies make valid meshes")
        },
    )
}

/// Any scene of a mesh: every transfer function, every compositing, clips, shading where the mesh has gradients.
pub fn mesh_scene() -> impl Strategy<Value = TestScene> {
    assembly::any_scene(cell_mesh(), generic())
}

/// A scene of a mesh whose picture depends continuously on every number: no jumps, no opacity near 1, no threshold, no shading.
pub fn tame_mesh_scene() -> impl Strategy<Value = TestScene> {
    assembly::tame_scene(cell_mesh())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::strategies::drawn::{self, draw, scenes_are_solved, tame_scenes_are_certain};

    #[test]
    fn every_scene_is_solved_and_every_feature_is_drawn() {
        let scenes = draw(mesh_scene(), 300);
        let some = |what: &str, test: &dyn Fn(&TestScene, &CellMesh) -> bool| {
            drawn::some(&scenes, what, |t| test(t, t.scene.volume.cells().unwrap()));
        };
        some("values of cells", &|_, mesh| matches!(mesh.values(), CellValues::Cells(_)));
        some("shading", &|t, _| t.scene.shading.is_some());
        some("clips", &|t, _| t.view.clip.crop.is_some() || !t.view.clip.planes.is_empty());
        some("holes", &|_, mesh| mesh.cells().len() % 6 != 0);
        some("jumps", &|t, _| t.scene.transfer.has_jumps());
        some("walls", &|t, _| t.scene.transfer.segments().iter().any(|s| s.is_opaque()));
        some("an eye inside", &|t, mesh| {
            let (low, high) = mesh.bounds();
            t.view.camera.eye.cmpgt(low).all() && t.view.camera.eye.cmplt(high).all()
        });
        scenes_are_solved(&scenes);
    }

    #[test]
    fn tame_scenes_are_certain_and_most_are_visible() {
        // Meshes that lie 200 of their widths away from the origin lose two digits.
        tame_scenes_are_certain(&draw(tame_mesh_scene(), 200), 1e-7);
    }
}
