//! Values that are picked, against the canonical pixel.

use glam::DVec3;
use vr_core::Classification;
use vr_core::*;
use vr_physics::check::FixedLayer;
use vr_physics::check::pictures::*;
use vr_splat::{Buffers, Shape, SplatKernel, Splatter};

const VIEWS: [(f64, f64, Option<f64>); 3] = [(33.0, 21.0, None), (-60.0, 50.0, Some(35.0)), (140.0, -30.0, Some(80.0))];

fn random_samples(count: usize, mut seed: u64) -> Vec<f32> {
    let mut next = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f32 / (1 << 24) as f32
    };
    (0..count).map(|_| next()).collect()
}

/// Values from 0 to 1 as grey and opacity.
fn scene(volume: impl Into<Volume>, compositing: Compositing) -> Scene {
    let points = [0.0, 1.0].map(|v| ControlPoint::new(v, [1.0, 0.5, 1.0 - v], v)).to_vec();
    let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
    Scene { compositing, ..Scene::new(volume.into(), transfer) }
}

fn grid(dims: [usize; 3], samples: Vec<f32>, calibration: Calibration) -> UniformGrid<f32> {
    UniformGrid::new(dims, samples, Placement::from_spacing([0.7, 1.0, 1.3]).unwrap(), calibration).unwrap()
}

#[test]
fn the_mean_of_a_constant_is_the_constant() {
    let constant = scene(grid([5; 3], vec![0.4; 125], Calibration::default()), Compositing::Average);
    for shape in Shape::ALL {
        let renderer = Splatter { kernel: SplatKernel::new(shape), ..Splatter::default() };
        for (azimuth, elevation, fov) in VIEWS {
            // Many pixels, so that some have the shortest of chords.
            let m = error(&renderer, &constant, &view(&constant, azimuth, elevation, fov, 60));
            assert!(m.max < 1e-6, "{shape:?} {azimuth}: {m}");
        }
    }
}

#[test]
fn a_mean_is_over_what_there_is_of_the_chord() {
    for calibration in [Calibration::default(), Calibration { slope: -1.0, intercept: 1.0 }] {
        let noise = scene(grid([9, 8, 7], random_samples(504, 3), calibration), Compositing::Average);
        let (low, high) = noise.volume.bounds();
        for (azimuth, elevation, fov) in VIEWS {
            let whole = view(&noise, azimuth, elevation, fov, 32);
            let middle = (whole.camera.eye - whole.camera.target).length();
            // A wall askew through the middle, and a corner cut off.
            let depth = |i: u32| ([0.1, 0.2, 0.3], (middle + 0.2 * f64::from(i % 32) - 3.1) as f32);
            let walled = FixedLayer::new(&whole, depth).among(&noise);
            let crop = Some((low + DVec3::splat(0.7), high - DVec3::splat(1.1)));
            let plane = Plane { normal: DVec3::new(1.0, 0.3, -0.2), offset: 2.0 };
            let cut = View { clip: Clip { crop, planes: vec![plane] }, ..whole.clone() };
            for (scene, view) in [(&noise, &whole), (&walled, &whole), (&noise, &cut)] {
                // No sheets are needed, and nothing but f32 is left of chords of any length.
                let m = error(&Splatter::default(), scene, view);
                assert!(m.max < 2e-5, "{azimuth}: {m}");
            }
        }
    }
}

#[test]
fn light_has_no_values_to_pick() {
    let mean = scene(grid([3; 3], vec![0.4; 27], Calibration::default()), Compositing::Average);
    let voxels = Splatter { classification: Classification::Pre, ..Splatter::default() };
    for renderer in [Splatter { buffers: Buffers::Axis, ..voxels.clone() }, voxels] {
        match renderer.prepare(&mean, &Control::default()) {
            Err(RenderError::Unsupported(Unsupported { what: feature, .. })) => {
                assert!(feature.contains("average") && feature.contains("light"), "{feature}")
            }
            other => panic!("{renderer:?}: {:?}", other.map(|_| "prepared")),
        }
    }
}

#[test]
fn means_are_the_same_in_every_buffer() {
    let noise = scene(grid([9, 8, 7], random_samples(504, 3), Calibration::default()), Compositing::Average);
    let view = view(&noise, 33.0, 21.0, None, 24);
    let of = |buffers| draw(&Splatter { buffers, ..Splatter::default() }, &noise, &view).frame;
    let image = of(Buffers::Image);
    assert!(image.pixels().iter().any(|p| p[3] > 0.3));
    for other in [Buffers::Axis, Buffers::Samples].map(of) {
        // Sums in another order.
        let pairs = image.pixels().iter().flatten().zip(other.pixels().iter().flatten());
        assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) < 1e-6);
    }
}

