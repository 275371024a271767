//! Renderers that take a layer, with a surface in it.

use std::sync::Arc;

use glam::DVec3;
use vr_core::{Camera, Clip, Control, Plane, Renderer, Scene, Shading, TriangleMesh, View};
use vr_mesh::Surface;
use vr_physics::Reference;
use vr_raycast::{RayCaster, Step};
use vr_study::subject::phantom_subjects;

/// A plane at a depth is a ray cut there: a square of two triangles across the volume hides what a clip plane in its place takes away,
/// in the ray caster as in the reference; and the two agree.
#[test]
fn a_plane_at_a_depth_is_a_ray_cut_there() {
    let control = Control::default();
    let caster = RayCaster { step: Step::Uniform(0.1), ..RayCaster::default() };
    // And how far apart layer and clip may be: rounding in f32 over hundreds of steps, and of the layer's depth to f32.
    let renderers: [(Box<dyn Renderer>, f32); 2] = [(Box::new(caster), 2e-5), (Box::new(Reference::default()), 2e-6)];
    for subject in phantom_subjects(24, [20; 2]).expect("enough samples") {
        let (low, high) = subject.scene.volume.bounds();
        let (middle, normal) = (0.5 * (low + high), DVec3::new(1.0, 2.0, 2.0) / 3.0);
        let right = normal.any_orthonormal_vector() * 20.0 * (high - low).length();
        let up = normal.cross(right);
        let corners = [-right - up, right - up, right + up, up - right].map(|p| middle + p);
        let square = TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).expect("a square");
        let shading = Shading { ambient: 1.0, diffuse: 0.0, specular: 0.0, ..Shading::default() };
        let surface = Surface { color: Some([0.25, 0.5, 2.0]), shading, ..Surface::new(square) };
        let with_square = Scene { surfaces: Some(Arc::new(surface)), ..subject.scene.clone() };
        for fov in [None, Some(35.0)] {
            let view = View::new(Camera::framing((low, high), 25.0, 15.0, fov), [20; 2]);
            let layer = with_square.layer(&view, &control).expect("a layer").expect("of a square");
            let plane = Plane { normal, offset: normal.dot(middle) };
            let cut = View { clip: Clip { planes: vec![plane], crop: None }, ..view.clone() };
            let mut frames = Vec::new();
            for (renderer, bound) in &renderers {
                let draw = |scene: &Scene, view: &View| {
                    let mut prepared = renderer.prepare(scene, &control).expect("a scene");
                    prepared.render(view, &control).expect("a picture").frame
                };
                let (layered, cut) = (draw(&with_square, &view), draw(&subject.scene, &cut));
                let size = cut.pixels().iter().flatten().fold(1.0, |m: f32, &x| m.max(x));
                for (i, (found, cut)) in layered.pixels().iter().zip(cut.pixels()).enumerate() {
                    let expected = layer.under(i, cut.map(f64::from));
                    for c in 0..4 {
                        let error = (found[c] - expected[c] as f32).abs() / size;
                        assert!(
                            error < *bound,
                            "{} {} {fov:?}, pixel {i}: off by {error}",
                            subject.name,
                            renderer.name()
                        );
                    }
                }
                frames.push(layered);
            }
            // The correct picture jumps in shells and shepp-logan, which steps of a tenth of a voxel see to within a step.
            let rough = ["shells", "shepp-logan", "marschner-lobb"].contains(&subject.name.as_str());
            let far = frames[0].pixels().iter().flatten().zip(frames[1].pixels().iter().flatten());
            let worst = far.fold(0.0, |m: f32, (a, b)| m.max((a - b).abs()));
            assert!(rough || worst < 1e-3, "{} {fov:?}: the ray caster is off by {worst}", subject.name);
        }
    }
}
