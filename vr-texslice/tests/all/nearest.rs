//! Textures whose nearest texel is taken: against the renderer's own model, and against the reference.

use vr_core::*;
use vr_physics::Metrics;
use vr_physics::check::pictures::*;
use vr_texslice::{Blend, DrawOrder, Format, Proxy, TextureSlicer};

use crate::every_setting::{FORMATS, PROXIES, both, grey, looks_of_view, views};

/// Grey fog of blocks.
fn blocks() -> Scene {
    grey::<u8>(14).with_filter(Filter::Nearest)
}

/// Formats that are no segments.
fn formats() -> impl Iterator<Item = Format> {
    FORMATS.into_iter().filter(|&format| format != Format::PreIntegrated)
}

#[test]
fn pictures_are_what_the_model_sums() {
    let scene = blocks();
    for (format, proxy) in formats().flat_map(|f| PROXIES.map(|p| (f, p))) {
        let renderer = TextureSlicer { format, proxy, ..TextureSlicer::brute_force() };
        for (azimuth, elevation, fov) in [(33.0, 21.0, None), (-60.0, 50.0, Some(35.0))] {
            for scene in [&scene, &Scene { shading: Some(Shading::default().into()), ..scene.clone() }] {
                let m = error_of_model(&renderer, scene, &view(scene, azimuth, elevation, fov, 24));
                assert!(m.max < 2e-5, "{format:?} {proxy:?} {azimuth}: {m}");
            }
        }
    }
}

/// A layer of a stack is all that lies between the faces of its voxels: seen along its axis, nothing is approximated.
#[test]
fn a_stack_along_its_axis_is_exact() {
    let scene = blocks();
    for (azimuth, elevation) in [(0.0, 0.0), (90.0, 0.0), (0.0, 90.0)] {
        // No pixel's ray goes along the faces of voxels.
        let mut view = view(&scene, azimuth, elevation, None, 29);
        let [right, up] = [view.camera.frame().unwrap().x_axis, view.camera.frame().unwrap().y_axis];
        let aside = 0.0137 * right + 0.0071 * up;
        (view.camera.eye, view.camera.target) = (view.camera.eye + aside, view.camera.target + aside);
        let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
        for format in [Format::Scalar, Format::Rgba, Format::LuminanceAlpha, Format::Paletted] {
            let renderer =
                TextureSlicer { format, proxy: Proxy::Stacks, slice_spacing: 1.0, ..TextureSlicer::brute_force() };
            let m = Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels());
            assert!(m.max < 2e-6, "{format:?} {azimuth}: {m}");
        }
    }
}

#[test]
fn errors_fall_with_the_distance_of_slices() {
    let scene = blocks();
    let view = view(&scene, 33.0, 21.0, None, 24);
    let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
    for format in [Format::Scalar, Format::Rgba] {
        let of = |slice_spacing| {
            let renderer = TextureSlicer { format, slice_spacing, ..TextureSlicer::brute_force() };
            Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels()).rmse
        };
        let errors = [1.0, 0.25, 0.0625].map(of);
        println!("{format:?}: {errors:?}");
        // Jumps: order 1.
        assert!(errors[1] < errors[0] / 3.0 && errors[2] < errors[1] / 3.0, "{format:?}: {errors:?}");
    }
}

#[test]
fn bricks_and_whole_slices_are_the_same_picture() {
    let scene = blocks();
    for (k, view) in views(&scene, [22, 19], [33.0, 21.0]).iter().enumerate() {
        for (format, proxy) in formats().flat_map(|f| PROXIES.map(|p| (f, p))) {
            for blend in [Blend::FrontToBack, Blend::BackToFront] {
                // Gradients by which shading and opacity go: analytic ones are refused.
                for scene in looks_of_view(&scene, k) {
                    let one = TextureSlicer { format, proxy, blend, ..TextureSlicer::brute_force() };
                    let bricks = TextureSlicer { brick: Some(8), ..one.clone() };
                    let slices = TextureSlicer { order: DrawOrder::Slices, ..one.clone() };
                    for other in [bricks, slices] {
                        if let Some([one, other]) = both([one.clone(), other], &scene, view) {
                            assert!(one.frame == other.frame, "{format:?} {proxy:?} {blend:?} {:?}", view.camera);
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn picked_values_are_those_of_voxels() {
    let scene = blocks();
    for compositing in [Compositing::Maximum, Compositing::Minimum, Compositing::First { threshold: 0.45 }] {
        let scene = Scene { compositing, ..scene.clone() };
        let view = view(&scene, 33.0, 21.0, None, 16);
        let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
        for format in [Format::Scalar, Format::Compressed] {
            let renderer = TextureSlicer { format, slice_spacing: 0.02, ..TextureSlicer::default() };
            let m = Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels());
            println!("{format:?}, {}: {m}", compositing.name());
            // Corners of voxels that a ray cuts between two samples; and half a level of a block.
            let allowed = if format == Format::Scalar { 1e-2 } else { 5e-2 };
            assert!(m.rmse < allowed, "{format:?}, {}: {m}", compositing.name());
        }
    }
}

#[test]
fn what_needs_a_continuous_field_is_refused() {
    let scene = blocks();
    let refused = |renderer: &TextureSlicer, scene: &Scene| match renderer.supports(scene, None) {
        Err(RenderError::Unsupported(unsupported)) => Some(unsupported.feature),
        other => other.map(|()| None).unwrap(),
    };
    let plain = TextureSlicer::default();
    assert_eq!(refused(&plain, &scene), None);
    let segments = TextureSlicer { format: Format::PreIntegrated, ..plain.clone() };
    assert_eq!(refused(&segments, &scene), Some(Feature::Setting));
    let analytic = Shading { gradient: GradientMethod::Analytic, ..Shading::default() };
    let analytic = Scene { shading: Some(analytic.into()), ..scene };
    assert_eq!(refused(&plain, &analytic), Some(Feature::AnalyticGradients));
}
