//! Scattered points against the reference and against the renderer's own model.

use crate::point_settings::renderers;
use glam::DVec3;
use vr_core::Classification;
use vr_core::phantom::{point_transfer_function, points_by_name};
use vr_core::*;
use vr_physics::Metrics;
use vr_physics::check::pictures::{self, *};
use vr_splat::{Buffers, Splatter};

fn cloud(name: &str, count: usize) -> Scene {
    let (points, unit) = point_transfer_function(name).expect("a known phantom");
    let transfer = TransferFunction::new(points, OpacityRule::Power, unit).expect("valid points");
    Scene::new(points_by_name(name, count).expect("a known phantom").into(), transfer)
}

fn some(points: &[([f64; 3], f32, f32)], kernel: PointKernel) -> Volume {
    let positions = points.iter().map(|p| DVec3::from(p.0)).collect();
    let radii = points.iter().map(|p| p.1).collect();
    let values = points.iter().map(|p| p.2).collect();
    PointSet::new(positions, radii, vec![1.0; points.len()], values, kernel).unwrap().into()
}

/// Extinction and emission that are the field.
fn linear(volume: Volume, max: f64, unit: f64) -> Scene {
    let points = [0.0, max].map(|v| ControlPoint::new(v, [0.9, 0.6, 0.3], v / max)).to_vec();
    Scene::new(volume, TransferFunction::new(points, OpacityRule::Extinction, unit).unwrap())
}

#[test]
fn pictures_are_what_the_model_sums() {
    let mut scenes = vec![("plummer", cloud("plummer", 400)), ("turbulence", cloud("turbulence", 500))];
    for kernel in PointKernel::ALL {
        let four =
            [([0.0; 3], 1.0, 1.0), ([0.0; 3], 1.0, 2.0), ([0.3, 0.4, -0.2], 0.25, 0.1), ([-4.0, 1.0, 0.5], 2.0, 9.0)];
        scenes.push(("four", linear(some(&four, kernel), 4.0, 1.0)));
    }
    for (name, scene) in scenes {
        for renderer in renderers() {
            for (azimuth, elevation, fov) in [(0.0, 0.0, None), (33.0, 21.0, None), (-60.0, 50.0, Some(35.0))] {
                let view = view(&scene, azimuth, elevation, fov, 20);
                let m = error_of_model(&renderer, &scene, &view);
                println!("{name:<12} {:?} {:?} {azimuth}: {m}", renderer.buffers, renderer.classification);
                // Tables of kernels and of the transfer function, and rounding in f32 of sums of many.
                assert!(m.max < 1e-4, "{name} {renderer:?} {azimuth}: {m}");
            }
        }
    }
}

#[test]
fn kernels_smaller_than_pixels_are_what_the_model_sums() {
    let scene = cloud("plummer", 3000);
    let (low, high) = scene.volume.bounds();
    let Volume::Points(points) = &scene.volume else { unreachable!("it is of points") };
    for (elevation, fov) in [(21.0, None), (50.0, Some(35.0))] {
        let view = view(&scene, 33.0, elevation, fov, 20);
        // A pixel is at least so large: most kernels have a rectangle of three pixels across at the most, and are drawn ray by ray.
        let pixel = (high - low).min_element() / 20.0;
        let small = points.radii().iter().filter(|&&radius| f64::from(radius) < pixel).count();
        assert!(small > 2000, "{small} kernels");
        let m = error_of_model(&Splatter { termination: 1.0, ..Splatter::default() }, &scene, &view);
        println!("{fov:?}: {m}, {small} of 3000 kernels are small");
        // Tables of kernels and of the transfer function, and rounding in f32 of sums of many.
        assert!(m.max < 1e-4, "{fov:?}: {m}");
    }
}

#[test]
fn thin_sheets_of_values_come_to_the_reference() {
    for scene in [cloud("plummer", 300), cloud("turbulence", 300)] {
        for (azimuth, elevation, fov) in [(33.0, 21.0, None), (-60.0, 50.0, Some(35.0))] {
            let view = view(&scene, azimuth, elevation, fov, 16);
            let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
            let of = |slice_spacing| {
                let renderer = Splatter { slice_spacing, termination: 1.0, ..Splatter::default() };
                Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels()).rmse
            };
            let errors = [1.0, 0.5, 0.25, 0.125].map(of);
            println!("{azimuth}: {errors:.1?}");
            // Order 2, but where supports end within a sheet: at 1 there.
            assert!(errors[3] < errors[0] / 6.0 && errors[3] < 2e-3, "{errors:?}");
        }
    }
}

