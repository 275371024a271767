//! Radial kernels evaluated in the middle of sheets: pictures equal the model, however rays are cut or tilted, and nothing visible is left out.

use std::sync::Arc;

use vr_core::*;
use vr_physics::check::pictures::*;
use vr_splat::{Shape, SplatKernel, Splatter};

/// Random voxels; those below the threshold are transparent.
fn scene(spacing: [f64; 3], threshold: f64) -> Scene {
    let mut seed = 7u64;
    let mut next = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f32 / (1 << 24) as f32
    };
    let placement = Placement::from_spacing(spacing).unwrap();
    let samples: Vec<f32> = (0..13 * 11 * 12).map(|_| next()).collect();
    let grid = UniformGrid::new([13, 11, 12], samples, placement, Calibration::default()).unwrap();
    let points = vec![
        ControlPoint::new(threshold, [1.0, 0.4, 0.1], 0.0),
        ControlPoint::new(threshold + 0.4, [0.2, 0.8, 1.0], 0.2),
    ];
    Scene::new(grid.into(), TransferFunction::new(points, OpacityRule::Extinction, 1.0).unwrap())
}

fn kernels() -> [SplatKernel; 5] {
    let gaussian = SplatKernel::new(Shape::Gaussian);
    [
        gaussian,
        SplatKernel::new(Shape::Cone),
        SplatKernel { width: [1.0, 1.4, 0.8], radius: 2.2, ..gaussian },
        // Too steep for the recurrence from sheet to sheet.
        SplatKernel { sigma: 0.3, radius: 2.5, ..gaussian },
        SplatKernel { sigma: 1.5, radius: 4.0, ..gaussian },
    ]
}

#[test]
fn pictures_are_what_the_model_sums() {
    let mut worst = 0.0f64;
    for (spacing, low_pass) in [([1.0; 3], 0.0), ([1.0; 3], 0.7), ([0.7, 1.0, 1.9], 0.0)] {
        let scene = scene(spacing, 0.0);
        for kernel in kernels() {
            for slice_spacing in [0.25, 1.0, 5.0] {
                let renderer = Splatter { kernel, slice_spacing, low_pass, termination: 1.0, ..Splatter::default() };
                for (azimuth, elevation, fov) in [(0.0, 0.0, None), (33.0, 21.0, None), (-60.0, 50.0, Some(50.0))] {
                    let m = error_of_model(&renderer, &scene, &view(&scene, azimuth, elevation, fov, 9));
                    worst = worst.max(m.max);
                    // Rounding; the largest error found is 8·10⁻⁷.
                    assert!(m.max < 3e-6, "{kernel:?} {spacing:?} {low_pass} {slice_spacing} {fov:?}: {m}");
                }
            }
        }
    }
    println!("{worst:.1e}");
}

#[test]
fn what_is_left_out_cannot_be_seen() {
    // With a low-pass of pixels smaller than voxels, and of as large ones.
    let cases =
        [([1.0; 3], 0.55, 0.0), ([0.7, 1.0, 1.9], 0.6, 0.0), ([1.0; 3], 0.55, 3.0), ([0.7, 1.0, 1.9], 0.6, 9.0)];
    for (spacing, threshold, low_pass) in cases {
        let scene = scene(spacing, threshold);
        // The same scene with a faint opacity where there was none: every cell is visible, and the picture changes by less than the tolerance.
        let mut points = scene.transfer.points().to_vec();
        points.iter_mut().for_each(|p| p.opacity = p.opacity.max(1e-12));
        let transfer = TransferFunction::new(points, scene.transfer.rule(), scene.transfer.unit_distance()).unwrap();
        let everything = Scene { transfer: Arc::new(transfer), ..scene.clone() };
        for kernel in kernels() {
            let renderer = Splatter { kernel, low_pass, termination: 1.0, ..Splatter::default() };
            for fov in [None, Some(40.0)] {
                let view = view(&scene, 33.0, 21.0, fov, 64);
                let (some, all) = (draw(&renderer, &scene, &view), draw(&renderer, &everything, &view));
                let pairs = some.frame.pixels().iter().flatten().zip(all.frame.pixels().iter().flatten());
                let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                println!(
                    "{:?}, {low_pass}: {} of {}, {off:e}",
                    kernel, some.stats.counts.samples, all.stats.counts.samples
                );
                assert!(off < 1e-5, "{kernel:?} {spacing:?} {low_pass} {fov:?}: {off:e}");
            }
        }
    }
}

#[test]
fn a_low_pass_shows_a_voxel_in_cells_that_its_own_kernel_does_not_reach() {
    let placement = Placement::from_spacing([1.0; 3]).unwrap();
    let mut samples = vec![0.0f32; 15 * 15 * 15];
    samples[(7 * 15 + 7) * 15 + 7] = 1.0;
    let grid = UniformGrid::new([15; 3], samples, placement, Calibration::default()).unwrap();
    let points = |faint: f64| {
        vec![ControlPoint::new(0.002, [1.0, 0.4, 0.1], faint), ControlPoint::new(0.2, [0.2, 0.8, 1.0], 0.9)]
    };
    let scene = |faint| TransferFunction::new(points(faint), OpacityRule::Extinction, 1.0).unwrap();
    let some = Scene::new(grid.into(), scene(0.0));
    // With a faint opacity every cell is visible.
    let all = Scene { transfer: Arc::new(scene(1e-12)), ..some.clone() };
    let renderer =
        Splatter { kernel: SplatKernel::new(Shape::Gaussian), low_pass: 9.0, termination: 1.0, ..Splatter::default() };
    for fov in [None, Some(40.0)] {
        let view = view(&some, 33.0, 21.0, fov, 64);
        let [some, all] = [&some, &all].map(|scene| draw(&renderer, scene, &view).frame);
        let pairs = some.pixels().iter().flatten().zip(all.pixels().iter().flatten());
        let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off < 1e-5, "{fov:?}: {off:e}");
    }
}
