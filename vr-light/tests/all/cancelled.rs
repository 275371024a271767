//! Light that would take minutes ends soon after it is cancelled: along a path, along a ray of short steps, and within a ray's quadrature.

use std::sync::Arc;
use std::time::Duration;

use glam::DVec3;
use vr_core::scattering::{Albedo, Scattering};
use vr_core::{
    Calibration, Camera, ControlPoint, OpacityRule, Placement, Projection, Scene, TransferFunction, UniformGrid, View,
    phantom,
};
use vr_light::{LightRenderer, Method};
use vr_physics::check::pictures::view;
use vr_physics::check::time_to_cancel;

fn end(what: &str, renderer: &LightRenderer, scene: &Scene, view: &View) {
    let time = time_to_cancel(renderer, scene, view, Duration::from_millis(200));
    println!("{what}: {time:?}");
    assert!(time < Duration::from_millis(300), "{what}: {time:?}");
}

/// Fog that scatters so much of the light.
fn fog(size: usize, albedo: f64) -> Scene {
    let mut scene = phantom::by_name("fog").unwrap().scene(size).unwrap();
    scene.scattering = Some(Arc::new(Scattering { albedo: Albedo::Constant([albedo; 3]), ..Scattering::default() }));
    scene
}

/// A needle that is hardly seen, four thousand cells long, and the ray along it.
fn needle() -> (Scene, View) {
    let placement = Placement::from_spacing([0.01, 0.01, 1.0]).unwrap();
    let grid = UniformGrid::new([2, 2, 4097], vec![1u8; 4 * 4097], placement, Calibration::default()).unwrap();
    let faint = TransferFunction::new(vec![ControlPoint::new(1.0, [0.5; 3], 1e-9)], OpacityRule::Extinction, 1.0);
    let mut scene = Scene::new(grid.into(), faint.unwrap());
    scene.scattering = Some(Arc::default());
    let camera = Camera {
        eye: DVec3::new(0.005, 0.005, -1.0),
        target: DVec3::new(0.005, 0.005, 0.0),
        up: DVec3::Y,
        projection: Projection::Orthographic { height: 0.001 },
    };
    (scene, View::new(camera, [1, 1]))
}

#[test]
fn paths_end_where_they_are() {
    let scene = fog(33, 0.9);
    let all = LightRenderer { paths: 1_000_000, ..LightRenderer::default() };
    end("full", &all, &scene, &view(&scene, 30.0, 20.0, None, 64));
    // A pixel alone, and paths that hardly ever end by themselves.
    end("one pixel", &all, &fog(9, 1.0), &view(&scene, 30.0, 20.0, None, 1));
}

#[test]
fn light_that_is_scattered_once_ends_where_it_is() {
    let scene = fog(33, 0.9);
    let single = LightRenderer { method: Method::Single, ..LightRenderer::default() };
    let large = view(&scene, 30.0, 20.0, None, 512);
    // A ray alone, of ten million steps; then tiles of a million rays.
    let (thin, along) = needle();
    end("ray", &LightRenderer { step: 1e-3, ..single.clone() }, &thin, &along);
    let supersampled = View { supersampling: 32, ..large };
    end("steps", &single, &scene, &supersampled);
    end("exact", &LightRenderer { exact: true, ..single }, &scene, &supersampled);
}