#[test]
fn one_point_and_many_at_one_place() {
    let control = Control::default();
    for kernel in PointKernel::ALL {
        let one = linear(some(&[([1.0, 2.0, 3.0], 0.7, 8.0)], kernel), 10.0, 1.0);
        let split = [([1.0, 2.0, 3.0], 0.7, 2.0); 4];
        let four = linear(some(&split, kernel), 10.0, 1.0);
        let view = view(&one, 10.0, 20.0, None, 33);
        let renderer = Splatter { slice_spacing: 0.05, termination: 1.0, ..Splatter::default() };
        let [a, b] = [&one, &four].map(|scene| draw(&renderer, scene, &view).frame);
        for (a, b) in a.pixels().iter().zip(b.pixels()) {
            assert!((0..4).all(|c| (a[c] - b[c]).abs() < 1e-6), "{kernel}");
        }
        let m = error(&renderer, &one, &view);
        println!("{kernel}: {m}");
        assert!(m.max < 2e-4, "{kernel}: {m}");
        // Far from the world's origin it is the same picture.
        let far = linear(some(&[([1e6 + 1.0, 2.0 - 1e6, 3.0], 0.7, 8.0)], kernel), 10.0, 1.0);
        let moved = draw(&renderer, &far, &pictures::view(&far, 10.0, 20.0, None, 33)).frame;
        for (a, b) in a.pixels().iter().zip(moved.pixels()) {
            assert!((0..4).all(|c| (a[c] - b[c]).abs() < 1e-5), "{kernel}");
        }
    }
    // A point that carries nothing shows nothing.
    let none = linear(some(&[([0.0; 3], 1.0, 0.0)], PointKernel::Cone), 1.0, 1.0);
    let blank = Splatter::default().prepare(&none, &control).unwrap().render(&view(&none, 0.0, 0.0, None, 8), &control);
    assert!(blank.unwrap().frame.pixels().iter().all(|p| *p == [0.0; 4]));
}

#[test]
fn an_eye_among_points_sees_what_is_ahead() {
    let scene = cloud("turbulence", 400);
    let camera = Camera {
        eye: DVec3::new(0.1, -0.05, 0.2),
        target: DVec3::new(0.3, 0.1, -0.4),
        up: DVec3::Y,
        projection: Projection::Perspective { fov: 80.0 },
    };
    let view = View::new(camera, [16, 16]);
    let renderer = Splatter { slice_spacing: 0.1, termination: 1.0, ..Splatter::default() };
    let m = error(&renderer, &scene, &view);
    println!("{m}");
    assert!(m.rmse < 2e-3, "{m}");
    let exact = error_of_model(&renderer, &scene, &view);
    assert!(exact.max < 2e-4, "{exact}");
}

#[test]
fn values_are_picked_as_by_the_reference() {
    let scene = cloud("turbulence", 300);
    for compositing in [Compositing::Maximum, Compositing::Average, Compositing::Accumulate { level: 0.2 }] {
        let scene = Scene { compositing, ..scene.clone() };
        let renderer = Splatter { slice_spacing: 0.05, termination: 1.0, ..Splatter::default() };
        let view = view(&scene, 33.0, 21.0, None, 16);
        let m = error(&renderer, &scene, &view);
        println!("{}: {m}", compositing.name());
        assert!(m.rmse < 1e-2, "{}: {m}", compositing.name());
    }
}

