//! Scenes that are drawn as they are, or refused: never as another scene.

use std::sync::Arc;

use vr_core::*;
use vr_physics::check::pictures::*;
use vr_texslice::{Blend, DrawOrder, Format, Proxy, TextureSlicer};

use crate::every_setting::PROXIES;

#[test]
fn what_it_cannot_draw_it_refuses() {
    let scene = phantom_scene::<u8>("fog", 8, 1.0);
    let view = view(&scene, 30.0, 20.0, None, 8);
    let control = Control::default();
    let refused = |renderer: TextureSlicer, scene: &Scene, view: &View| {
        let drawn = renderer.prepare(scene, &control).and_then(|mut p| p.render(view, &control));
        matches!(drawn, Err(RenderError::Unsupported(Unsupported { renderer: "texslice", .. })))
    };
    let plain = TextureSlicer::default;
    assert!(!refused(plain(), &scene, &view));
    assert!(refused(plain(), &scene.with_filter(Filter::BSpline), &view));
    assert!(refused(TextureSlicer { format: Format::LuminanceAlpha, ..plain() }, &scene, &view), "colours");
    let maximum = Scene { compositing: Compositing::Maximum, ..scene.clone() };
    assert!(refused(TextureSlicer { format: Format::Rgba, ..plain() }, &maximum, &view));
    assert!(!refused(TextureSlicer { brick: Some(16), ..plain() }, &maximum, &view));
    assert!(!refused(TextureSlicer { order: DrawOrder::Slices, ..plain() }, &maximum, &view));
    assert!(refused(TextureSlicer { termination: 0.5, ..plain() }, &maximum, &view), "no opacity is gathered");
    assert!(refused(TextureSlicer { order: DrawOrder::Slices, brick: Some(16), ..plain() }, &scene, &view));
    assert!(!refused(TextureSlicer { proxy: Proxy::Stacks, brick: Some(16), ..plain() }, &scene, &view));
    let stacks = TextureSlicer { order: DrawOrder::Slices, proxy: Proxy::Stacks, ..plain() };
    assert!(!refused(stacks, &scene, &View { supersampling: 2, ..view.clone() }), "quads");
    let level = Scene { compositing: Compositing::Accumulate { level: 0.5 }, ..scene.clone() };
    assert!(refused(TextureSlicer { blend: Blend::BackToFront, ..plain() }, &level, &view));
    let shaded = Scene { shading: Some(Arc::new(Shading::default())), ..scene.clone() };
    assert!(!refused(plain(), &shaded, &view));
    for compositing in [Compositing::Maximum, Compositing::Average, Compositing::First { threshold: 0.4 }] {
        let picked = Scene { compositing, ..scene.clone() };
        assert!(refused(TextureSlicer { blend: Blend::BackToFront, ..plain() }, &picked, &view), "nothing is blended");
        assert!(refused(TextureSlicer { correction: false, ..plain() }, &picked, &view), "no opacity to correct");
        let segments = TextureSlicer { format: Format::PreIntegrated, ..plain() };
        assert!(refused(segments, &picked, &view), "no light to integrate");
    }
    let analytic = Shading { gradient: GradientMethod::Analytic, ..Shading::default() };
    let analytic = Scene { shading: Some(analytic.into()), ..scene.clone() };
    assert!(!refused(plain(), &analytic, &view));
    for format in [Format::Rgba, Format::Paletted] {
        assert!(refused(TextureSlicer { format, ..plain() }, &analytic, &view), "a voxel has no one derivative");
    }
    // Light of a colour has three channels, and such a texture one.
    let white = ControlPoint::new(0.0, [1.0; 3], 0.5);
    let grey = TransferFunction::new(vec![white], OpacityRule::Power, 1.0).unwrap();
    let lit = |color| {
        let lights = vec![Light { color, ..Light::default() }];
        Scene { shading: Some(Shading::default().into()), lights, transfer: Arc::new(grey.clone()), ..scene.clone() }
    };
    let luminance = || TextureSlicer { format: Format::LuminanceAlpha, ..plain() };
    assert!(refused(luminance(), &lit([1.0, 0.2, 0.1]), &view) && !refused(luminance(), &lit([0.7; 3]), &view));
    let unlit = Scene { shading: None, ..lit([1.0, 0.2, 0.1]) };
    assert!(!refused(luminance(), &unlit, &view));
}

