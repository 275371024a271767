//! Pictures that must be the same, however they are drawn; and those that must be near the truth.

use std::sync::Arc;

use vr_core::phantom::TRANSFER_UNIT_DISTANCE;
use vr_core::*;
use vr_physics::check::FixedLayer;
use vr_physics::check::pictures::*;
use vr_physics::{Metrics, Reference};
use vr_texslice::{Blend, Format, Proxy, TextureSlicer};

const VIEWS: [(f64, f64, Option<f64>); 4] =
    [(0.0, 0.0, None), (33.0, 21.0, None), (-60.0, 50.0, Some(35.0)), (140.0, -30.0, Some(80.0))];

fn largest_difference(a: &Frame, b: &Frame) -> f32 {
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn bricks_leave_no_seams() {
    for scene in [phantom_scene::<u8>("fog", 40, 1.0), phantom_scene::<i16>("blobs", 41, 1.0)] {
        for proxy in [Proxy::Planes, Proxy::Shells] {
            let whole = TextureSlicer { proxy, ..TextureSlicer::default() };
            // Room for eight of the 27 bricks of bytes, four of those of words.
            let bricked = TextureSlicer { brick: Some(16), budget: 0.04, ..whole.clone() };
            for (azimuth, elevation, fov) in VIEWS {
                let view = view(&scene, azimuth, elevation, fov, 40);
                let (a, b) = (draw(&whole, &scene, &view), draw(&bricked, &scene, &view));
                // The same samples in the same order: not a bit differs.
                assert_eq!(a.frame, b.frame, "{proxy:?} {azimuth}");
                assert!(b.stats.counts.samples > 0);
            }
        }
    }
}

#[test]
fn bricks_leave_no_seams_under_any_operator() {
    let fog = phantom_scene::<f32>("fog", 40, 1.0);
    let shaded = Scene { shading: Some(Shading::default().into()), ..fog.clone() };
    let over = |blend| (Compositing::Over, blend, &fog);
    let cases = [
        over(Blend::FrontToBack),
        over(Blend::BackToFront),
        (Compositing::Accumulate { level: 0.3 }, Blend::FrontToBack, &fog),
        (Compositing::Accumulate { level: 1.0 }, Blend::BackToFront, &fog),
        (Compositing::Maximum, Blend::FrontToBack, &fog),
        (Compositing::Minimum, Blend::FrontToBack, &fog),
        (Compositing::Average, Blend::FrontToBack, &fog),
        (Compositing::First { threshold: 0.45 }, Blend::FrontToBack, &fog),
        (Compositing::First { threshold: 0.45 }, Blend::FrontToBack, &shaded),
    ];
    for (compositing, blend, scene) in cases {
        let scene = Scene { compositing, ..scene.clone() };
        for proxy in [Proxy::Planes, Proxy::Shells] {
            // Slabs that are longer than a brick is wide, too.
            for slice_spacing in [0.5, 24.0] {
                let whole = TextureSlicer { proxy, blend, slice_spacing, ..TextureSlicer::default() };
                let bricked = TextureSlicer { brick: Some(16), budget: 0.1, ..whole.clone() };
                for (azimuth, elevation, fov) in VIEWS {
                    let view = view(&scene, azimuth, elevation, fov, 40);
                    let (a, b) = (draw(&whole, &scene, &view), draw(&bricked, &scene, &view));
                    assert!(a.frame == b.frame, "{compositing:?} {blend:?} {proxy:?} {slice_spacing} {azimuth}");
                    // Pixels, and depths with them.
                    assert!(b.frame.depth().is_some() && b.stats.counts.samples > 0);
                }
            }
        }
    }
}

#[test]
fn a_budget_too_small_is_refused() {
    let scene = phantom_scene::<u16>("fog", 40, 1.0);
    let view = view(&scene, 20.0, 10.0, None, 8);
    let control = Control::default();
    for renderer in [
        TextureSlicer { budget: 0.1, ..TextureSlicer::default() },
        TextureSlicer { budget: 0.005, brick: Some(16), ..TextureSlicer::default() },
        TextureSlicer { budget: 0.1, proxy: Proxy::Stacks, ..TextureSlicer::default() },
        TextureSlicer { budget: 0.9, format: Format::Rgba, ..TextureSlicer::default() },
        TextureSlicer { budget: 0.03, format: Format::Compressed, ..TextureSlicer::default() },
    ] {
        let drawn = renderer.prepare(&scene, &control).and_then(|mut p| p.render(&view, &control));
        assert!(matches!(drawn, Err(RenderError::TooLarge { .. })), "{renderer:?}");
    }
}

#[test]
fn what_is_skipped_cannot_be_seen() {
    for format in [Format::Scalar, Format::PreIntegrated, Format::Rgba, Format::Paletted] {
        let scene = phantom_scene::<u8>("blobs", 64, 1.0);
        let view = view(&scene, 33.0, 21.0, None, 128);
        let brute = draw(&TextureSlicer { format, ..TextureSlicer::brute_force() }, &scene, &view);
        let skipping =
            draw(&TextureSlicer { format, skip_empty_space: true, ..TextureSlicer::brute_force() }, &scene, &view);
        assert_eq!(brute.frame, skipping.frame, "{format:?}");
        let [all, drawn, skipped] =
            [brute.stats.counts.samples, skipping.stats.counts.samples, skipping.stats.counts.skipped];
        println!("{format:?}: {skipped} skipped of {all}");
        assert!(skipped > all / 10, "{format:?}: {skipped} of {all}");
        assert_eq!(drawn + skipped, all, "{format:?}");
        let ending = draw(&TextureSlicer { format, ..TextureSlicer::default() }, &scene, &view);
        assert!(largest_difference(&ending.frame, &brute.frame) <= 1e-4, "{format:?}");
        assert!(ending.stats.counts.samples <= drawn, "{format:?}");
    }
}

/// A scene with missing voxels where a phantom is nowhere near a corner, and in a wall across it.
fn with_vacuum(scene: &Scene) -> Scene {
    let grid = scene.volume.grid().unwrap();
    let [nx, ny, nz] = grid.dims();
    let mut samples = grid.filled_floats().unwrap().to_vec();
    for (i, sample) in samples.iter_mut().enumerate() {
        let [x, y, z] = [i % nx, i / nx % ny, i / (nx * ny)];
        if x + y < nx / 2 || (z == nz / 2 && x < 3 * nx / 4) {
            *sample = f32::NAN;
        }
    }
    let holed = UniformGrid::new([nx, ny, nz], samples, *grid.placement(), grid.calibration()).unwrap();
    Scene { volume: holed.into(), ..scene.clone() }
}

#[test]
fn what_is_skipped_changes_no_operator_beside_vacuum_or_not() {
    let plain = phantom_scene::<f32>("blobs", 40, 1.0);
    let operators = [
        Compositing::Over,
        Compositing::Maximum,
        Compositing::Minimum,
        Compositing::Average,
        Compositing::First { threshold: 0.3 },
    ];
    for (holes, scene) in [(false, plain.clone()), (true, with_vacuum(&plain))] {
        for compositing in operators {
            let scene = Scene { compositing, ..scene.clone() };
            let mut skipped = 0;
            for (format, proxy) in [
                (Format::Scalar, Proxy::Planes),
                (Format::Scalar, Proxy::Stacks),
                (Format::PreIntegrated, Proxy::Planes),
                (Format::PreIntegrated, Proxy::Stacks),
                (Format::Compressed, Proxy::Shells),
                (Format::Rgba, Proxy::Planes),
            ] {
                for (k, slice_spacing) in [0.6, 1.0, 5.0].into_iter().enumerate() {
                    for brick in [None, Some(13)] {
                        let brute =
                            TextureSlicer { format, proxy, slice_spacing, brick, ..TextureSlicer::brute_force() };
                        if brute.supports(&scene, None).is_err() {
                            continue;
                        }
                        let (azimuth, elevation, fov) = VIEWS[(k + usize::from(holes)) % VIEWS.len()];
                        let view = view(&scene, azimuth, elevation, fov, 32);
                        let skipping = TextureSlicer { skip_empty_space: true, ..brute.clone() };
                        let [all, some] = [&brute, &skipping].map(|renderer| draw(renderer, &scene, &view));
                        assert!(all.frame == some.frame, "{compositing:?} {skipping:?} {azimuth}");
                        skipped += some.stats.counts.skipped;
                    }
                }
            }
            println!("{compositing:?}, holes {holes}: {skipped} skipped");
            // A mean leaves out nothing but vacuum; and the smallest of these values is everywhere, give or take rounding.
            let leaves_out = holes || !matches!(compositing, Compositing::Average | Compositing::Minimum);
            assert_eq!(skipped > 0, leaves_out, "{compositing:?} {holes}: {skipped}");
        }
    }
}

#[test]
fn pixels_that_are_opaque_take_no_more() {
    let mut scene = phantom_scene::<u8>("fog", 32, 1.0);
    let dense = ControlPoint::new(0.0, [0.9, 0.5, 0.2], 0.9);
    let transfer = TransferFunction::new(vec![dense], OpacityRule::Power, TRANSFER_UNIT_DISTANCE).unwrap();
    scene.transfer = Arc::new(transfer);
    let view = view(&scene, 33.0, 21.0, None, 32);
    let [all, few] = [TextureSlicer::brute_force(), TextureSlicer::default()].map(|r| draw(&r, &scene, &view));
    assert!(largest_difference(&all.frame, &few.frame) <= 1e-4);
    assert!(few.stats.counts.samples < all.stats.counts.samples / 4);
}

#[test]
fn both_ways_of_blending_agree() {
    let scene = phantom_scene::<f32>("fog", 32, 1.0);
    let view = view(&scene, 33.0, 21.0, Some(30.0), 24);
    let front = draw(&TextureSlicer::brute_force(), &scene, &view).frame;
    let back = draw(&TextureSlicer { blend: Blend::BackToFront, ..TextureSlicer::brute_force() }, &scene, &view).frame;
    // Some hundred roundings.
    assert!(largest_difference(&front, &back) < 1e-6);
}

/// A plane in the world that cuts the volume, as a layer; and the same as a clip plane.
fn cut_at(scene: &Scene, plain: &View, depth: f64) -> (FixedLayer, View) {
    let forward = plain.camera.frame().unwrap().z_axis;
    let (low, high) = scene.volume.bounds();
    let offset = forward.dot(0.5 * (low + high)) + depth;
    let rays = Rays::new(plain).unwrap();
    let w = plain.size[0];
    let color = [0.3f32, 0.6, 0.1];
    let pixel = |i: u32| {
        let ray = rays.at(f64::from(i % w) + 0.5, f64::from(i / w) + 0.5);
        (color, ((offset - forward.dot(ray.origin)) / forward.dot(ray.direction)) as f32)
    };
    let plane = Plane { normal: -forward, offset: -offset };
    let clipped = View { clip: Clip { planes: vec![plane], ..Clip::default() }, ..plain.clone() };
    (FixedLayer::new(plain, pixel), clipped)
}

#[test]
fn a_layer_cuts_rays_where_it_is() {
    let scene = phantom_scene::<f32>("fog", 32, 1.0);
    let stacks = TextureSlicer { proxy: Proxy::Stacks, ..TextureSlicer::default() };
    let pre_integrated = TextureSlicer { format: Format::PreIntegrated, ..TextureSlicer::default() };
    let bricks = TextureSlicer { brick: Some(16), ..TextureSlicer::default() };
    let back = TextureSlicer { blend: Blend::BackToFront, ..TextureSlicer::default() };
    for fov in [None, Some(40.0)] {
        let plain = view(&scene, 33.0, 21.0, fov, 24);
        // 0.37 of a slab behind a slice, and elsewhere.
        for depth in [-0.4, 0.011_9, 0.3] {
            let (layered, clipped) = cut_at(&scene, &plain, depth);
            let walled = layered.clone().among(&scene);
            let truth = solve(&walled, &plain, &Model::Canonical, 1e-7);
            for renderer in [&TextureSlicer::default(), &stacks, &pre_integrated, &bricks, &back] {
                let got = draw(renderer, &walled, &plain).frame;
                let cut = draw(renderer, &scene, &clipped).frame;
                let want: Vec<[f64; 4]> =
                    (cut.pixels().iter().enumerate()).map(|(i, p)| layered.0.under(i, p.map(f64::from))).collect();
                let m = Metrics::of(&want, got.pixels());
                // A layer's depths are f32: a 10⁻⁷ of the distance.
                assert!(m.max < 2e-6, "{fov:?} {depth}: {m}");
                // And the ray cut there, in the reference: what half a voxel between slices leaves anywhere.
                let m = Metrics::of(&truth, got.pixels());
                assert!(m.max < 2e-3, "{fov:?} {depth}: {m}");
            }
        }
    }
}

/// A smooth bump under a spike a twentieth of a cell's range wide.
fn thin_shell() -> Scene {
    let profile = |i: usize| {
        let t = i as f64 / 32.0;
        let s = 4.0 * t * (1.0 - t);
        s * s
    };
    let samples: Vec<f32> =
        (0..33usize.pow(3)).map(|i| (profile(i % 33) * profile(i / 33 % 33) * profile(i / 1089)) as f32).collect();
    let placement = Placement::from_spacing([1.0; 3]).unwrap();
    let grid = UniformGrid::new([33; 3], samples, placement, Calibration::default()).unwrap();
    let c = [1.0, 0.7, 0.3];
    let points = [(0.495, 0.0), (0.5, 0.9), (0.505, 0.0)].map(|(v, a)| ControlPoint::new(v, c, a));
    Scene::new(grid.into(), TransferFunction::new(points.to_vec(), OpacityRule::Power, 1.0).unwrap())
}

#[test]
fn pre_integration_finds_thin_shells() {
    let scene = thin_shell();
    let view = view(&scene, 35.0, 25.0, None, 64);
    let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
    let rmse = |format, slice_spacing| {
        let renderer = TextureSlicer { format, slice_spacing, ..TextureSlicer::brute_force() };
        Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels()).rmse
    };
    for d in [0.25, 0.5, 1.0] {
        let [segments, samples] = [rmse(Format::PreIntegrated, 2.0 * d), rmse(Format::Scalar, 0.5 * d)];
        println!("d = {d}: pre-integrated at 2d {segments:.2e}, post-classified at d/2 {samples:.2e}");
        assert!(segments < samples, "{d}");
    }
}