#[test]
fn threads_make_no_difference() {
    let scene = cloud("plummer", 3000);
    let view = view(&scene, 33.0, 21.0, Some(40.0), 70);
    let on = |threads: usize| {
        let control = Control::default().with_threads(threads);
        Splatter::default().prepare(&scene, &control).unwrap().render(&view, &control).unwrap().frame
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn total_emission_is_what_points_carry() {
    // Gas that glows by its density: all of it is seen, from anywhere.
    let points = points_by_name("plummer", 500).unwrap();
    let total: f64 = points.weights().iter().zip(points.values()).map(|(&w, &v)| f64::from(w) * f64::from(v)).sum();
    let glow = |v: f64| ControlPoint { emission: Some([v, 0.0, 0.0]), ..ControlPoint::new(v, [0.0; 3], 0.0) };
    let max = 10.0 * points.count() as f64;
    let transfer = TransferFunction::new(vec![glow(0.0), glow(max)], OpacityRule::Extinction, 1.0).unwrap();
    let scene = Scene::new(points.into(), transfer);
    for (azimuth, elevation) in [(0.0, 0.0), (33.0, 21.0), (-100.0, 70.0)] {
        let view = view(&scene, azimuth, elevation, None, 300);
        let Projection::Orthographic { height } = view.camera.projection else { unreachable!("no fov") };
        let renderer = Splatter { low_pass: 3.0, termination: 1.0, ..Splatter::default() };
        let frame = draw(&renderer, &scene, &view).frame;
        let seen = frame.pixels().iter().map(|p| f64::from(p[0])).sum::<f64>() * (height / 300.0) * (height / 300.0);
        println!("{azimuth}: {seen} for {total}");
        // No point is narrower than three pixels to its edge: what their centres miss is next to nothing.
        assert!((seen / total - 1.0).abs() < 1e-4, "{azimuth}: {seen} for {total}");
    }
}

#[test]
fn random_clouds_are_what_the_model_sums() {
    use proptest::strategy::Strategy;
    use vr_physics::check::strategies::{shaded_point_scene, tame_point_scene};
    use vr_physics::check::{Effort, agrees_with_its_model};
    for renderer in [
        Splatter::default(),
        Splatter { classification: Classification::Pre, ..Splatter::default() },
        Splatter { buffers: Buffers::Samples, ..Splatter::default() },
    ] {
        // Early termination leaves 10⁻⁴, and a table of the transfer function what bends within an entry. Of values that are picked there is no model.
        let bound = |scene: &Scene, _: &View| {
            if scene.compositing == Compositing::Over { 5e-4 } else { f64::INFINITY }
        };
        let report = agrees_with_its_model(&renderer, tame_point_scene(), bound, &Effort::cases(48));
        let report = report.unwrap_or_else(|e| panic!("{renderer:?}: {e}"));
        println!("held {}, refused {}, worst {:.1e}", report.held, report.refused, report.worst);
        // The same with shading, and every other scene with opacity by the gradient.
        let following = shaded_point_scene().prop_map(|mut test| {
            let points = test.scene.volume.points().unwrap();
            if points.count() % 2 == 0 {
                let (low, high) = points.value_range();
                let steep = (high - low).abs().max(high.abs()) / points.mean_spacing();
                let shading = test.scene.shading.as_deref().unwrap();
                let gradient_opacity = vec![(0.1 * steep, 0.2), (steep, 1.5), (3.0 * steep, 0.7)];
                test.scene.shading = Some(Shading { gradient_opacity, ..shading.clone() }.into());
            }
            test
        });
        // Gradients of points that cancel, or vanish at the edge of a spline's support, have a direction of rounding: 5·10⁻³ at worst.
        let bound = |_: &Scene, _: &View| 8e-3;
        let report = agrees_with_its_model(&renderer, following, bound, &Effort::cases(48));
        let report = report.unwrap_or_else(|e| panic!("shaded, {renderer:?}: {e}"));
        println!("shaded: held {}, refused {}, worst {:.1e}", report.held, report.refused, report.worst);
        assert_eq!(report.refused, 0, "{renderer:?}");
    }
}

#[test]
fn a_low_pass_loses_nothing_of_the_nearest_point() {
    // A tenth of a pixel wide, and all there is: widened, it begins far before its own support.
    let points = some(&[([0.0; 3], 0.1, 3.0)], PointKernel::CubicSpline);
    let glow = |v: f64| ControlPoint { emission: Some([v, 0.0, 0.0]), ..ControlPoint::new(v, [0.0; 3], 0.0) };
    let transfer = TransferFunction::new(vec![glow(0.0), glow(1e3)], OpacityRule::Extinction, 1.0).unwrap();
    let scene = Scene::new(points, transfer);
    let projection = Projection::Orthographic { height: 24.0 };
    let camera =
        Camera { eye: DVec3::new(0.3, 0.2, 50.0), target: DVec3::new(0.3, 0.2, 0.0), up: DVec3::Y, projection };
    let renderer = Splatter { low_pass: 4.0, termination: 1.0, ..Splatter::default() };
    let frame = draw(&renderer, &scene, &View::new(camera, [24, 24])).frame;
    let seen: f64 = frame.pixels().iter().map(|p| f64::from(p[0])).sum();
    // Four pixels to the edge: what their centres miss is a few thousandths.
    assert!((seen / 3.0 - 1.0).abs() < 1e-2, "{seen}");
}
