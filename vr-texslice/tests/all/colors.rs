//! Grids whose voxels have colours: against the renderer's own model, and against the reference.

use vr_core::*;
use vr_physics::Metrics;
use vr_physics::check::pictures::*;
use vr_texslice::{Format, Proxy, TextureSlicer};

use crate::every_setting::{FORMATS, PROXIES, both};

const VIEWS: [(f64, f64, Option<f64>); 2] = [(33.0, 21.0, None), (-60.0, 50.0, Some(35.0))];

/// Formats that a filter has, but for luminance, which is no colour.
fn formats(filter: Filter) -> impl Iterator<Item = Format> {
    let segments = filter == Filter::Trilinear;
    let drawn = move |format: &Format| match format {
        Format::LuminanceAlpha => false,
        Format::PreIntegrated => segments,
        _ => true,
    };
    FORMATS.into_iter().filter(drawn)
}

#[test]
fn pictures_are_what_the_model_sums() {
    for filter in [Filter::Trilinear, Filter::Nearest] {
        for (name, scene) in looks_of_bytes(&colored_scene(filter)) {
            for (format, proxy) in formats(filter).flat_map(|f| PROXIES.map(|p| (f, p))) {
                let renderer = TextureSlicer { format, proxy, ..TextureSlicer::brute_force() };
                for (azimuth, elevation, fov) in VIEWS {
                    let m = error_of_model(&renderer, &scene, &view(&scene, azimuth, elevation, fov, 16));
                    println!("{filter} {name} {format:?} {proxy:?}: {m}");
                    // Rounding; of a palette's levels of gradients some texel may be on either side.
                    let max = if format == Format::PreIntegrated { 1e-3 } else { 2e-4 };
                    assert!(m.max < max, "{filter} {name} {format:?} {proxy:?} {azimuth}: {m}");
                }
            }
        }
    }
}

#[test]
fn slices_converge_to_the_reference() {
    for filter in [Filter::Trilinear, Filter::Nearest] {
        for (name, scene) in looks_of_bytes(&colored_scene(filter)) {
            for (azimuth, elevation, fov) in VIEWS {
                let view = view(&scene, azimuth, elevation, fov, 16);
                let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
                for format in [Format::Scalar, Format::PreIntegrated] {
                    if !formats(filter).any(|f| f == format) {
                        continue;
                    }
                    let errors = [0.5, 0.125].map(|slice_spacing| {
                        let renderer = TextureSlicer { format, slice_spacing, ..TextureSlicer::brute_force() };
                        Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels()).rmse
                    });
                    println!("{filter} {name} {format:?} {azimuth}: {errors:?}");
                    let least = if filter == Filter::Nearest { 2.0 } else { 8.0 };
                    let near = errors[1] < 3e-3 && errors[1] < errors[0] / least + 2e-5;
                    assert!(near, "{filter} {name} {format:?} {azimuth}: {errors:?}");
                }
            }
        }
    }
}

#[test]
fn every_operator_has_the_colour_of_the_place() {
    let operators = [
        (Compositing::Maximum, 2e-2),
        (Compositing::Minimum, 2e-2),
        (Compositing::Average, 2e-3),
        (Compositing::First { threshold: 150.0 }, 3e-3),
        (Compositing::Accumulate { level: 0.5 }, 2e-3),
    ];
    for (compositing, most) in operators {
        let scene = Scene { compositing, ..colored_scene(Filter::Trilinear) };
        let view = view(&scene, 33.0, 21.0, None, 16);
        let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
        for format in [Format::Scalar, Format::Compressed] {
            let renderer = TextureSlicer { format, slice_spacing: 0.1, ..TextureSlicer::default() };
            let m = Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels());
            println!("{format:?} {}: {m}", compositing.name());
            // A smooth extreme's place is known to a slice, and the colour changes by a tenth on that; compressed values have 4 levels to a block.
            let most = if format == Format::Scalar { most } else { 6e-2 };
            assert!(m.rmse < most, "{format:?} {}: {m}", compositing.name());
        }
    }
}

#[test]
fn bricks_are_the_same_picture() {
    for filter in [Filter::Trilinear, Filter::Nearest] {
        for (name, scene) in looks_of_bytes(&colored_scene(filter)) {
            for (format, proxy) in formats(filter).flat_map(|f| [Proxy::Planes, Proxy::Stacks].map(|p| (f, p))) {
                for compositing in [Compositing::Over, Compositing::Average] {
                    let scene = Scene { compositing, ..scene.clone() };
                    let view = view(&scene, 33.0, 21.0, None, 16);
                    let one = TextureSlicer { format, proxy, ..TextureSlicer::brute_force() };
                    let bricks = TextureSlicer { brick: Some(8), ..one.clone() };
                    if let Some([one, other]) = both([one, bricks], &scene, &view) {
                        assert!(one.frame == other.frame, "{filter} {name} {format:?} {proxy:?}");
                    }
                }
            }
        }
    }
}

/// Textures of one scene are kept for the next only where they hold for it.
#[test]
fn an_update_is_a_new_preparation() {
    let control = Control::default();
    for format in [Format::Scalar, Format::Rgba, Format::Paletted] {
        let renderer = TextureSlicer { format, ..TextureSlicer::default() };
        let looks = looks_of_bytes(&colored_scene(Filter::Trilinear));
        let view = view(&looks[0].1, 33.0, 21.0, None, 12);
        let mut kept = renderer.prepare(&looks[1].1, &control).unwrap();
        kept.render(&view, &control).unwrap();
        for (name, scene) in looks.iter().chain(&looks[..1]) {
            kept.update(scene, &control).unwrap();
            let kept = kept.render(&view, &control).unwrap().frame;
            assert!(kept == draw(&renderer, scene, &view).frame, "{format:?} {name}");
        }
    }
}

#[test]
fn luminance_is_no_colour() {
    let scene = colored_scene(Filter::Trilinear);
    let renderer = TextureSlicer { format: Format::LuminanceAlpha, ..TextureSlicer::default() };
    match renderer.supports(&scene, None) {
        Err(RenderError::Unsupported(unsupported)) => assert_eq!(unsupported.feature, Feature::Color),
        other => panic!("{other:?}"),
    }
}