#[test]
fn a_value_is_picked() {
    for compositing in
        [Compositing::Maximum, Compositing::Minimum, Compositing::Average, Compositing::First { threshold: 0.45 }]
    {
        for (azimuth, elevation, fov) in VIEWS {
            let scene = Scene { compositing, ..phantom_scene::<f32>("fog", 32, 1.0) };
            let view = view(&scene, azimuth, elevation, fov, 24);
            let m = error(&TextureSlicer { slice_spacing: 0.2, ..TextureSlicer::default() }, &scene, &view);
            println!("{compositing:?} {azimuth}: {m}");
            // Extremes and means of a smooth field, a fifth of a voxel apart; a first point may be missed where the field only just reaches it.
            let allowed = if matches!(compositing, Compositing::First { .. }) { 5e-2 } else { 1e-3 };
            assert!(m.rmse < allowed && (m.max < 1e-2 || allowed > 1e-2), "{compositing:?}: {m}");
        }
    }
}

#[test]
fn light_ends_at_a_level() {
    let scene = phantom_scene::<f32>("fog", 32, 1.0);
    for level in [0.05, 0.3, 0.9] {
        let cut = Scene { compositing: Compositing::Accumulate { level }, ..scene.clone() };
        let view = view(&cut, 33.0, 21.0, None, 24);
        let m = error(&TextureSlicer::default(), &cut, &view);
        assert!(m.max < 1e-3, "{level}: {m}");
    }
}

