//! The surface on which a field reaches a threshold, against the reference.

use std::sync::Arc;

use vr_core::*;
use vr_physics::check::pictures::*;
use vr_physics::{Metrics, Reference};
use vr_shearwarp::ShearWarp;

const VIEWS: [(f64, f64, Option<f64>); 3] = [(0.0, 0.0, None), (33.0, 21.0, None), (-60.0, 50.0, Some(35.0))];

/// Root of the mean square error of colours, median error of depths in voxels, and the share of pixels that but one of the two meets.
fn errors(renderer: &ShearWarp, scene: &Scene, view: &View) -> [f64; 3] {
    let solution = Reference::new(1e-7).solve(scene, view, &Model::Canonical, &Control::default()).expect("solvable");
    let frame = draw(renderer, scene, view).frame;
    let colors: Vec<[f64; 4]> = solution.pixels.iter().map(|p| p.rgba).collect();
    let both = frame.depth().unwrap().iter().zip(&solution.pixels).map(|(&a, p)| (f64::from(a), p.depth));
    let (mut off, mut alone) = (Vec::new(), 0);
    for (a, b) in both {
        alone += usize::from(a.is_finite() != b.is_finite());
        if a.is_finite() && b.is_finite() {
            off.push((a - b).abs() / scene.volume.mean_spacing());
        }
    }
    off.sort_by(f64::total_cmp);
    assert!(off.len() > colors.len() / 16, "only {} pixels see a surface", off.len());
    [Metrics::of(&colors, frame.pixels()).rmse, off[off.len() / 2], alone as f64 / colors.len() as f64]
}

#[test]
fn surfaces_lie_between_slices() {
    let compositing = Compositing::First { threshold: 0.45 };
    let plain = Scene { compositing, ..phantom_scene::<f32>("fog", 24, 1.0) };
    let shaded =
        |gradient| Scene { shading: Some(Arc::new(Shading { gradient, ..Shading::default() })), ..plain.clone() };
    let scenes = [
        ("plain", plain.clone()),
        ("central differences", shaded(GradientMethod::CentralDifferences)),
        ("analytic", shaded(GradientMethod::Analytic)),
    ];
    for (name, scene) in scenes {
        for (azimuth, elevation, fov) in VIEWS {
            let view = view(&scene, azimuth, elevation, fov, 24);
            let of = |texel| errors(&ShearWarp { texel, ..ShearWarp::default() }, &scene, &view);
            let [coarse, fine] = [1.0, 0.125].map(of);
            println!("{name} {azimuth}: {coarse:.4?}, {fine:.4?}");
            // Depths: a factor of 64 is second order over three halvings. Colours: of outlines, and gradients that jump between cells.
            assert!(fine[1] < 2e-3 && fine[1] < (coarse[1] / 12.0).max(1e-5), "{name}: {coarse:?} {fine:?}");
            assert!(
                fine[0] < 0.08 && fine[0] < 0.7 * coarse[0].max(0.03) && fine[2] < 0.02,
                "{name}: {coarse:?} {fine:?}"
            );
        }
    }
}

/// Layers from 0 to 12 along z, of which some values are missing.
fn layers(stored: impl Fn(usize) -> f32, slope: f64) -> Scene {
    let samples: Vec<f32> = (0..5 * 5 * 13).map(|i| stored(i / 25)).collect();
    let calibration = Calibration { slope, intercept: 0.0 };
    let grid = UniformGrid::new([5, 5, 13], samples, Placement::from_spacing([1.0; 3]).unwrap(), calibration).unwrap();
    let points = vec![ControlPoint::new(0.0, [0.0, 1.0, 0.0], 1.0), ControlPoint::new(12.0, [1.0, 0.0, 0.0], 1.0)];
    let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
    Scene { compositing: Compositing::First { threshold: 3.3 }, ..Scene::new(grid.into(), transfer) }
}

/// Depth and colour in the middle of a view along +z from z = −10.
fn middle(scene: &Scene, clip: Clip, renderer: &ShearWarp) -> (f32, [f32; 4]) {
    let (eye, target) = (glam::DVec3::new(2.1, 1.9, -10.0), glam::DVec3::new(2.1, 1.9, 0.0));
    let camera = Camera { eye, target, up: glam::DVec3::Y, projection: Projection::Orthographic { height: 2.0 } };
    let view = View { clip, ..View::new(camera, [5, 5]) };
    let frame = draw(renderer, scene, &view).frame;
    (frame.depth().unwrap()[12], frame.pixel(2, 2))
}

#[test]
fn entries_count_wherever_the_volume_begins() {
    let near = |(depth, [r, g, _, a]): (f32, [f32; 4]), at: f32, value: f32| {
        assert!((depth - at).abs() < 1e-3 && (r - value / 12.0).abs() < 1e-4, "{depth} {r}, not {at} {value}");
        assert!((r + g - 1.0).abs() < 1e-5 && a == 1.0);
    };
    for renderer in [ShearWarp::default(), ShearWarp { slice_distance: 1.0, ..ShearWarp::default() }] {
        let whole = Clip::default();
        // A ramp, with either sign of the stored numbers.
        near(middle(&layers(|k| k as f32, 1.0), whole.clone(), &renderer), 13.3, 3.3);
        near(middle(&layers(|k| -(k as f32), -1.0), whole.clone(), &renderer), 13.3, 3.3);
        // Large from the first point on, and behind a cut between two slices.
        near(middle(&layers(|k| 12.0 - k as f32, 1.0), whole.clone(), &renderer), 10.0, 12.0);
        let cut = Clip { planes: vec![Plane { normal: glam::DVec3::Z, offset: 6.3 }], ..Clip::default() };
        near(middle(&layers(|k| k as f32, 1.0), cut, &renderer), 16.3, 6.3);
        // Vacuum up to the fifth layer.
        let vacuum = layers(|k| if k < 5 { f32::NAN } else { k as f32 }, 1.0);
        near(middle(&vacuum, whole.clone(), &renderer), 15.0, 5.0);
        // Nowhere.
        assert_eq!(middle(&layers(|_| 1.0, 1.0), whole, &renderer), (f32::INFINITY, [0.0; 4]));
    }
}

#[test]
fn another_threshold_is_a_new_preparation() {
    let control = Control::default();
    let scene = |compositing| Scene { compositing, ..phantom_scene::<u8>("fog", 12, 1.0) };
    let (low, high) = (scene(Compositing::First { threshold: 0.4 }), scene(Compositing::First { threshold: 0.6 }));
    let seen = view(&low, 33.0, 21.0, None, 12);
    let steps = [low.clone(), high, scene(Compositing::Over), low.clone(), scene(Compositing::Maximum), low];
    let mut prepared = ShearWarp::default().prepare(&steps[0], &control).unwrap();
    for step in &steps {
        prepared.update(&Scene { volume: steps[0].volume.clone(), ..step.clone() }, &control).unwrap();
        let frame = prepared.render(&seen, &control).unwrap().frame;
        assert_eq!(frame, draw(&ShearWarp::default(), step, &seen).frame, "{:?}", step.compositing);
    }
}
