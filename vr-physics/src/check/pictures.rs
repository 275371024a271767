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

use vr_core::{
    AnyGrid, Camera, ColorGrid, Control, ControlPoint, Filter, Light, Model, OpacityRule, Placement, Rendered,
    Renderer, Scene, Shading, TransferFunction, UniformGrid, View, Volume, phantom,
};

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

/// Returns a scene of voxels with colours: a ball of smooth values from 0 to 255, most opaque in the middle, in which colours change in waves; white in the transfer
/// function but for a tinge.
pub fn colored_scene(filter: Filter) -> Scene {
    let dims = [17, 15, 16];
    let voxel = |i: usize| {
        let [x, y, z] = [(i % 17) as f64 / 8.0 - 1.0, (i / 17 % 15) as f64 / 7.0 - 1.0, (i / 255) as f64 / 7.5 - 1.0];
        let opacity = 255.0 * (1.0 - 0.7 * (x * x + y * y + z * z)).clamp(0.0, 1.0);
        let wave = |k: f64| 127.0 + 120.0 * libm::sin(k * x + 5.0 * y - 4.0 * z);
        [wave(3.0), wave(7.0), wave(-5.0), opacity].map(|c| c as u8)
    };
    let voxels: Vec<u8> = (0..17 * 15 * 16).flat_map(voxel).collect();
    let placement = Placement::from_spacing([1.0, 1.1, 0.9]).expect("a spacing");
    let colors = ColorGrid::from_components(dims, &voxels, 4, placement).expect("four components a voxel");
    let points = vec![ControlPoint::new(20.0, [1.0; 3], 0.0), ControlPoint::new(255.0, [1.0, 0.9, 0.8], 0.4)];
    let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).expect("two points in order");
    Scene::new(colors.into(), transfer).with_filter(filter)
}

/// Returns a scene of voxels with colours twice: of the values alone, and with every voxel white. They are the same medium.
pub fn plain_and_white(colored: &Scene) -> [Scene; 2] {
    let values = colored.volume.colors().expect("voxels with colours").values();
    let white = [(); 3].map(|()| vec![ColorGrid::WHITE; values.dims().iter().product()]);
    let white = ColorGrid::new(values.as_ref().clone(), white).expect("a colour for each voxel");
    [Volume::Grid(values.clone()), white.into()].map(|volume| Scene { volume, ..colored.clone() })
}

/// Returns looks of a scene of values up to 255: as it is, shaded, with opacity by the gradient as well, and shining with an emission of its own.
pub fn looks_of_bytes(scene: &Scene) -> Vec<(&'static str, Scene)> {
    let plain = Scene { lights: vec![Light::default()], ..scene.clone() };
    let shaded = |shading: Shading| Scene { shading: Some(shading.into()), ..plain.clone() };
    let factors = vec![(0.0, 0.6), (30.0, 1.0)];
    let emitting = [(20.0, 0.0), (255.0, 0.2)].map(|(value, e)| ControlPoint {
        emission: Some([e, 0.5 * e, e]),
        ..ControlPoint::new(value, [1.0; 3], 0.3 * e)
    });
    let emitting = TransferFunction::new(emitting.to_vec(), OpacityRule::Power, 1.0).expect("two points in order");
    vec![
        ("plain", plain.clone()),
        ("shaded", shaded(Shading::default())),
        ("opacity by gradient", shaded(Shading { gradient_opacity: factors, ..Shading::default() })),
        ("emission", Scene { transfer: emitting.into(), ..plain }),
    ]
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
