//! Shading of scattered points, and opacity by the gradient of their sum, against the reference and against the renderer's own model.

use std::sync::Arc;

use crate::point_settings::renderers;
use glam::DVec3;
use vr_core::Classification;
use vr_core::*;
use vr_physics::Metrics;
use vr_physics::check::pictures::*;
use vr_splat::Splatter;

const VIEWS: [(f64, f64, Option<f64>); 2] = [(33.0, 21.0, None), (-60.0, 50.0, Some(35.0))];

/// Three points in each other's supports.
fn three(kernel: PointKernel) -> Volume {
    let positions = vec![DVec3::ZERO, DVec3::new(0.8, 0.2, -0.1), DVec3::new(-0.3, 0.9, 0.4)];
    PointSet::new(positions, vec![1.0; 3], vec![1.0; 3], vec![1.0, 0.7, 0.4], kernel).unwrap().into()
}

/// Lattice of 7³ points with a smooth value, all of whose kernels together are a smooth field.
fn smooth() -> Volume {
    let place = |i: usize| DVec3::from([i % 7, i / 7 % 7, i / 49].map(|x| x as f64 - 3.0));
    let positions: Vec<DVec3> = (0..343).map(place).collect();
    let value = |p: &DVec3| (0.5 + 0.2 * libm::sin(0.6 * p.x + 0.3) + 0.2 * libm::cos(0.5 * p.y - 0.2 * p.z)) as f32;
    let values = positions.iter().map(value).collect();
    PointSet::new(positions, vec![2.0; 343], vec![1.0; 343], values, PointKernel::CubicSpline).unwrap().into()
}

fn lights() -> Vec<Light> {
    vec![Light::default(), Light { direction: Some(DVec3::new(1.0, 2.0, -0.5)), color: [0.3, 0.5, 0.9] }]
}

fn ramp(emission: Option<[f64; 3]>) -> Vec<ControlPoint> {
    let points = [(0.0, [0.1, 0.3, 0.9], 0.0), (0.6, [0.9, 0.7, 0.2], 0.2), (2.0, [1.0; 3], 0.6)];
    points.map(|(v, color, a)| ControlPoint { emission, ..ControlPoint::new(v, color, a) }).to_vec()
}

/// Scenes whose light depends on the gradient in each way.
fn looks(volume: &Volume) -> Vec<(&'static str, Scene)> {
    let transfer = |emission| TransferFunction::new(ramp(emission), OpacityRule::Extinction, 0.5).unwrap();
    let plain = Scene { lights: lights(), ..Scene::new(volume.clone(), transfer(None)) };
    let factors = vec![(0.05, 0.2), (0.8, 1.4), (2.0, 0.6)];
    let shaded = |shading: Shading| Scene { shading: Some(shading.into()), ..plain.clone() };
    let following = Shading { gradient_opacity: factors.clone(), ..Shading::default() };
    let faint: Vec<ControlPoint> =
        ramp(None).iter().map(|p| ControlPoint { opacity: 0.1 * p.opacity, color: [0.2, 0.9, 0.4], ..*p }).collect();
    let rows = TransferFunction::of_rows(vec![(0.1, faint), (1.0, ramp(None))], OpacityRule::Extinction, 0.5).unwrap();
    let glowing: Arc<TransferFunction> = transfer(Some([0.05, 0.1, 0.15])).into();
    vec![
        ("shaded", shaded(Shading::default())),
        ("factors", shaded(Shading { gradient_opacity: factors, ..Shading::flat() })),
        ("shaded, factors", shaded(following.clone())),
        ("emission, factors", Scene { transfer: glowing, ..shaded(following) }),
        ("rows", Scene { transfer: rows.clone().into(), ..plain.clone() }),
        ("shaded rows", Scene { transfer: rows.into(), ..shaded(Shading::default()) }),
    ]
}

#[test]
fn thin_sheets_come_to_the_reference() {
    for kernel in PointKernel::ALL {
        for (name, scene) in looks(&three(kernel)) {
            for (azimuth, elevation, fov) in VIEWS {
                let view = view(&scene, azimuth, elevation, fov, 12);
                let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
                let of = |slice_spacing| {
                    let renderer = Splatter { slice_spacing, termination: 1.0, ..Splatter::default() };
                    Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels()).rmse
                };
                let errors = [0.4, 0.1, 0.025].map(of);
                println!("{kernel}, {name}, {azimuth}: {errors:?}");
                // Order 2, and 1 where supports end within a sheet or a cone has its tip: a sixteenth of the distance, an eighth of the error at least.
                assert!(errors[2] < 1e-4 && errors[2] < errors[0] / 8.0, "{kernel}, {name}: {errors:?}");
            }
        }
    }
}

