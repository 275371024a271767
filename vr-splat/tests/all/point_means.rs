//! Weighted means of scattered points, and their colours, against the reference and against the renderer's own model.

use std::sync::Arc;

use glam::DVec3;
use vr_core::Classification;
use vr_core::*;
use vr_physics::Metrics;
use vr_physics::check::pictures::*;
use vr_physics::check::strategies::tame_mixed_point_scene;
use vr_physics::check::{Effort, agrees_with_its_model, agrees_with_reference_on};
use vr_splat::{Buffers, Splatter};

const VIEWS: [(f64, f64, Option<f64>); 2] = [(33.0, 21.0, None), (-60.0, 50.0, Some(35.0))];

/// Points in each other's supports, some alone, with colours or without.
fn cloud(kernel: PointKernel, mixing: PointMixing, colored: bool) -> PointSet {
    let place = |k: u32| DVec3::from([k * 7919 % 97, k * 104_729 % 89, k * 31 % 83].map(f64::from)) / 40.0;
    let positions: Vec<DVec3> = (0..40).map(place).collect();
    let radii = (0..40u8).map(|k| 0.4 + 0.015 * f32::from(k)).collect();
    let weights = (0..40u8).map(|k| 0.5 + 0.1 * f32::from(k % 5)).collect();
    let values = (0..40u8).map(|k| 0.2 + 0.1 * f32::from(k % 9)).collect();
    let points = PointSet::new(positions, radii, weights, values, kernel).unwrap().with_mixing(mixing).unwrap();
    let color = |k: u8| [k % 3, k % 4, k % 5].map(|c| 0.2 + 0.2 * f32::from(c)).map(|c| c.min(1.0));
    if colored { points.with_colors((0..40).map(color).collect()).unwrap() } else { points }
}

fn transfer() -> TransferFunction {
    let points = [(0.0, [0.1, 0.3, 0.9], 0.0), (0.6, [0.9, 0.7, 0.2], 0.2), (2.0, [1.0; 3], 0.6)];
    let points = points.map(|(v, color, a)| ControlPoint::new(v, color, a));
    TransferFunction::new(points.to_vec(), OpacityRule::Extinction, 0.5).unwrap()
}

fn scenes(points: PointSet) -> Vec<(&'static str, Scene)> {
    let plain = Scene { lights: vec![Light::default()], ..Scene::new(points.into(), transfer()) };
    let shaded = |shading: Shading| Scene { shading: Some(shading.into()), ..plain.clone() };
    let factors = vec![(0.05, 0.2), (0.8, 1.4), (2.0, 0.6)];
    vec![
        ("plain", plain.clone()),
        ("shaded", shaded(Shading::default())),
        ("shaded, factors", shaded(Shading { gradient_opacity: factors, ..Shading::default() })),
    ]
}

#[test]
fn pictures_are_what_the_model_sums() {
    for kernel in PointKernel::ALL {
        for (mixing, colored) in [(PointMixing::Mean, false), (PointMixing::Mean, true), (PointMixing::Sum, true)] {
            for (name, scene) in scenes(cloud(kernel, mixing, colored)) {
                for slice_spacing in [1.0, 0.3] {
                    let renderer = Splatter { slice_spacing, termination: 1.0, ..Splatter::default() };
                    for (azimuth, elevation, fov) in VIEWS {
                        let view = view(&scene, azimuth, elevation, fov, 12);
                        let m = error_of_model(&renderer, &scene, &view);
                        println!("{kernel}, {mixing}, {colored}, {name}, {slice_spacing}: {m}");
                        // Tables of kernels, and rounding of sums and of quotients.
                        assert!(m.rmse < 4e-5 && m.max < 1e-3, "{kernel}, {mixing}, {colored}, {name}: {m}");
                    }
                }
            }
        }
    }
}

/// Beside the middle of a point, where the kernel of another one has only begun: its gradient is all that the light reflects by.
#[test]
fn the_faintest_neighbour_turns_the_gradient() {
    for kernel in PointKernel::ALL {
        for begun in [1e-1, 3e-2, 1e-2, 3e-3] {
            let positions = vec![DVec3::ZERO, DVec3::new(0.6, -0.48, 0.64) * (1.0 - begun)];
            let points = PointSet::new(positions, vec![1.0; 2], vec![1.0; 2], vec![0.9, 0.4], kernel).unwrap();
            for (name, scene) in scenes(points.with_mixing(PointMixing::Mean).unwrap()) {
                for (azimuth, elevation, fov) in VIEWS {
                    let mut view = view(&scene, azimuth, elevation, fov, 12);
                    // Rays that pass the first point's middle within a twentieth of its radius.
                    let aside = view.camera.target;
                    (view.camera.eye, view.camera.target) = (view.camera.eye - aside, DVec3::ZERO);
                    view.camera.projection = match view.camera.projection {
                        Projection::Orthographic { .. } => Projection::Orthographic { height: 0.1 },
                        Projection::Perspective { .. } => Projection::Perspective { fov: 1.5 },
                    };
                    let renderer = Splatter { slice_spacing: 0.3, termination: 1.0, ..Splatter::default() };
                    let m = error_of_model(&renderer, &scene, &view);
                    println!("{kernel}, {name}, {begun}: {m}");
                    assert!(m.rmse < 4e-5 && m.max < 1e-3, "{kernel}, {name}, {begun}: {m}");
                }
            }
        }
    }
}

