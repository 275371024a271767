//! Opacity that follows the gradient, by factors and by rows of the transfer function, and gradients of either kind: in every texture, against the renderer's own model
//! and against the truth.

use crate::every_setting;

use std::sync::Arc;

use vr_core::*;
use vr_physics::Metrics;
use vr_physics::check::pictures::*;
use vr_texslice::{Blend, Format, Proxy, TextureSlicer};

use crate::every_setting::{FORMATS, looks};

/// Bound of the RMSE of textures of light.
const LIGHT_ERROR: f64 = 2.4e-2;
const VIEWS: [(f64, f64, Option<f64>); 3] = [(33.0, 21.0, None), (-60.0, 50.0, Some(35.0)), (120.0, -70.0, Some(80.0))];

/// A scene with a lone missing voxel, and a corner without any.
fn with_holes(scene: &Scene) -> Scene {
    let grid = scene.volume.grid().unwrap();
    let [nx, ny, nz] = grid.dims();
    let mut samples = grid.filled_floats().unwrap().to_vec();
    for (i, sample) in samples.iter_mut().enumerate() {
        let [x, y, z] = [i % nx, i / nx % ny, i / (nx * ny)];
        if [x, y, z] == [nx / 2 + 3, ny / 2, nz / 2] || x + y + z < 8 {
            *sample = f32::NAN;
        }
    }
    let holed = UniformGrid::new([nx, ny, nz], samples, *grid.placement(), grid.calibration()).unwrap();
    Scene { volume: holed.into(), ..scene.clone() }
}

/// The scene, shining by itself with the colours of its points.
fn shining(scene: &Scene) -> Scene {
    let of = |p: &ControlPoint| ControlPoint { emission: Some(p.color.map(|c| 2.0 * c)), ..*p };
    let points = scene.transfer.points().iter().map(of).collect();
    let transfer = TransferFunction::new(points, scene.transfer.rule(), scene.transfer.unit_distance()).unwrap();
    Scene { transfer: Arc::new(transfer), ..scene.clone() }
}

fn renderers() -> Vec<TextureSlicer> {
    let brute = TextureSlicer::brute_force();
    let mut all: Vec<_> = FORMATS.iter().map(|&format| TextureSlicer { format, ..brute.clone() }).collect();
    for format in [Format::Scalar, Format::PreIntegrated] {
        all.push(TextureSlicer { format, proxy: Proxy::Stacks, ..brute.clone() });
        all.push(TextureSlicer { format, proxy: Proxy::Stacks, slice_spacing: 1.0 / 3.0, ..brute.clone() });
        all.push(TextureSlicer {
            format,
            proxy: Proxy::Shells,
            blend: Blend::BackToFront,
            slice_spacing: 1.3,
            ..brute.clone()
        });
    }
    all
}

/// True if a renderer refuses a scene; checks that it does so for gradients that a texture of light does not have.
fn refuses(renderer: &TextureSlicer, scene: &Scene) -> bool {
    match renderer.supports(scene, None) {
        Ok(()) => false,
        Err(RenderError::Unsupported(Unsupported { feature: Feature::AnalyticGradients, .. })) => {
            assert!(matches!(renderer.format, Format::Rgba | Format::LuminanceAlpha | Format::Paletted));
            true
        }
        Err(other) => panic!("{renderer:?}: {other}"),
    }
}

#[test]
fn pictures_are_what_the_model_sums() {
    let fog = every_setting::grey::<f32>(24);
    let mut worst = [0.0f64; 3];
    let scenes = [every_setting::grey::<u8>(24), with_holes(&fog), shining(&fog)];
    for (k, scene) in scenes.iter().enumerate() {
        for (look, scene) in looks(scene).iter().enumerate() {
            for (r, renderer) in renderers().into_iter().enumerate() {
                if refuses(&renderer, scene) {
                    continue;
                }
                let (azimuth, elevation, fov) = VIEWS[(look + r) % VIEWS.len()];
                let m = error_of_model(&renderer, scene, &view(scene, azimuth, elevation, fov, 20));
                println!(
                    "{k} {look} {:?} {:?} {azimuth}: max {:.1e}, RMSE {:.1e}",
                    renderer.format, renderer.proxy, m.max, m.rmse
                );
                worst[k] = worst[k].max(m.max);
            }
        }
    }
    println!("worst {worst:?}");
    // Rounding in f32: 8·10⁻⁷ at the worst.
    assert!(worst.iter().all(|&worst| worst < 1.5e-6), "{worst:?}");
}

