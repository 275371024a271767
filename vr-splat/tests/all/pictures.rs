//! Pictures that must be the same, however they are drawn; and those that must be near the truth.

use std::sync::Arc;

use vr_core::Classification;
use vr_core::*;
use vr_physics::Metrics;
use vr_physics::check::FixedLayer;
use vr_physics::check::pictures::*;
use vr_splat::{Buffers, CompositingOrder, Shape, SplatKernel, Splatter};

const VIEWS: [(f64, f64, Option<f64>); 4] =
    [(0.0, 0.0, None), (33.0, 21.0, None), (-60.0, 50.0, Some(35.0)), (140.0, -30.0, Some(80.0))];

fn largest_difference(a: &Frame, b: &Frame) -> f32 {
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn values_in_image_sheets_come_to_the_canonical_pixel() {
    for scene in [phantom_scene::<u8>("fog", 32, 1.0), phantom_scene::<f32>("hydrogen", 32, 1.0)] {
        for (azimuth, elevation, fov) in VIEWS {
            let view = view(&scene, azimuth, elevation, fov, 24);
            let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
            let of = |slice_spacing| {
                let renderer = Splatter { slice_spacing, termination: 1.0, ..Splatter::default() };
                Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels()).rmse
            };
            let (coarse, fine) = (of(1.0), of(0.25));
            println!("{azimuth} {fov:?}: {coarse:.1e} {fine:.1e}");
            // The square of a quarter is a sixteenth; kinks and tables take a part of it.
            assert!(coarse < 5e-3 && fine < coarse / 8.0, "{azimuth}: {coarse:e} {fine:e}");
        }
    }
}

#[test]
fn what_is_left_out_cannot_be_seen() {
    let scene = phantom_scene::<u8>("blobs", 48, 1.0);
    // The same with a light that cannot be seen where there was none: nothing is left out.
    let mut points = scene.transfer.points().to_vec();
    points.iter_mut().for_each(|p| p.opacity = p.opacity.max(1e-12));
    let transfer = TransferFunction::new(points, scene.transfer.rule(), scene.transfer.unit_distance()).unwrap();
    let everything = Scene { transfer: Arc::new(transfer), ..scene.clone() };
    for shape in Shape::ALL {
        for buffers in [Buffers::Image, Buffers::Axis] {
            let kernel = SplatKernel::new(shape);
            let renderer = Splatter { buffers, kernel, termination: 1.0, ..Splatter::default() };
            let view = view(&scene, 33.0, 21.0, None, 64);
            let (some, all) = (draw(&renderer, &scene, &view), draw(&renderer, &everything, &view));
            let off = largest_difference(&some.frame, &all.frame);
            println!("{shape:?} {buffers:?}: {} of {}, {off:e}", some.stats.counts.samples, all.stats.counts.samples);
            assert!(off < 1e-5, "{shape:?} {buffers:?}: {off:e}");
            // The wider kernels are, the more voxels have a part in what can be seen.
            let max_samples =
                if shape == Shape::Bilinear { all.stats.counts.samples / 2 } else { all.stats.counts.samples };
            assert!(some.stats.counts.samples < max_samples);
        }
    }
}

#[test]
fn back_to_front_is_front_to_back() {
    let scene = phantom_scene::<u16>("fog", 32, 1.0);
    for classification in [Classification::Post, Classification::Pre] {
        let front = Splatter { buffers: Buffers::Axis, classification, termination: 1.0, ..Splatter::default() };
        let back = Splatter { order: CompositingOrder::BackToFront, ..front.clone() };
        for (azimuth, elevation, fov) in VIEWS {
            let view = view(&scene, azimuth, elevation, fov, 48);
            let off = largest_difference(&draw(&front, &scene, &view).frame, &draw(&back, &scene, &view).frame);
            // Sums of some thirty sheets, rounded in another order.
            assert!(off < 2e-6, "{azimuth}: {off:e}");
        }
    }
}

#[test]
fn light_ends_behind_what_is_opaque() {
    let fog = phantom_scene::<u8>("fog", 32, 1.0);
    let dense = TransferFunction::new(fog.transfer.points().to_vec(), OpacityRule::Power, 5e-4).unwrap();
    let scene = Scene { transfer: dense.into(), ..fog };
    for buffers in [Buffers::Image, Buffers::Axis, Buffers::Samples] {
        let all = Splatter { buffers, termination: 1.0, ..Splatter::default() };
        let early = Splatter { buffers, ..Splatter::default() };
        let view = view(&scene, 33.0, 21.0, None, 64);
        let (all, early) = (draw(&all, &scene, &view), draw(&early, &scene, &view));
        assert!(early.stats.counts.samples < all.stats.counts.samples / 2, "{buffers:?}");
        assert!(early.stats.counts.terminated > 0, "{buffers:?}");
        let off = largest_difference(&all.frame, &early.frame);
        assert!(off <= 1.01e-4, "{buffers:?}: {off:e}");
    }
}

