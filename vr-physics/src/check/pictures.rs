//! Pictures of small scenes and their errors, for a renderer's own tests: each function panics where there is no picture.
//!
//! ```
//! use vr_core::Model;
//! use vr_physics::check::{faulty_marcher::Marcher, pictures::*};
//!
//! let scene = phantom_scene::<u8>("fog", 8, 1.0);
//! let view = view(&scene, 30.0, 20.0, None, 4);
//! assert_eq!(draw(&Marcher::default(), &scene, &view).frame.size(), [4, 4]);
//! assert_eq!(solve(&scene, &view, &Model::Canonical, 1e-6).len(), 16);
//! assert!(error(&Marcher::default(), &scene, &view).rmse < 0.05);
//! ```

use vr_core::{AnyGrid, Camera, Control, Model, Rendered, Renderer, Scene, UniformGrid, View, phantom};

use crate::{Metrics, Reference};

/// Returns the scene of a phantom sampled at n³ voxels, under its own transfer function with opacities times a factor.
///
/// # Panics
/// Panics if there is no phantom of this name, or no grid of this size.
pub fn phantom_scene<T: phantom::Quantize>(name: &str, n: usize, opacity: f64) -> Scene
where
    AnyGrid: From<UniformGrid<T>>,
{
    let phantom = phantom::by_name(name).expect("a known phantom");
    phantom::sampled_scene::<T>(&*phantom, n, opacity).expect("a valid size")
}

/// Returns a square view of all of a scene's volume; see [`Camera::framing`].
pub fn view(scene: &Scene, azimuth: f64, elevation: f64, fov: Option<f64>, side: u32) -> View {
    View::new(Camera::framing(scene.volume.bounds(), azimuth, elevation, fov), [side; 2])
}

/// Draws a view of a scene.
///
/// # Panics
/// Panics if the renderer cannot.
pub fn draw(renderer: &dyn Renderer, scene: &Scene, view: &View) -> Rendered {
    let control = Control::default();
    renderer.prepare(scene, &control).and_then(|mut p| p.render(view, &control)).expect("a scene that it can draw")
}

/// Returns the pixels of the reference, row by row, solved to a tolerance.
///
/// # Panics
/// Panics if the reference cannot solve them.
pub fn solve(scene: &Scene, view: &View, model: &Model, tolerance: f64) -> Vec<[f64; 4]> {
    let solution = Reference::new(tolerance).solve(scene, view, model, &Control::default());
    solution.expect("a view that it can solve").pixels.iter().map(|p| p.rgba).collect()
}

/// Returns the error of a picture against the reference of the renderer's own model.
///
/// # Panics
/// Panics if the renderer cannot draw the picture, or the reference cannot solve it.
pub fn error_of_model(renderer: &dyn Renderer, scene: &Scene, view: &View) -> Metrics {
    let control = Control::default();
    let mut prepared = renderer.prepare(scene, &control).expect("a scene that it can draw");
    let frame = prepared.render(view, &control).expect("a view that it can draw").frame;
    let model = prepared.model(view).expect("the model of a view that it can draw");
    Metrics::of(&solve(scene, view, &model, 1e-9), frame.pixels())
}

/// Returns the error of a picture against the correct pixels.
///
/// # Panics
/// Panics if the renderer cannot draw the picture, or the reference cannot solve it.
pub fn error(renderer: &dyn Renderer, scene: &Scene, view: &View) -> Metrics {
    Metrics::of(&solve(scene, view, &Model::Canonical, 1e-7), draw(renderer, scene, view).frame.pixels())
}