#[test]
fn a_wall_stays_one_under_any_factor_but_zero() {
    let grid =
        UniformGrid::new([4; 3], vec![0u8; 64], Placement::from_spacing([1.0; 3]).unwrap(), Calibration::default());
    let points = [(0.0, 1.0), (1.0, 0.5)].map(|(v, a)| ControlPoint::new(v, [0.5, 0.25, 0.75], a));
    let transfer = TransferFunction::new(points.to_vec(), OpacityRule::Power, 1.0).unwrap();
    let plain = Scene::new(grid.unwrap().into(), transfer);
    for (factor, want) in [(0.5, [0.5, 0.25, 0.75, 1.0]), (1e-3, [0.5, 0.25, 0.75, 1.0]), (0.0, [0.0; 4])] {
        // Nothing reflects where the gradient is zero.
        let shading = Shading { gradient_opacity: vec![(0.0, factor)], ..Shading::default() };
        let scene = Scene { shading: Some(Arc::new(shading)), ..plain.clone() };
        for format in [Format::Scalar, Format::PreIntegrated, Format::Compressed, Format::Rgba, Format::Paletted] {
            let renderer = TextureSlicer { format, ..TextureSlicer::brute_force() };
            let pixel = draw(&renderer, &scene, &view(&scene, 33.0, 21.0, None, 5)).frame.pixel(2, 2);
            // Rounding in f32.
            assert!((0..4).all(|c| (pixel[c] - want[c]).abs() < 1e-6), "{format:?} {factor}: {pixel:?}");
        }
    }
}

#[test]
fn errors_fall_with_the_distance() {
    let fog = phantom_scene::<f32>("fog", 32, 1.0);
    for (look, scene) in looks(&fog).iter().enumerate().skip(2) {
        // The derivative of the interpolant jumps from cell to cell, and what jumps has order 1.
        let analytic = scene.gradient_shading().is_some_and(|s| s.gradient == GradientMethod::Analytic);
        let least = if analytic { 2.5 } else { 10.0 };
        let (azimuth, elevation, fov) = VIEWS[look % 2];
        let view = view(scene, azimuth, elevation, fov, 24);
        let truth = solve(scene, &view, &Model::Canonical, 1e-7);
        for format in [Format::Scalar, Format::PreIntegrated] {
            let [coarse, fine] = [1.0, 0.25].map(|slice_spacing| {
                let renderer = TextureSlicer { format, slice_spacing, ..TextureSlicer::brute_force() };
                Metrics::of(&truth, draw(&renderer, scene, &view).frame.pixels()).rmse
            });
            println!("{look} {format:?}: {coarse:.2e} at a voxel, {fine:.2e} at a quarter: {:.1} times", coarse / fine);
            assert!(fine < coarse / least, "{look} {format:?}: {coarse} {fine}");
        }
    }
}

#[test]
fn textures_of_light_come_near_the_truth() {
    let fog = phantom_scene::<f32>("fog", 32, 1.0);
    for (look, scene) in looks(&fog).iter().enumerate() {
        let view = view(scene, 33.0, 21.0, None, 24);
        let renderers = [Format::Rgba, Format::Paletted].map(|format| TextureSlicer {
            format,
            slice_spacing: 0.25,
            ..TextureSlicer::brute_force()
        });
        let drawn: Vec<_> = renderers.iter().filter(|renderer| !refuses(renderer, scene)).collect();
        if drawn.is_empty() {
            continue;
        }
        let truth = solve(scene, &view, &Model::Canonical, 1e-7);
        for renderer in drawn {
            let format = renderer.format;
            let m = Metrics::of(&truth, draw(renderer, scene, &view).frame.pixels());
            println!("{look} {format:?}: {m}");
            // Measured, and half as much again: what is classified before it is interpolated; 256 levels of the magnitude add nothing to it.
            assert!(m.rmse < LIGHT_ERROR, "{look} {format:?}: {m}");
        }
    }
}