#[test]
fn values_picked_of_own_sheets_and_samples_come_nearer_as_voxels_become_small() {
    // One smooth field, at voxels of two sizes.
    let field = |n: usize| {
        let spacing = 8.0 / (n - 1) as f64;
        let value = |i: usize| {
            let [x, y, z] = [i % n, i / n % n, i / (n * n)].map(|x| x as f64 * spacing);
            (0.5 + 0.4 * libm::sin(0.8 * x) * libm::cos(0.7 * y + 0.2) * libm::sin(0.6 * z + 0.5)) as f32
        };
        let samples: Vec<f32> = (0..n * n * n).map(value).collect();
        let placement = Placement::from_spacing([spacing; 3]).unwrap();
        UniformGrid::<f32>::new([n; 3], samples, placement, Calibration::default()).unwrap()
    };
    for buffers in [Buffers::Axis, Buffers::Samples] {
        for compositing in [Compositing::Maximum, Compositing::Minimum, Compositing::First { threshold: 0.6 }] {
            for (azimuth, elevation, fov) in VIEWS {
                let [coarse, fine] = [9, 33].map(|n| {
                    let scene = scene(field(n), compositing);
                    error(
                        &Splatter { buffers, ..Splatter::default() },
                        &scene,
                        &view(&scene, azimuth, elevation, fov, 20),
                    )
                    .rmse
                });
                println!("{buffers:?} {} {azimuth}: {coarse:.1e}, {fine:.1e}", compositing.name());
                // A sample has its value as far as its kernel reaches, and a sheet that of its layer: the order 1 at least, a quarter. Where a first
                // hit just is or is not, all of it is at stake: in a line of pixels, which becomes narrow.
                let (bound, least) =
                    if matches!(compositing, Compositing::First { .. }) { (0.2, 1.4) } else { (0.03, 3.0) };
                assert!(
                    fine < bound && fine < coarse / least,
                    "{buffers:?} {compositing:?} {azimuth}: {coarse} {fine}"
                );
            }
        }
    }
}

#[test]
fn what_is_missing_has_no_value() {
    // A hole where the values would be the largest on one side, and the smallest on the other.
    let dims = [9, 9, 9];
    let value = |i: usize| {
        let at = [i % 9, i / 9 % 9, i / 81];
        let hole = at.iter().all(|&x| (2..=6).contains(&x));
        if hole { f32::NAN } else { 0.1 + 0.8 * at[0] as f32 / 8.0 }
    };
    let holed = || grid(dims, (0..729).map(value).collect(), Calibration::default());
    let first = Compositing::First { threshold: 0.45 };
    for compositing in [Compositing::Maximum, Compositing::Minimum, Compositing::Average, first] {
        let scene = scene(holed(), compositing);
        for (azimuth, elevation, fov) in VIEWS {
            let view = view(&scene, azimuth, elevation, fov, 24);
            let errors = [1.0, 0.25, 0.0625]
                .map(|slice_spacing| error(&Splatter { slice_spacing, ..Splatter::default() }, &scene, &view));
            println!("{} {azimuth}: {} / {} / {}", compositing.name(), errors[0], errors[1], errors[2]);
            // Holes are known to a sheet: order 1.
            assert!(errors[2].rmse < 5e-3 && errors[2].rmse < errors[0].rmse / 4.0, "{compositing:?} {azimuth}");
        }
    }
    // Nothing but holes.
    let nothing = scene(grid([3; 3], vec![f32::NAN; 27], Calibration::default()), Compositing::Maximum);
    let frame = draw(&Splatter::default(), &nothing, &view(&nothing, 33.0, 21.0, None, 8)).frame;
    assert!(frame.pixels().iter().all(|p| *p == [0.0; 4]));
}

#[test]
fn behind_a_hole_the_first_value_is_the_one_there() {
    // Along z, far to near: 0.9, a hole, 0.2. The threshold is never passed from below.
    let layers = [0.9, 0.9, 0.9, f32::NAN, 0.2, 0.2, 0.2];
    let samples = (0..6 * 6 * 7).map(|i| layers[i / 36]).collect();
    let scene = scene(grid([6, 6, 7], samples, Calibration::default()), Compositing::First { threshold: 0.5 });
    let through = view(&scene, 0.0, 0.0, None, 9);
    let m = error(&Splatter { slice_spacing: 0.1, ..Splatter::default() }, &scene, &through);
    assert!(m.max < 1e-6, "{m}");
    let seen = draw(&Splatter::default(), &scene, &through).frame.pixels()[40];
    assert!((seen[2] - 0.1).abs() < 1e-6 && seen[3] == 1.0, "{seen:?}: not the colour of the threshold");
}

#[test]
fn a_first_hit_is_a_shaded_surface() {
    let scene = phantom_scene::<f32>("hydrogen", 24, 1.0);
    let (low, high) = scene.volume.value_range().unwrap();
    let shading = Shading { specular: 0.4, ..Shading::default() };
    let scene = Scene {
        compositing: Compositing::First { threshold: low + 0.3 * (high - low) },
        shading: Some(shading.into()),
        lights: vec![Light::default(), Light { direction: Some(DVec3::new(1.0, 2.0, -0.5)), color: [0.3, 0.5, 0.9] }],
        ..scene
    };
    for (azimuth, elevation, fov) in VIEWS {
        let view = view(&scene, azimuth, elevation, fov, 32);
        let plain = Scene { shading: None, ..scene.clone() };
        let [coarse, fine] = [1.0, 0.125].map(|slice_spacing| {
            let renderer = Splatter { slice_spacing, ..Splatter::default() };
            [error(&renderer, &scene, &view).rmse, error(&renderer, &plain, &view).rmse]
        });
        println!("{azimuth}: {:.1e} (unshaded {:.1e}), {:.1e} ({:.1e})", coarse[0], coarse[1], fine[0], fine[1]);
        assert!(fine[0] < 2e-3, "{azimuth}: {}", fine[0]);
    }
}