#[test]
fn threads_and_samples_and_layers() {
    let scene = phantom_scene::<u8>("fog", 32, 1.0);
    for renderer in [
        Splatter::default(),
        Splatter { buffers: Buffers::Axis, kernel: SplatKernel::new(Shape::Gaussian), ..Splatter::default() },
    ] {
        let plain = view(&scene, 33.0, 21.0, Some(30.0), 40);
        let on = |threads: usize, view: &View| {
            let control = Control::default().with_threads(threads);
            renderer.prepare(&scene, &control).unwrap().render(view, &control).unwrap().frame
        };
        assert_eq!(on(1, &plain), on(3, &plain));
        // Nine subpixels are pixels of a picture three times as large.
        let fine = View { supersampling: 3, ..plain.clone() };
        let large = on(2, &View { size: [120, 120], ..plain.clone() });
        let averaged = on(2, &fine);
        let worst = (0..1600).flat_map(|i| (0..4).map(move |c| (i, c))).map(|(i, c)| {
            let (x, y) = (3 * (i % 40), 3 * (i / 40));
            let sum: f32 = (0..9).map(|k| large.pixels()[(y + k / 3) * 120 + x + k % 3][c]).sum();
            (sum / 9.0 - averaged.pixels()[i][c]).abs()
        });
        assert!(worst.fold(0.0, f32::max) < 1e-6);
    }
    // A wall across the middle hides what is behind it.
    let flat = view(&scene, 0.0, 0.0, None, 32);
    let depth = (flat.camera.eye - flat.camera.target).length() as f32;
    let walled = FixedLayer::new(&flat, |_| ([0.0; 3], depth)).among(&scene);
    let cut = Plane { normal: glam::DVec3::Z, offset: flat.camera.target.z };
    let clipped = View { clip: Clip { crop: None, planes: vec![cut] }, ..flat.clone() };
    let (behind, half) =
        (draw(&Splatter::default(), &walled, &flat).frame, draw(&Splatter::default(), &scene, &clipped).frame);
    for (a, b) in behind.pixels().iter().zip(half.pixels()) {
        assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-6) && a[3] == 1.0);
    }
}

#[test]
fn values_are_picked_as_by_the_reference() {
    let scene = phantom_scene::<f32>("hydrogen", 32, 1.0);
    let picks = [
        Compositing::Maximum,
        Compositing::Minimum,
        Compositing::First { threshold: 0.05 },
        Compositing::Accumulate { level: 0.3 },
    ];
    for compositing in picks {
        let scene = Scene { compositing, ..scene.clone() };
        let renderer = Splatter { slice_spacing: 0.1, termination: 1.0, ..Splatter::default() };
        for (azimuth, elevation, fov) in VIEWS {
            let view = view(&scene, azimuth, elevation, fov, 16);
            let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
            let m = Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels());
            println!("{} {azimuth}: {m}", compositing.name());
            // Where a ray just passes a surface or just not, it may fall to the other side: in one pixel, not in the mean.
            assert!(m.rmse < 2e-2, "{} {azimuth}: {m}", compositing.name());
        }
    }
}

#[test]
fn a_low_pass_keeps_the_light() {
    // Voxels a sixth of a pixel wide, that glow: between the centres of pixels most of it would be lost.
    let scene = phantom_scene::<u8>("blobs", 48, 0.02);
    let camera = Camera::framing(scene.volume.bounds(), 33.0, 21.0, None);
    let total = |low_pass: f64, side: u32| {
        let renderer = Splatter {
            buffers: Buffers::Axis,
            classification: Classification::Pre,
            kernel: SplatKernel::new(Shape::Gaussian),
            low_pass,
            ..Splatter::default()
        };
        let frame = draw(&renderer, &scene, &View::new(camera, [side; 2])).frame;
        frame.pixels().iter().map(|p| f64::from(p[3])).sum::<f64>() / f64::from(side * side)
    };
    let (truth, filtered) = (total(0.0, 256), total(1.5, 10));
    // Faint: what one voxel hides of another does not count.
    assert!((filtered / truth - 1.0).abs() < 0.02, "{filtered} for {truth}");
}