#[test]
fn stages_tell_what_had_to_be_made() {
    let scene = phantom_scene::<u8>("fog", 16, 1.0);
    let other = Scene { transfer: phantom_scene::<u8>("fog", 8, 0.3).transfer, ..scene.clone() };
    let control = Control::default();
    for (renderer, made_once) in [
        (TextureSlicer::default(), "table"),
        (TextureSlicer { proxy: Proxy::Stacks, ..TextureSlicer::default() }, "stack"),
        (TextureSlicer { format: Format::Rgba, ..TextureSlicer::default() }, "classify"),
        (TextureSlicer { format: Format::Paletted, ..TextureSlicer::default() }, "classify"),
        (TextureSlicer { format: Format::Compressed, ..TextureSlicer::default() }, "compress"),
    ] {
        let mut prepared = renderer.prepare(&scene, &control).unwrap();
        // Along x, whose stack has to be turned.
        let mut next = |azimuth: f64| {
            let drawn = prepared.render(&view(&scene, azimuth, 0.0, None, 8), &control).unwrap();
            let stages: Vec<_> = drawn.stats.stages.iter().map(|(stage, _)| *stage).collect();
            stages
        };
        assert!(next(90.0).contains(&made_once), "{made_once}");
        for stage in ["table", "stack", "classify", "palette", "compress"] {
            assert!(!next(90.0).contains(&stage), "{stage}");
        }
        prepared.update(&other, &control).unwrap();
        let drawn = prepared.render(&view(&scene, 90.0, 0.0, None, 8), &control).unwrap();
        let again = |stage| drawn.stats.stages.iter().any(|(s, _)| *s == stage);
        assert!(again("table") && !again("stack") && !again("compress"), "{made_once}");
    }
}

/// Light of a stack is that of slabs met at a right angle: views along the same axis share it.
#[test]
fn a_stack_of_light_serves_all_views_along_its_axis() {
    let scene = phantom_scene::<u8>("fog", 16, 1.0);
    let control = Control::default();
    for (format, made) in [(Format::Rgba, "classify"), (Format::Paletted, "palette")] {
        let renderer = TextureSlicer { format, proxy: Proxy::Stacks, ..TextureSlicer::default() };
        let mut prepared = renderer.prepare(&scene, &control).unwrap();
        for (k, azimuth) in [10.0, 25.0, -40.0, 12.0].into_iter().enumerate() {
            let view = view(&scene, azimuth, 5.0, None, 16);
            let drawn = prepared.render(&view, &control).unwrap();
            let anew = drawn.stats.stages.iter().any(|(stage, _)| [made, "classify"].contains(stage));
            assert_eq!(anew, k == 0, "{format:?} {azimuth}: {:?}", drawn.stats.stages);
            assert!(drawn.frame == draw(&renderer, &scene, &view).frame, "{format:?} {azimuth}");
        }
    }
}

#[test]
fn grey_light_is_the_same_in_two_channels_and_in_four() {
    let colored = phantom_scene::<u8>("fog", 16, 1.0);
    let mut points = colored.transfer.points().to_vec();
    points.iter_mut().for_each(|p| p.color = [p.color[1]; 3]);
    let transfer = TransferFunction::new(points, colored.transfer.rule(), colored.transfer.unit_distance()).unwrap();
    let plain = Scene { transfer: transfer.into(), ..colored };
    let shaded = Scene { shading: Some(Shading::default().into()), ..plain.clone() };
    for (scene, fov) in [(&plain, None), (&plain, Some(40.0)), (&shaded, None)] {
        let view = view(scene, 33.0, 21.0, fov, 24);
        for proxy in PROXIES {
            let of = |format| draw(&TextureSlicer { format, proxy, ..TextureSlicer::default() }, scene, &view).frame;
            assert_eq!(of(Format::LuminanceAlpha), of(Format::Rgba), "{proxy:?}");
        }
    }
}

