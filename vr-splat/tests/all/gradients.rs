//! Shading and opacity by the gradient, against the canonical pixel.

use glam::DVec3;
use vr_core::*;
use vr_physics::Metrics;
use vr_physics::check::pictures::*;
use vr_splat::{Buffers, Splatter};

/// A smooth field of values from 0 to 1 in a box of 12 units, under extinction that is linear in the value.
fn scene(n: usize, shading: Shading, emission: Option<[f64; 3]>) -> Scene {
    let spacing = 12.0 / (n - 1) as f64;
    let value = |i: usize| {
        let [x, y, z] = [i % n, i / n % n, i / (n * n)].map(|x| x as f64 * spacing);
        (0.5 + 0.2 * libm::sin(0.6 * x) + 0.15 * libm::cos(0.5 * y + 0.4) + 0.1 * libm::sin(0.4 * z - 1.0)) as f32
    };
    let samples: Vec<f32> = (0..n * n * n).map(value).collect();
    let placement = Placement::from_spacing([spacing; 3]).unwrap();
    let grid: UniformGrid<f32> = UniformGrid::new([n; 3], samples, placement, Calibration::default()).unwrap();
    let points = [0.0, 1.0].map(|v| ControlPoint { emission, ..ControlPoint::new(v, [1.0, 0.6, 0.3], v) });
    let transfer = TransferFunction::new(points.to_vec(), OpacityRule::Extinction, 5.0).unwrap();
    let lights = vec![Light::default(), Light { direction: Some(DVec3::new(1.0, 2.0, -0.5)), color: [0.3, 0.5, 0.9] }];
    Scene { shading: Some(shading.into()), lights, ..Scene::new(grid.into(), transfer) }
}

/// Factors that rise with the gradient, and fall again.
fn factors() -> Vec<(f64, f64)> {
    vec![(0.02, 0.2), (0.12, 1.5), (0.2, 0.8)]
}

fn shadings() -> Vec<(&'static str, Shading, Option<[f64; 3]>)> {
    let following = Shading { gradient_opacity: factors(), ..Shading::default() };
    let glow = Some([0.05, 0.1, 0.15]);
    let analytic = Shading { gradient: GradientMethod::Analytic, ..Shading::default() };
    vec![
        ("shaded", Shading::default(), None),
        ("factors", Shading { gradient_opacity: factors(), ..Shading::flat() }, None),
        ("shaded, factors", following.clone(), None),
        ("emission, factors", following, glow),
        ("analytic", analytic, None),
    ]
}

const VIEWS: [(f64, f64, Option<f64>); 2] = [(33.0, 21.0, None), (-60.0, 50.0, Some(35.0))];

#[test]
fn values_in_image_sheets_come_to_the_canonical_pixel() {
    for (name, shading, emission) in shadings() {
        let scene = scene(13, shading, emission);
        for (azimuth, elevation, fov) in VIEWS {
            let view = view(&scene, azimuth, elevation, fov, 16);
            let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
            let errors = [1.0, 0.25].map(|slice_spacing| {
                let renderer = Splatter { slice_spacing, termination: 1.0, ..Splatter::default() };
                Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels()).rmse
            });
            println!("{name} {azimuth}: {:.1e}, {:.1e}", errors[0], errors[1]);
            // The square of a quarter is a sixteenth, and a gradient that jumps at faces of cells leaves the order 1 and a part of the half.
            let least = if name == "analytic" { 3.0 } else { 8.0 };
            assert!(errors[0] < 1e-2 && errors[1] < errors[0] / least, "{name} {azimuth}: {errors:?}");
        }
    }
}

#[test]
fn voxels_classified_before_come_to_the_canonical_pixel_as_they_become_small() {
    for (name, shading, emission) in shadings().into_iter().filter(|s| s.0 != "analytic") {
        for (azimuth, elevation, fov) in VIEWS {
            let errors = [13, 25].map(|n| {
                let scene = scene(n, shading.clone(), emission);
                // Away from the faces, beyond which kernels spread.
                let (low, high) = scene.volume.bounds();
                let crop = Some((low + DVec3::splat(1.5), high - DVec3::splat(1.5)));
                let whole = view(&scene, azimuth, elevation, fov, 12);
                let view = View { clip: Clip { crop, planes: Vec::new() }, ..whole };
                let renderer = |buffers| Splatter {
                    buffers,
                    classification: Classification::Pre,
                    slice_spacing: if buffers == Buffers::Image { 0.25 } else { 1.0 },
                    termination: 1.0,
                    ..Splatter::default()
                };
                let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
                [Buffers::Image, Buffers::Axis]
                    .map(|buffers| Metrics::of(&truth, draw(&renderer(buffers), &scene, &view).frame.pixels()).rmse)
            });
            println!(
                "{name} {azimuth}: {:.1e}, {:.1e}; own sheets {:.1e}, {:.1e}",
                errors[0][0], errors[1][0], errors[0][1], errors[1][1]
            );
            // Light of voxels is interpolated: off by the square of their distance, where no factor has a knot.
            assert!(errors[0][0] < 2e-2 && errors[1][0] < errors[0][0] / 2.5, "{name} {azimuth}: {errors:?}");
            assert!(errors[1][1] < errors[0][1] / 1.5, "{name} {azimuth}: {errors:?}");
        }
    }
}
