//! Both renderers against the reference with the eye among the cells: inside one, on a face, an edge or a vertex of several, and in a hollow of the mesh.

use crate::meshes::{errors, mesh, transfer};
#[allow(dead_code, reason = "each test file compiles the whole module")]
use glam::DVec3;
use vr_cells::{CellMarcher, CellProjector};
use vr_core::{Camera, Clip, Plane, Projection, Renderer, Scene, View};

#[test]
fn every_place_of_the_eye_is_exact() {
    // Cubes of a quarter: the hollow is around (0.75, 0.5, 0.5).
    let at = DVec3::new;
    for (jitter, eyes) in [
        (0.0, vec![at(0.5, 0.5, 0.5), at(0.25, 0.25, 0.3), at(0.4, 0.4, 0.3), at(0.25, 0.4, 0.31)]),
        (
            0.25,
            vec![
                at(0.31, 0.42, 0.53),
                at(0.12, 0.87, 0.2),
                at(0.75, 0.5, 0.5),
                at(0.97, 0.03, 0.5),
                at(-0.05, 0.5, 0.5),
            ],
        ),
    ] {
        let mesh = mesh(4, jitter, false, |p| (p - at(0.75, 0.5, 0.5)).length() < 0.2);
        let scene = Scene::new(mesh.into(), transfer(0.4));
        for eye in eyes {
            for toward in [at(1.0, 0.3, -0.2), at(-0.4, 0.1, 0.9), at(0.0, -1.0, 0.0)] {
                let camera = Camera {
                    eye,
                    target: eye + toward,
                    up: at(0.1, 0.2, 1.0),
                    projection: Projection::Perspective { fov: 90.0 },
                };
                let planes = vec![Plane { normal: at(0.3, 1.0, 0.2), offset: 0.7 }];
                for clip in [Clip::default(), Clip { crop: None, planes }] {
                    let view = View { clip, ..View::new(camera, [24, 21]) };
                    let renderers: [(&dyn Renderer, f64); 2] =
                        [(&CellMarcher::default(), 1e-5), (&CellProjector::default(), 1e-3)];
                    for (renderer, allowed) in renderers {
                        let (error, _) = errors(renderer, &scene, &view);
                        assert!(error < allowed, "{} from {eye} toward {toward}: {error}", renderer.name());
                    }
                }
            }
        }
    }
}

#[test]
fn an_eye_beside_a_vertex_of_a_hollow_is_exact() {
    let middle = DVec3::new(0.75, 0.5, 0.5);
    // The hollow is a cube of eight cells around the middle: its corners, and places on its edges beside them.
    let corner = DVec3::new(0.5, 0.25, 0.25);
    let mesh = mesh(4, 0.0, false, |p| (p - middle).length() < 0.2);
    let scene = Scene::new(mesh.into(), transfer(0.4));
    for along in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 1.0, 0.0), DVec3::ONE] {
        for distance in [0.0, 1e-7, 1e-3, 0.1] {
            for toward in [DVec3::new(1.0, 0.3, -0.2), DVec3::new(-0.4, 0.1, 0.9), DVec3::new(0.0, -1.0, 0.0)] {
                let eye = corner + distance * along;
                let projection = Projection::Perspective { fov: 90.0 };
                let camera = Camera { eye, target: eye + toward, up: DVec3::new(0.1, 0.2, 1.0), projection };
                let view = View::new(camera, [24, 21]);
                let renderers: [(&dyn Renderer, f64); 2] =
                    [(&CellMarcher::default(), 1e-5), (&CellProjector::default(), 1e-3)];
                for (renderer, allowed) in renderers {
                    let (error, _) = errors(renderer, &scene, &view);
                    let place = format!("{distance} along {along} toward {toward}");
                    assert!(error < allowed, "{}, {place}: {error}", renderer.name());
                }
            }
        }
    }
}