#[test]
fn samples_are_the_mean_over_the_pixel() {
    let scene = phantom_scene::<u8>("hydrogen", 32, 1.0);
    let view = View { supersampling: 3, ..view(&scene, 33.0, 21.0, Some(30.0), 9) };
    let fine = View { supersampling: 1, size: [27; 2], ..view.clone() };
    for brick in [None, Some(16)] {
        let renderer = TextureSlicer { brick, ..TextureSlicer::default() };
        let (coarse, fine) = (draw(&renderer, &scene, &view).frame, draw(&renderer, &scene, &fine).frame);
        for y in 0..9 {
            for x in 0..9 {
                let parts = (0..9).map(|k| fine.pixel(3 * x + k % 3, 3 * y + k / 3));
                let sum = parts.fold([0.0f32; 4], |s, p| std::array::from_fn(|c| s[c] + p[c]));
                for c in 0..4 {
                    assert!((coarse.pixel(x, y)[c] - sum[c] / 9.0).abs() < 1e-6);
                }
            }
        }
    }
}

#[test]
fn depths_are_where_half_is_hidden() {
    let scene = phantom_scene::<f32>("fog", 32, 3.0);
    let view = view(&scene, 33.0, 21.0, Some(30.0), 16);
    let solution = Reference::new(1e-7).solve(&scene, &view, &Model::Canonical, &Control::default()).unwrap();
    let frame = draw(&TextureSlicer { slice_spacing: 0.2, ..TextureSlicer::default() }, &scene, &view).frame;
    let mut seen = 0;
    for (got, pixel) in frame.depth().unwrap().iter().zip(&solution.pixels) {
        if pixel.depth.is_finite() && got.is_finite() {
            seen += 1;
            // A slab is 0.013 long.
            assert!((f64::from(*got) - pixel.depth).abs() < 1e-3, "{got} {}", pixel.depth);
        }
    }
    assert!(seen > 50, "{seen}");
}

