//! Errors of one picture by both measures.

use vr_core::{Control, Renderer, Scene, View};
use vr_physics::Metrics;
use vr_physics::check::pictures::solve;
use vr_shearwarp::ShearWarp;

/// Returns the root of the mean square error against the canonical pixels, which are given since several settings share them, and against the renderer's own model.
pub fn both_errors(renderer: &ShearWarp, scene: &Scene, view: &View, canonical: &[[f64; 4]]) -> [f64; 2] {
    let control = Control::default();
    let mut prepared = renderer.prepare(scene, &control).unwrap();
    let frame = prepared.render(view, &control).unwrap().frame;
    let of_model = solve(scene, view, &prepared.model(view).unwrap(), 1e-9);
    [canonical, &of_model].map(|truth| Metrics::of(truth, frame.pixels()).rmse)
}