#[test]
fn what_cannot_be_drawn_is_said() {
    let scene = phantom_scene::<u8>("fog", 8, 1.0);
    let control = Control::default();
    let refused = |renderer: Splatter, scene: &Scene| match renderer.prepare(scene, &control) {
        Err(RenderError::Unsupported(Unsupported { renderer: "splat", what: feature, .. })) => feature,
        other => panic!("{:?}", other.map(|_| "prepared")),
    };
    let voxels = Splatter { classification: Classification::Pre, ..Splatter::default() };
    let smooth = scene.with_filter(Filter::BSpline);
    let cones = Splatter { kernel: SplatKernel::new(Shape::Cone), ..Splatter::default() };
    assert!(refused(cones, &smooth).contains("kernel"));
    assert!(refused(voxels.clone(), &smooth).contains("coefficients"));
    let brightest = Scene { compositing: Compositing::Maximum, ..scene.clone() };
    assert!(refused(voxels.clone(), &brightest).contains("maximum"));
    assert!(refused(Splatter { termination: 0.5, ..Splatter::default() }, &brightest).contains("termination"));
    assert!(refused(Splatter { order: CompositingOrder::BackToFront, ..Splatter::default() }, &scene).contains("back"));
    let points = PointSet::new(vec![glam::DVec3::ZERO], vec![1.0], vec![1.0], vec![1.0], PointKernel::Cone).unwrap();
    let cloud = Scene { volume: points.into(), ..scene.clone() };
    assert!(refused(Splatter { buffers: Buffers::Axis, ..Splatter::default() }, &cloud).contains("layers"));
    let shape = |shape| SplatKernel::new(shape);
    for kernel in [
        shape(Shape::Gaussian),
        SplatKernel { radius: 2.0, ..SplatKernel::default() },
        SplatKernel { width: [1.0, 1.0, 2.0], ..SplatKernel::default() },
    ] {
        let feature = refused(Splatter { kernel, ..Splatter::default() }, &cloud);
        assert!(feature.contains("kernels of their own"), "{feature}");
    }
    let analytic = Shading { gradient: GradientMethod::Analytic, ..Shading::default() };
    let analytic = Scene { shading: Some(Arc::new(analytic)), ..scene.clone() };
    let axis = Splatter { buffers: Buffers::Axis, ..Splatter::default() };
    assert!(refused(axis, &analytic).contains("no slope"));
    assert!(refused(voxels, &analytic).contains("kink"));
}

#[test]
fn what_is_beside_missing_voxels_is_shaded() {
    // A slanted plane of values with a ball of holes in it.
    let dims = [12, 11, 13];
    let value = |i: usize| {
        let at = [i % 12, i / 12 % 11, i / 132].map(|x| x as f32);
        let from_middle: f32 = (0..3).map(|a| (at[a] - 5.5) * (at[a] - 5.5)).sum();
        if from_middle < 6.0 { f32::NAN } else { 0.05 * at[0] + 0.03 * at[1] + 0.002 * at[2] * at[2] }
    };
    let samples: Vec<f32> = (0..dims.iter().product()).map(value).collect();
    let placement = Placement::from_spacing([0.7, 1.0, 1.3]).unwrap();
    let grid = UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap();
    let points = [0.0, 1.3].map(|v| ControlPoint::new(v, [1.0, 0.5, 1.0 - 0.5 * v], 0.5 * v)).to_vec();
    let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
    let shading = Shading { specular: 0.4, ..Shading::default() };
    let scene = Scene { shading: Some(shading.into()), ..Scene::new(grid.into(), transfer) };
    for (azimuth, elevation, fov) in [(33.0, 21.0, None), (-60.0, 50.0, Some(35.0))] {
        let view = view(&scene, azimuth, elevation, fov, 24);
        let of = |slice_spacing| Splatter { slice_spacing, termination: 1.0, ..Splatter::default() };
        let model = error_of_model(&of(1.0), &scene, &view);
        let errors = [1.0, 0.25, 0.0625].map(|d| error(&of(d), &scene, &view).rmse);
        println!("{azimuth}: model {:.1e}; {:.1e} {:.1e} {:.1e}", model.max, errors[0], errors[1], errors[2]);
        // A sheet knows a hole as a whole or not at all: order 1.
        assert!(model.max < 2e-4 && errors[2] < errors[0] / 4.0 && errors[2] < 1e-3, "{azimuth}: {model} {errors:?}");
    }
}