#[test]
fn palettes_change_without_a_look_at_voxels() {
    let scene = phantom_scene::<u8>("fog", 32, 1.0);
    let other = Scene { transfer: phantom_scene::<u8>("fog", 8, 0.3).transfer, ..scene.clone() };
    let view = view(&scene, 33.0, 21.0, None, 16);
    let control = Control::default();
    let stages = |format| {
        let renderer = TextureSlicer { format, ..TextureSlicer::default() };
        let mut prepared = renderer.prepare(&scene, &control).unwrap();
        prepared.render(&view, &control).unwrap();
        prepared.update(&other, &control).unwrap();
        let second = prepared.render(&view, &control).unwrap();
        assert_eq!(second.frame, draw(&renderer, &other, &view).frame, "{format:?}");
        second.stats.stages.iter().map(|(stage, _)| *stage).collect::<Vec<_>>()
    };
    assert!(stages(Format::Paletted).contains(&"palette") && !stages(Format::Paletted).contains(&"classify"));
    assert!(stages(Format::Rgba).contains(&"classify"));
    assert!(!stages(Format::Scalar).contains(&"classify"));
}

#[test]
fn shaded_pictures_are_what_the_model_sums() {
    let shading = Some(Arc::new(Shading::default()));
    let scene = Scene { shading, ..phantom_scene::<u8>("hydrogen", 32, 0.5) };
    let brute = TextureSlicer::brute_force();
    for (renderer, fov) in [
        (brute.clone(), None),
        (brute.clone(), Some(40.0)),
        (TextureSlicer { proxy: Proxy::Stacks, slice_spacing: 1.0, ..brute.clone() }, Some(40.0)),
        (TextureSlicer { proxy: Proxy::Stacks, ..brute.clone() }, None),
        (TextureSlicer { format: Format::Rgba, ..brute.clone() }, None),
    ] {
        for (azimuth, elevation) in [(33.0, 21.0), (120.0, -70.0)] {
            let m = error_of_model(&renderer, &scene, &view(&scene, azimuth, elevation, fov, 24));
            println!("shaded {:?} {:?} {fov:?}: {m}", renderer.proxy, renderer.format);
            // Tables on hydrogen's transfer function, as unshaded.
            assert!(m.max < 1.5e-4, "{:?} {fov:?}: {m}", renderer.proxy);
        }
    }
}

#[test]
fn threads_change_nothing() {
    let scene = phantom_scene::<u8>("blobs", 32, 1.0);
    let view = view(&scene, 33.0, 21.0, Some(30.0), 70);
    for renderer in
        [TextureSlicer::default(), TextureSlicer { brick: Some(16), budget: 0.02, ..TextureSlicer::default() }]
    {
        let with = |threads| {
            let control = Control::default().with_threads(threads);
            renderer.prepare(&scene, &control).unwrap().render(&view, &control).unwrap().frame
        };
        assert_eq!(with(1), with(3));
    }
}