#[test]
fn thin_sheets_come_to_the_reference() {
    for (mixing, colored) in [(PointMixing::Mean, false), (PointMixing::Mean, true), (PointMixing::Sum, true)] {
        for (name, scene) in scenes(cloud(PointKernel::CubicSpline, mixing, colored)) {
            let view = view(&scene, 33.0, 21.0, None, 12);
            let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
            let of = |slice_spacing| {
                let renderer = Splatter { slice_spacing, termination: 1.0, ..Splatter::default() };
                Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels()).rmse
            };
            let errors = [1.0, 0.25, 0.0625].map(of);
            println!("{mixing}, {colored}, {name}: {errors:?}");
            // Order 1: means begin and end with jumps, and their gradients where one point reaches alone. At the rims of supports, where all kernels are below
            // what f32 keeps of a chord, thinner sheets know their means no better.
            assert!(errors[2] < errors[0] / 3.0 && errors[2] < 3e-3, "{mixing}, {colored}, {name}: {errors:?}");
        }
    }
}

#[test]
fn equal_values_are_a_homogeneous_body() {
    // All supports together, in sheets of any thickness: no point is brighter than another, and none reflects.
    let points = cloud(PointKernel::CubicSpline, PointMixing::Sum, false);
    let (positions, radii, weights) = (points.positions().to_vec(), points.radii().to_vec(), points.weights().to_vec());
    let equal = PointSet::new(positions, radii, weights, vec![0.6; 40], PointKernel::CubicSpline).unwrap();
    let equal = equal.with_mixing(PointMixing::Mean).unwrap().with_colors(vec![[0.5, 1.0, 0.25]; 40]).unwrap();
    let plain = Scene::new(equal.into(), transfer());
    let shaded = Scene { shading: Some(Arc::new(Shading::default())), lights: vec![Light::default()], ..plain.clone() };
    let view = view(&plain, 33.0, 21.0, None, 24);
    let renderer = Splatter { termination: 1.0, ..Splatter::default() };
    let [plain, shaded] = [&plain, &shaded].map(|scene| draw(&renderer, scene, &view).frame);
    let color = transfer().at(0.6).color;
    for (a, b) in plain.pixels().iter().zip(shaded.pixels()) {
        assert_eq!(a, b, "there is no gradient");
        for (c, tint) in [0.5, 1.0, 0.25].into_iter().enumerate() {
            let wanted = color[c] * tint * f64::from(a[3]);
            assert!((f64::from(a[c]) - wanted).abs() < 1e-5, "{a:?}");
        }
    }
}

#[test]
fn values_are_picked_of_means_but_not_of_colours() {
    let points = cloud(PointKernel::CubicSpline, PointMixing::Mean, false);
    for compositing in [Compositing::Maximum, Compositing::Average, Compositing::First { threshold: 0.6 }] {
        let scene = Scene { compositing, ..Scene::new(points.clone().into(), transfer()) };
        let renderer = Splatter { slice_spacing: 0.05, termination: 1.0, ..Splatter::default() };
        let m = error(&renderer, &scene, &view(&scene, 33.0, 21.0, None, 16));
        println!("{}: {m}", compositing.name());
        assert!(m.rmse < 2e-2, "{}: {m}", compositing.name());
    }
    let colored = cloud(PointKernel::CubicSpline, PointMixing::Sum, true);
    let plain = Scene::new(colored.into(), transfer());
    let picked = Scene { compositing: Compositing::Maximum, ..plain.clone() };
    let refused = |renderer: &Splatter, scene: &Scene| match renderer.supports(scene, None) {
        Err(RenderError::Unsupported(unsupported)) => Some(unsupported.feature),
        other => other.map(|()| None).unwrap(),
    };
    assert_eq!(refused(&Splatter::default(), &plain), None);
    assert_eq!(refused(&Splatter::default(), &picked), Some(Feature::Compositing));
    for renderer in [
        Splatter { classification: Classification::Pre, ..Splatter::default() },
        Splatter { buffers: Buffers::Samples, ..Splatter::default() },
    ] {
        assert_eq!(refused(&renderer, &plain), Some(Feature::Setting));
        assert_eq!(refused(&renderer, &Scene::new(points.clone().into(), transfer())), Some(Feature::Setting));
    }
}

#[test]
fn random_clouds_are_what_the_model_sums() {
    let bound = |scene: &Scene, _: &View| if scene.compositing == Compositing::Over { 1e-4 } else { f64::INFINITY };
    let report = agrees_with_its_model(&Splatter::default(), tame_mixed_point_scene(), bound, &Effort::cases(160));
    let report = report.unwrap_or_else(|e| panic!("{e}"));
    println!("{report}");
    assert!(report.held > 40, "{report}");
}

#[test]
fn random_clouds_in_thin_sheets_come_to_the_reference() {
    let renderer = Splatter { slice_spacing: 0.03, termination: 1.0, ..Splatter::default() };
    let report = agrees_with_reference_on(&renderer, tame_mixed_point_scene(), |_, _| 5e-2, &Effort::cases(64));
    let report = report.unwrap_or_else(|e| panic!("{e}"));
    println!("{report}");
    assert!(report.held > 20, "{report}");
}
