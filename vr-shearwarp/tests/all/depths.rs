//! Depths of what is seen, against the reference's.

use vr_core::*;
use vr_physics::Reference;
use vr_physics::check::pictures::*;
use vr_shearwarp::{ShearWarp, WarpFilter};

const VIEWS: [(f64, f64, Option<f64>); 3] = [(0.0, 0.0, None), (33.0, 21.0, None), (-60.0, 50.0, Some(35.0))];

/// Depths of the reference and of a renderer, pixel by pixel.
fn depths(renderer: &ShearWarp, scene: &Scene, view: &View) -> Vec<[f64; 2]> {
    let solution = Reference::new(1e-7).solve(scene, view, &Model::Canonical, &Control::default()).expect("solvable");
    let frame = draw(renderer, scene, view).frame;
    let found = frame.depth().expect("depths").iter().map(|&d| f64::from(d));
    solution.pixels.iter().map(|p| p.depth).zip(found).map(|(a, b)| [a, b]).collect()
}

/// Median and ninth decile of the errors where both see something, in voxels, and the share of pixels in which only one does.
fn compare(scene: &Scene, depths: &[[f64; 2]]) -> [f64; 3] {
    let voxel = scene.volume.mean_spacing();
    let mut errors: Vec<f64> =
        depths.iter().filter(|d| d.iter().all(|x| x.is_finite())).map(|[a, b]| (a - b).abs() / voxel).collect();
    let alone = depths.iter().filter(|[a, b]| a.is_finite() != b.is_finite()).count();
    errors.sort_by(f64::total_cmp);
    assert!(errors.len() > depths.len() / 32, "only {} pixels have a depth", errors.len());
    [errors[errors.len() / 2], errors[errors.len() * 9 / 10], alone as f64 / depths.len() as f64]
}

/// A renderer whose texels are so many voxels wide, its slices half of that apart.
fn fine(texel: f64, classification: Classification) -> ShearWarp {
    ShearWarp { texel, classification, termination: 1.0, ..ShearWarp::default() }
}

#[test]
fn light_is_half_gone_where_the_reference_has_it() {
    for classification in [Classification::Post, Classification::Pre] {
        for compositing in [Compositing::Over, Compositing::Accumulate { level: 0.7 }] {
            let scene = Scene { compositing, ..phantom_scene::<f32>("fog", 24, 3.0) };
            for (azimuth, elevation, fov) in VIEWS {
                let view = view(&scene, azimuth, elevation, fov, 24);
                let of = |texel| compare(&scene, &depths(&fine(texel, classification), &scene, &view));
                let [coarse, fine] = [1.0, 0.125].map(of);
                println!("{classification:?} {compositing:?} {azimuth}: {coarse:.4?}, {fine:.4?} voxels");
                // Voxels that are classified before they are interpolated are another medium, however fine the texels.
                let bound = if classification == Classification::Pre { [0.02, 0.1] } else { [2e-3, 1e-2] };
                assert!(fine[0] < bound[0] && fine[1] < bound[1] && fine[2] < 0.02, "{fine:?}");
                // Second order is a factor of 64 over three halvings; voxels have kinks.
                assert!(classification == Classification::Pre || fine[0] < coarse[0] / 12.0, "{coarse:?} {fine:?}");
            }
        }
    }
}

#[test]
fn every_filter_and_subpixel_has_depths() {
    let scene = phantom_scene::<u8>("fog", 24, 3.0);
    let view = View { supersampling: 2, ..view(&scene, 33.0, 21.0, Some(30.0), 24) };
    let renderer = ShearWarp { warp: WarpFilter::Cubic, ..fine(0.25, Classification::Post) };
    let [half, most, alone] = compare(&scene, &depths(&renderer, &scene, &view));
    println!("{half:.1e} {most:.1e} {alone:.3}");
    assert!(half < 0.02 && most < 0.2 && alone < 0.04, "{half} {most} {alone}");
}

#[test]
fn a_mean_and_a_level_below_a_half_have_no_place() {
    let scene = phantom_scene::<u8>("fog", 12, 9.0);
    let view = view(&scene, 33.0, 21.0, None, 12);
    let nowhere = |renderer: &ShearWarp, scene: &Scene| {
        draw(renderer, scene, &view).frame.depth().unwrap().iter().all(|&d| d == f32::INFINITY)
    };
    let cut = Scene { compositing: Compositing::Accumulate { level: 0.4 }, ..scene.clone() };
    assert!(nowhere(&ShearWarp::default(), &cut) && !nowhere(&ShearWarp::default(), &scene));
    let mean = Scene { compositing: Compositing::Average, ..scene.clone() };
    assert!(nowhere(&ShearWarp::default(), &mean));
}

#[test]
fn extremes_are_where_they_are() {
    for compositing in [Compositing::Maximum, Compositing::Minimum] {
        for (azimuth, elevation, fov) in VIEWS {
            let scene = Scene { compositing, ..phantom_scene::<f32>("fog", 24, 1.0) };
            let view = view(&scene, azimuth, elevation, fov, 24);
            let of = |texel| {
                let renderer = ShearWarp { texel, ..ShearWarp::default() };
                compare(&scene, &depths(&renderer, &scene, &view))
            };
            let [coarse, fine] = [1.0, 0.125].map(of);
            println!("{compositing:?} {azimuth}: {coarse:.4?}, {fine:.4?} voxels");
            // The sample that was picked is half of a sixteenth of a voxel away on average; along flat stretches one farther away may be the largest.
            assert!(fine[0] < 0.1 && fine[1] < 0.3 && fine[2] < 0.03, "{fine:?}");
        }
    }
}
