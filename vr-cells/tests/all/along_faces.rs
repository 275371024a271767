//! Both renderers against the reference where rays run along faces and edges of cells, through values that vary: parallel to them, and from an eye in their planes.

use crate::meshes::{errors, mesh, transfer};
#[allow(dead_code, reason = "each test file compiles the whole module")]
use glam::DVec3;
use vr_cells::{CellMarcher, CellProjector};
use vr_core::{Camera, Projection, Renderer, Scene, View};

#[test]
fn rays_along_faces_keep_their_way() {
    let at = DVec3::new;
    let scene = Scene::new(mesh(4, 0.0, false, |_| false).into(), transfer(0.4));
    let middle = DVec3::splat(0.5);
    for toward in [
        at(1.0, 0.0, 0.0),
        at(0.0, -1.0, 0.0),
        at(1.0, 1.0, 0.0),
        at(0.0, 1.0, -1.0),
        at(1.0, 1.0, 1.0),
        at(1.0, 0.4, 0.0),
    ] {
        for up in [at(0.1, 0.2, 1.0), at(0.0, 0.5, 1.0)] {
            for projection in [Projection::Orthographic { height: 1.25 }, Projection::Perspective { fov: 25.0 }] {
                let camera = Camera { eye: middle - 3.0 * toward, target: middle, up, projection };
                for size in [[20, 20], [21, 21]] {
                    // The projector sees the transfer function's jump as a ramp, which a ray along cells of a quarter may stay in (see the crate's page).
                    let renderers: [(&dyn Renderer, f64); 2] =
                        [(&CellMarcher::default(), 1e-5), (&CellProjector::default(), 6e-3)];
                    for (renderer, allowed) in renderers {
                        let (error, _) = errors(renderer, &scene, &View::new(camera, size));
                        let name = renderer.name();
                        assert!(error < allowed, "{name} toward {toward}, {up} up, {projection:?}, {size:?}: {error}");
                    }
                }
            }
        }
    }
}
