//! Scenes, views, and how pictures are compared.

#![allow(dead_code, reason = "each test file is a program of its own, and none uses all of it")]

use vr_core::phantom::{self};
use vr_core::*;
use vr_physics::{Metrics, Reference};

/// A phantom on n³ samples under its own transfer function, opacities times a factor.
pub fn phantom_scene<T: phantom::Quantize>(name: &str, n: usize, opacity: f64) -> Scene
where
    AnyGrid: From<UniformGrid<T>>,
{
    let phantom = phantom::by_name(name).expect("a known phantom");
    phantom::sampled_scene::<T>(&*phantom, n, opacity).expect("a valid size")
}

pub fn view(scene: &Scene, azimuth: f64, elevation: f64, fov: Option<f64>, side: u32) -> View {
    View::new(Camera::framing(scene.volume.bounds(), azimuth, elevation, fov), [side; 2])
}

pub fn draw(renderer: &dyn Renderer, scene: &Scene, view: &View) -> Rendered {
    let control = Control::default();
    renderer.prepare(scene, &control).and_then(|mut p| p.render(view, &control)).expect("a scene that it can draw")
}

pub fn solve(scene: &Scene, view: &View, model: &Model, tolerance: f64) -> Vec<[f64; 4]> {
    let solution = Reference::new(tolerance).solve(scene, view, model, &Control::default());
    solution.expect("a view that it can solve").pixels.iter().map(|p| p.rgba).collect()
}

/// Against what the renderer says that it sums.
pub fn to_model(renderer: &dyn Renderer, scene: &Scene, view: &View) -> Metrics {
    let control = Control::default();
    let mut prepared = renderer.prepare(scene, &control).expect("a scene that it can draw");
    let frame = prepared.render(view, &control).expect("a view that it can draw").frame;
    Metrics::of(&solve(scene, view, &prepared.model(view).unwrap(), 1e-9), frame.pixels())
}

/// Against the canonical pixel.
pub fn to_truth(renderer: &dyn Renderer, scene: &Scene, view: &View) -> Metrics {
    Metrics::of(&solve(scene, view, &Model::Canonical, 1e-7), draw(renderer, scene, view).frame.pixels())
}