#[test]
fn pictures_are_what_the_model_sums() {
    for kernel in PointKernel::ALL {
        for (name, scene) in looks(&three(kernel)) {
            for renderer in renderers() {
                for (azimuth, elevation, fov) in VIEWS {
                    let view = view(&scene, azimuth, elevation, fov, 12);
                    let m = error_of_model(&renderer, &scene, &view);
                    println!("{kernel}, {name}, {:?} {:?}: {m}", renderer.buffers, renderer.classification);
                    // Tables and rounding; normals turn fast where gradients are small, and a row's extinction is steep in the magnitude.
                    assert!(m.max < 3e-4, "{kernel}, {name}, {renderer:?}: {m}");
                }
            }
        }
    }
}

#[test]
fn points_classified_before_are_near_the_reference_of_a_smooth_field() {
    for (name, scene) in looks(&smooth()) {
        let (low, high) = scene.volume.bounds();
        // Away from the lattice's faces, beyond which the field falls to 0.
        let crop = Some((low + DVec3::splat(3.5), high - DVec3::splat(3.5)));
        let view = View { clip: Clip { crop, planes: Vec::new() }, ..view(&scene, 33.0, 21.0, None, 12) };
        let renderer = Splatter {
            classification: Classification::Pre,
            slice_spacing: 0.25,
            termination: 1.0,
            ..Splatter::default()
        };
        let unlit = Scene { shading: None, ..scene.clone() };
        let m = [error(&renderer, &scene, &view), error(&renderer, &unlit, &view)];
        println!("{name}: {} (unlit {})", m[0], m[1]);
        // Light of points is a mean over their kernels, two points wide: off by the square of that, shaded or not.
        assert!(m[0].rmse < 1.2e-2, "{name}: {}", m[0]);
    }
}

#[test]
fn a_first_hit_is_shaded_by_the_sum_of_gradients() {
    let (_, shaded) = looks(&three(PointKernel::CubicSpline)).swap_remove(0);
    let scene = Scene { compositing: Compositing::First { threshold: 0.5 }, ..shaded };
    for (azimuth, elevation, fov) in VIEWS {
        let view = view(&scene, azimuth, elevation, fov, 24);
        let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
        let of = |slice_spacing| {
            let renderer = Splatter { slice_spacing, ..Splatter::default() };
            Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels()).rmse
        };
        let errors = [0.4, 0.1, 0.025].map(of);
        println!("{azimuth}: {errors:?}");
        assert!(errors[2] < 2e-3 && errors[2] < errors[0] / 8.0, "{errors:?}");
        let plain = draw(&Splatter::default(), &Scene { shading: None, ..scene.clone() }, &view).frame;
        let lit = draw(&Splatter::default(), &scene, &view).frame;
        assert_ne!(plain, lit);
    }
}

#[test]
fn an_update_finds_the_gradients_that_it_needs() {
    let volume = three(PointKernel::Gaussian);
    let all = looks(&volume);
    let plain = Scene { shading: None, ..all[0].1.clone() };
    let control = Control::default();
    let view = view(&plain, 33.0, 21.0, None, 12);
    for renderer in renderers() {
        let mut prepared = renderer.prepare(&plain, &control).unwrap();
        for (name, scene) in &all {
            prepared.update(scene, &control).unwrap();
            let updated = prepared.render(&view, &control).unwrap().frame;
            assert_eq!(updated, draw(&renderer, scene, &view).frame, "{name}, {renderer:?}");
        }
    }
}

#[test]
fn size_and_place_of_the_world_make_no_difference() {
    for (name, scene) in looks(&three(PointKernel::CubicSpline)) {
        // Factors and rows are by value per world unit: only shading alone is free of scale.
        let scales: &[f64] = if name == "shaded" { &[1e-6, 1.0, 1e6] } else { &[1.0] };
        let points = scene.volume.points().unwrap();
        let own = view(&scene, 33.0, 21.0, None, 12);
        let wanted = draw(&Splatter::default(), &scene, &own).frame;
        for &scale in scales {
            let positions = points.positions().iter().map(|&p| p * scale + DVec3::splat(1e3 * scale)).collect();
            let radii = points.radii().iter().map(|&r| (f64::from(r) * scale) as f32).collect();
            let weights = points.weights().iter().map(|&w| (f64::from(w) * scale * scale * scale) as f32).collect();
            let moved = PointSet::new(positions, radii, weights, points.values().to_vec(), points.kernel()).unwrap();
            let transfer = &scene.transfer;
            let transfer = if transfer.has_rows() {
                TransferFunction::clone(transfer)
            } else {
                let unit = transfer.unit_distance() * scale;
                TransferFunction::new(transfer.points().to_vec(), transfer.rule(), unit).unwrap()
            };
            let moved = Scene { volume: moved.into(), transfer: transfer.into(), ..scene.clone() };
            let frame = draw(&Splatter::default(), &moved, &view(&moved, 33.0, 21.0, None, 12)).frame;
            let off = frame.pixels().iter().flatten().zip(wanted.pixels().iter().flatten());
            let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            // Places in f32 a thousand radii from the origin would be off by 10⁻⁴ radii: they are not.
            assert!(off < 3e-5, "{name} {scale}: {off}");
        }
    }
}