/// A ramp along z, from which light is given on its own, shaded.
fn glowing(shading: Shading) -> Scene {
    let samples: Vec<f32> = (0..5 * 5 * 5).map(|i| (i / 25 + i % 5) as f32).collect();
    let grid = UniformGrid::new([5; 3], samples, Placement::from_spacing([1.0; 3]).unwrap(), Calibration::default());
    let point =
        |v: f64| ControlPoint { emission: Some([0.4, 0.1, 0.0]), ..ControlPoint::new(v, [0.9, 0.5, 0.2], v / 9.0) };
    let transfer = TransferFunction::new(vec![point(0.0), point(8.0)], OpacityRule::Power, 1.0).unwrap();
    Scene { shading: Some(shading.into()), ..Scene::new(grid.unwrap().into(), transfer) }
}

#[test]
fn a_surface_is_shaded_though_emission_is_given() {
    let compositing = Compositing::First { threshold: 3.0 };
    let scene = Scene { compositing, ..glowing(Shading { diffuse: 0.9, ambient: 0.1, ..Shading::default() }) };
    for (azimuth, elevation, fov) in [(33.0, 21.0, None), (-120.0, 40.0, Some(30.0))] {
        let m = error(&TextureSlicer::default(), &scene, &view(&scene, azimuth, elevation, fov, 24));
        // A plane that every ray crosses: nothing but f32 is left.
        assert!(m.max < 1e-5, "{azimuth}: {m}");
    }
}

#[test]
fn no_factor_changes_emission() {
    // The gradient is √2 everywhere: half of the extinction, and all of the emission.
    let modulated = Shading { gradient_opacity: vec![(0.0, 0.5)], ..Shading::default() };
    let scene = glowing(modulated);
    for (format, bound) in [
        // Measured, and half as much again: values on slices, and ends of rays between them.
        (Format::Scalar, 3e-4),
        (Format::PreIntegrated, 1e-6),
        (Format::Compressed, 3e-2),
        // Light and opacity of voxels are interpolated, which are not linear in the value.
        (Format::Rgba, 2.4e-2),
        (Format::Paletted, 2.4e-2),
    ] {
        let renderer = TextureSlicer { format, slice_spacing: 0.1, ..TextureSlicer::brute_force() };
        let m = error(&renderer, &scene, &view(&scene, 33.0, 21.0, None, 16));
        println!("{format:?}: {m}");
        assert!(m.max < bound, "{format:?}: {m}");
    }
    // What picks a value has no opacity to modulate.
    for compositing in [Compositing::Maximum, Compositing::First { threshold: 3.0 }] {
        let picked = Scene { compositing, ..scene.clone() };
        let m = error(&TextureSlicer::default(), &picked, &view(&scene, 33.0, 21.0, None, 16));
        assert!(m.max < 1e-5, "{compositing:?}: {m}");
    }
}

#[test]
fn a_negative_slope_turns_the_order_of_values_round() {
    let samples: Vec<u8> = (0..6 * 6 * 6).map(|i| (i * 7919 % 251) as u8).collect();
    let calibration = Calibration { slope: -0.5, intercept: 100.0 };
    let grid = UniformGrid::new([6; 3], samples, Placement::from_spacing([1.0; 3]).unwrap(), calibration).unwrap();
    let points = [-30.0, 100.0].map(|v| ControlPoint::new(v, [1.0, 0.5, 0.2], (v + 30.0) / 130.0)).to_vec();
    let scene = Scene::new(grid.into(), TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap());
    for compositing in [Compositing::Maximum, Compositing::Minimum, Compositing::Average] {
        let scene = Scene { compositing, ..scene.clone() };
        let renderer = TextureSlicer { slice_spacing: 0.02, ..TextureSlicer::default() };
        let m = error(&renderer, &scene, &view(&scene, 33.0, 21.0, None, 16));
        // Noise from voxel to voxel: an extreme between two samples is missed by less than a hundredth of that.
        assert!(m.max < 1e-2, "{compositing:?}: {m}");
    }
}
