//! Grids whose voxels have colours: against the renderer's own model, and against the reference.

use vr_core::*;
use vr_physics::Metrics;
use vr_physics::check::pictures::*;
use vr_shearwarp::{EmptySpace, ShearWarp};

use crate::both_errors::both_errors;

/// The largest difference of any component of two pictures.
fn largest_difference([a, b]: &[Frame; 2]) -> f32 {
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

const VIEWS: [(f64, f64, Option<f64>); 2] = [(33.0, 21.0, None), (-60.0, 50.0, Some(35.0))];

fn errors_fall_with_the_texel_under(filter: Filter) {
    for (name, scene) in looks_of_bytes(&colored_scene(filter)) {
        for (azimuth, elevation, fov) in VIEWS {
            let view = view(&scene, azimuth, elevation, fov, 24);
            let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
            for classification in [Classification::Post, Classification::Pre] {
                let errors = [0.5, 0.125].map(|texel| {
                    let renderer = ShearWarp { texel, termination: 1.0, classification, ..ShearWarp::default() };
                    both_errors(&renderer, &scene, &view, &truth)
                });
                println!("{filter} {classification:?} {name} {azimuth}: {errors:?}");
                // Faces of the box that can be seen, and jumps, are as soft as texels: half an order. Codes and tables leave 10⁻⁴.
                let [[coarse, coarse_of_model], [fine, fine_of_model]] = errors;
                let least = 1.7;
                assert!(fine_of_model < coarse_of_model / least + 1e-4, "{filter} {name} {azimuth}: {errors:?}");
                // Voxels that are classified first keep an error of their own.
                if classification == Classification::Post {
                    assert!(fine < coarse / least + 1e-4, "{filter} {name} {azimuth}: {errors:?}");
                }
            }
        }
    }
}

#[test]
fn errors_fall_with_the_texel_under_the_trilinear_filter() {
    errors_fall_with_the_texel_under(Filter::Trilinear);
}

#[test]
fn errors_fall_with_the_texel_under_the_nearest_filter() {
    errors_fall_with_the_texel_under(Filter::Nearest);
}

#[test]
fn every_operator_has_the_colour_of_the_place() {
    let operators = [
        Compositing::Maximum,
        Compositing::Minimum,
        Compositing::Average,
        Compositing::First { threshold: 150.0 },
        Compositing::Accumulate { level: 0.5 },
    ];
    for compositing in operators {
        let scene = Scene { compositing, ..colored_scene(Filter::Trilinear) };
        for (azimuth, elevation, fov) in VIEWS {
            let view = view(&scene, azimuth, elevation, fov, 24);
            let truth = solve(&scene, &view, &Model::Canonical, 1e-7);
            let errors = [0.5, 0.0625].map(|texel| {
                let renderer = ShearWarp { texel, ..ShearWarp::default() };
                Metrics::of(&truth, draw(&renderer, &scene, &view).frame.pixels()).rmse
            });
            println!("{} {azimuth}: {errors:?}", compositing.name());
            // Outlines, and the places of extremes.
            assert!(errors[1] < errors[0] / 2.0 && errors[1] < 4e-2, "{} {azimuth}: {errors:?}", compositing.name());
        }
    }
}

/// Runs or blocks, the same voxels have the same colours.
#[test]
fn either_encoding_has_the_same_picture() {
    for (name, scene) in looks_of_bytes(&colored_scene(Filter::Trilinear)) {
        for (azimuth, elevation, fov) in VIEWS {
            let view = view(&scene, azimuth, elevation, fov, 24);
            let off = largest_difference(
                &[EmptySpace::Runs, EmptySpace::Octree]
                    .map(|empty_space| draw(&ShearWarp { empty_space, ..ShearWarp::default() }, &scene, &view).frame),
            );
            assert!(off < 1e-5, "{name} {azimuth}: {off}");
        }
    }
}

#[test]
fn white_is_no_colour() {
    let scenes = plain_and_white(&colored_scene(Filter::Trilinear));
    for compositing in [Compositing::Over, Compositing::Average, Compositing::Maximum] {
        let view = view(&scenes[0], 33.0, 21.0, None, 24);
        let frames = scenes
            .each_ref()
            .map(|scene| draw(&ShearWarp::default(), &Scene { compositing, ..scene.clone() }, &view).frame);
        let off = largest_difference(&frames);
        // Optical depths in the place of opacities, and sums of sixteenths of white.
        assert!(off < 1e-5, "{}: {off}", compositing.name());
    }
}
