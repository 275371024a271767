//! Surfaces that would take minutes end soon after they are cancelled.

use std::sync::Arc;
use std::time::Duration;

use glam::DVec3;
use vr_core::{Scene, TriangleMesh};
use vr_mesh::Surface;
use vr_physics::Reference;
use vr_physics::check::pictures::{phantom_scene, view};
use vr_physics::check::time_to_cancel;

/// Triangles one behind the other, each of which covers the picture.
fn stack(count: u32, (low, high): (DVec3, DVec3)) -> TriangleMesh {
    let wide = 10.0 * (high - low);
    let corners = |k: u32| {
        let at = low + (high - low) * (f64::from(k) / f64::from(count));
        [[-1.0, -1.0], [2.0, -1.0], [-1.0, 2.0]].map(|[x, y]| at + DVec3::new(x, y, 0.0) * wide)
    };
    let triangles = (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    TriangleMesh::new((0..count).flat_map(corners).collect(), triangles).unwrap()
}

#[test]
fn bands_end_between_rows_of_triangles() {
    let scene = phantom_scene::<u8>("fog", 8, 0.01);
    let surface = Surface::new(stack(20_000, scene.volume.bounds()));
    let scene = Scene { surfaces: Some(Arc::new(surface)), ..scene };
    // Whatever renderer draws the volume, the layer comes first: hits of 5·10⁹ triangles by rays.
    let view = view(&scene, 10.0, 10.0, None, 512);
    let time = time_to_cancel(&Reference::default(), &scene, &view, Duration::from_millis(200));
    println!("{time:?}");
    assert!(time < Duration::from_millis(300), "{time:?}");
}
