//! Rectilinear grids against the reference: order, operators, holes, and steps that follow the cells.

use glam::DVec3;
use vr_core::rectilinear::{Centering, RectilinearGrid};
use vr_core::{
    Calibration, Camera, Clip, Compositing, Control, ControlPoint, Frame, Model, OpacityRule, Placement, Renderer,
    Scene, Shading, TransferFunction, UniformGrid, View,
};
use vr_physics::Reference;
use vr_physics::metrics::Metrics;
use vr_raycast::RayCaster;

/// Values of waves whose lengths are those of the cells: fine near the lower corner, thirty times coarser at the upper one.
fn grid(hole: bool) -> RectilinearGrid {
    let axis = |n: i32| (0..n).map(|k| 0.05 * (1.0 - 1.2f64.powi(k)) / -0.2).collect::<Vec<_>>();
    let axes = [axis(20), axis(18), axis(19)];
    let mut values = Vec::new();
    for k in 0..19 {
        for j in 0..18 {
            let wave = |i: i32| {
                0.5 + 0.25 * (0.9 * f64::from(i) + 0.4 * f64::from(j)).sin() + 0.2 * (0.7 * f64::from(k)).cos()
            };
            values.extend((0..20).map(|i| wave(i) as f32));
        }
    }
    if hole {
        values[7 + 20 * (9 + 18 * 8)] = f32::NAN;
    }
    RectilinearGrid::new(axes, values, Centering::Points).unwrap()
}

fn transfer() -> TransferFunction {
    let points = [(0.3, [0.1, 0.3, 0.9], 0.0), (0.6, [0.9, 0.7, 0.2], 0.2), (1.0, [1.0; 3], 0.5)];
    let points = points.map(|(value, color, opacity)| ControlPoint::new(value, color, opacity));
    TransferFunction::new(points.to_vec(), OpacityRule::Power, 0.4).unwrap()
}

fn drawn(scene: &Scene, view: &View, caster: &RayCaster) -> (Frame, u64) {
    let control = Control::default();
    let rendered = caster.prepare(scene, &control).unwrap().render(view, &control).unwrap();
    (rendered.frame, rendered.stats.counts.samples)
}

fn error(scene: &Scene, step: f64) -> (Metrics, u64) {
    let view = View::new(Camera::framing(scene.bounds(), 35.0, 25.0, Some(40.0)), [20, 20]);
    let (frame, samples) = drawn(scene, &view, &RayCaster::uniform(step));
    let solved = Reference::new(1e-8).solve(scene, &view, &Model::Canonical, &Control::default()).unwrap();
    let pixels: Vec<[f64; 4]> = solved.pixels.iter().map(|p| p.rgba).collect();
    (Metrics::of(&pixels, frame.pixels()), samples)
}

#[test]
fn steps_follow_the_cells_and_converge() {
    for hole in [false, true] {
        let scene = Scene::new(grid(hole).into(), transfer());
        let [(coarse, few), (fine, many)] = [1.0, 0.25].map(|step| error(&scene, step));
        assert!(coarse.rmse < 2e-2 && fine.rmse < coarse.rmse / 6.0, "{hole}: {coarse}, then {fine}");
        assert!(many < 6 * few, "{few}, then {many}");
    }
    let shaded = Scene { shading: Some(Shading::default().into()), ..Scene::new(grid(false).into(), transfer()) };
    let (fine, _) = error(&shaded, 0.125);
    assert!(fine.rmse < 3e-3, "{fine}");
}

#[test]
fn every_operator_is_drawn() {
    for compositing in [
        Compositing::Maximum,
        Compositing::Minimum,
        Compositing::Average,
        Compositing::First { threshold: 0.7 },
        Compositing::Accumulate { level: 0.5 },
    ] {
        let scene = Scene { compositing, ..Scene::new(grid(false).into(), transfer()) };
        let (m, _) = error(&scene, 0.1);
        assert!(m.rmse < 5e-3, "{}: {m}", compositing.name());
    }
}

/// Even axes: the picture of the uniform grid of the same values, in the same steps but for their lattice.
#[test]
fn even_axes_look_like_a_uniform_grid() {
    let n = 12;
    let axes: [Vec<f64>; 3] = std::array::from_fn(|_| (0..n).map(|k| f64::from(k) * 0.5).collect());
    let values: Vec<f32> = (0..n * n * n)
        .map(|i| 0.5 + 0.4 * (f64::from(i % n) * 0.8 + f64::from(i / n) * 0.05).sin())
        .map(|v| v as f32)
        .collect();
    let uniform =
        UniformGrid::new([12; 3], values.clone(), Placement::from_spacing([0.5; 3]).unwrap(), Calibration::default());
    let uneven = RectilinearGrid::new(axes, values, Centering::Points).unwrap();
    let clip = Clip { crop: Some((DVec3::splat(0.3), DVec3::splat(5.0))), ..Clip::default() };
    let scenes = [Scene::new(uniform.unwrap().into(), transfer()), Scene::new(uneven.into(), transfer())];
    let view = View { clip, ..View::new(Camera::framing(scenes[0].bounds(), 35.0, 25.0, None), [24, 24]) };
    let [a, b] = scenes.map(|scene| drawn(&scene, &view, &RayCaster::uniform(0.05)).0);
    let off =
        a.pixels().iter().zip(b.pixels()).flat_map(|(a, b)| (0..4).map(|c| (a[c] - b[c]).abs())).fold(0.0, f32::max);
    assert!(off < 2e-4, "{off}");
}
