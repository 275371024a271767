//! A surface among a volume, against the reference.

use std::sync::Arc;

use glam::DVec3;
use vr_core::{Camera, Clip, Control, Model, Plane, Projection, Scene, Shading, TriangleMesh, View, phantom};
use vr_mesh::Surface;
use vr_physics::Reference;

fn scene() -> Scene {
    let blobs = phantom::by_name("blobs").expect("a phantom");
    phantom::sampled_scene::<f32>(&*blobs, 24, 1.0).expect("a grid")
}

/// A plane at a depth z is the same as cutting the ray at z: a square of two triangles across the volume hides exactly what a
/// clip plane in its place takes away.
#[test]
fn a_plane_at_a_depth_is_a_ray_cut_there() {
    let scene = scene();
    let (low, high) = scene.volume.bounds();
    let middle = 0.5 * (low + high);
    let wide = 10.0 * (high - low).length();
    let reference = Reference::default();
    let control = Control::default();
    let shading = Shading { ambient: 1.0, diffuse: 0.0, specular: 0.0, ..Shading::default() };
    let color = [0.25, 0.5, 2.0];
    let mut hidden: f64 = 0.0;
    for normal in [DVec3::Z, DVec3::new(1.0, 2.0, 2.0) / 3.0] {
        let across = normal.any_orthonormal_vector() * wide;
        let [right, up] = [across, normal.cross(across)];
        let corners = [-right - up, right - up, right + up, up - right].map(|p| middle + p);
        let square = TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).expect("a square");
        for fov in [None, Some(35.0)] {
            let camera = Camera::framing((low, high), 25.0, 15.0, fov);
            let view = View::new(camera, [12, 12]);
            let surface = Surface { color: Some(color), shading: shading.clone(), ..Surface::new(square.clone()) };
            let with_square = Scene { surfaces: Some(Arc::new(surface)), ..scene.clone() };
            let layer = with_square.layer(&view, &control).expect("a layer").expect("of a square");
            assert!(layer.pixels.iter().all(|p| p.0 == color.map(|c| c as f32) && p.1.is_finite()));
            let solve_of = |scene: &Scene, view: &View| {
                reference.solve(scene, view, &Model::Canonical, &control).expect("a solution")
            };
            let solve = |view: &View| solve_of(&scene, view);
            let layered = solve_of(&with_square, &view);
            let plane = Plane { normal, offset: normal.dot(middle) };
            let cut = solve(&View { clip: Clip { planes: vec![plane], crop: None }, ..view.clone() });
            let whole = solve(&view);
            for (i, (layered, cut)) in layered.pixels.iter().zip(&cut.pixels).enumerate() {
                let expected = layer.under(i, cut.rgba);
                for c in 0..4 {
                    let error = (layered.rgba[c] - expected[c]).abs();
                    // The layer's depth is rounded to f32: 6e-8 of it, times κ and the colour, some 10 a unit here.
                    assert!(error < 2e-6, "{normal} {fov:?} pixel {i}: off by {error}");
                    hidden = hidden.max((whole.pixels[i].rgba[c] - cut.rgba[c]).abs());
                }
            }
            if matches!(view.camera.projection, Projection::Orthographic { .. }) {
                assert!(camera.eye.dot(normal) > middle.dot(normal), "the eye is on the kept side");
            }
        }
    }
    assert!(hidden > 0.05, "what the plane hides is seen without it: {hidden}");
}
