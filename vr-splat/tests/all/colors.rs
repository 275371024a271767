//! Grids whose voxels have colours: against the renderer's own model, and against the reference.

use vr_core::*;
use vr_physics::Metrics;
use vr_physics::check::pictures::*;
use vr_splat::{Buffers, Shape, SplatKernel, Splatter};

const VIEWS: [(f64, f64, Option<f64>); 2] = [(33.0, 21.0, None), (-60.0, 50.0, Some(35.0))];

#[test]
fn pictures_are_what_the_model_sums() {
    for filter in Filter::ALL {
        for (name, scene) in looks_of_bytes(&colored_scene(filter)) {
            for buffers in [Buffers::Image, Buffers::Axis, Buffers::Samples] {
                for classification in [Classification::Post, Classification::Pre] {
                    let renderer = Splatter { buffers, classification, termination: 1.0, ..Splatter::default() };
                    let (azimuth, elevation, fov) = VIEWS[usize::from(filter == Filter::Trilinear)];
                    let view = view(&scene, azimuth, elevation, fov, 12);
                    if renderer.supports(&scene, Some(&view)).is_err() {
                        assert_eq!(filter, Filter::BSpline, "{buffers:?} {classification:?}");
                        continue;
                    }
                    let m = error_of_model(&renderer, &scene, &view);
                    println!("{filter} {name} {buffers:?} {classification:?}: {m}");
                    // Tables and rounding. A ray may just meet the box of a voxel, or just not.
                    let max = if filter == Filter::Nearest { 2e-2 } else { 1e-3 };
                    assert!(m.rmse < 1e-4 && m.max < max, "{filter} {name} {buffers:?} {classification:?}: {m}");
                }
            }
        }
    }
}

#[test]
fn sheets_converge_to_the_reference() {
    for filter in [Filter::Trilinear, Filter::CatmullRom, Filter::Nearest] {
        for (name, scene) in looks_of_bytes(&colored_scene(filter)) {
            for (azimuth, elevation, fov) in VIEWS {
                let view = view(&scene, azimuth, elevation, fov, 16);
                let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
                let errors = [0.5, 0.125].map(|slice_spacing| {
                    let renderer = Splatter { slice_spacing, termination: 1.0, ..Splatter::default() };
                    Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels()).rmse
                });
                println!("{filter} {name} {azimuth}: {errors:?}");
                // The square of a quarter is a sixteenth; where colours jump a sheet is off by its thickness.
                let least = if filter == Filter::Nearest { 2.0 } else { 8.0 };
                assert!(errors[1] < 3e-3 && errors[1] < errors[0] / least + 2e-5, "{filter} {name}: {errors:?}");
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
    for filter in [Filter::Trilinear, Filter::Gaussian] {
        for (compositing, most) in operators {
            let scene = Scene { compositing, ..colored_scene(filter) };
            let view = view(&scene, 33.0, 21.0, None, 16);
            let m = error(&Splatter { slice_spacing: 0.1, ..Splatter::default() }, &scene, &view);
            println!("{filter} {}: {m}", compositing.name());
            // A smooth extreme's place is known to a sheet, and the colour changes by a tenth on that.
            assert!(m.rmse < most, "{filter} {}: {m}", compositing.name());
        }
    }
    // Samples on their own have the mean of the ray's places.
    let scene = Scene { compositing: Compositing::Average, ..colored_scene(Filter::Trilinear) };
    let view = view(&scene, 33.0, 21.0, None, 16);
    for buffers in [Buffers::Samples, Buffers::Axis] {
        let m = error(&Splatter { buffers, ..Splatter::default() }, &scene, &view);
        println!("{buffers:?}: {m}");
        assert!(m.rmse < 3e-2, "{buffers:?}: {m}");
    }
}

/// White voxels leave what is drawn of values as it is without them.
#[test]
fn white_is_no_colour() {
    let [grid, white] = plain_and_white(&colored_scene(Filter::Trilinear));
    for shape in [Shape::Bilinear, Shape::Gaussian] {
        let renderer = Splatter { kernel: SplatKernel::new(shape), ..Splatter::default() };
        for (name, scene) in looks_of_bytes(&grid) {
            let white = Scene { volume: white.volume.clone(), ..scene.clone() };
            let view = view(&scene, 33.0, 21.0, None, 16);
            let [a, b] = [&scene, &white].map(|scene| draw(&renderer, scene, &view).frame);
            assert_eq!(a.pixels(), b.pixels(), "{shape:?} {name}");
        }
    }
}
