//! Depths, against the reference's.

use vr_core::phantom::{point_transfer_function, points_by_name};
use vr_core::*;
use vr_physics::Reference;
use vr_physics::check::pictures::*;
use vr_splat::{Buffers, CompositingOrder, Splatter};

/// Depths of the reference and of a renderer.
fn depths(renderer: &Splatter, scene: &Scene, view: &View) -> Vec<[f64; 2]> {
    let solution = Reference::new(1e-7).solve(scene, view, &Model::Canonical, &Control::default()).expect("solvable");
    let frame = draw(renderer, scene, view).frame;
    let found = frame.depth().expect("depths").iter().map(|&d| f64::from(d));
    solution.pixels.iter().map(|p| p.depth).zip(found).map(|(a, b)| [a, b]).collect()
}

/// Returns the median error where both see something, and the share of pixels in which only one does.
fn compare(depths: &[[f64; 2]]) -> (f64, f64) {
    let mut errors: Vec<f64> =
        depths.iter().filter(|d| d.iter().all(|x| x.is_finite())).map(|[a, b]| (a - b).abs()).collect();
    let alone = depths.iter().filter(|[a, b]| a.is_finite() != b.is_finite()).count();
    errors.sort_by(f64::total_cmp);
    assert!(errors.len() > depths.len() / 32, "only {} pixels have a depth", errors.len());
    (errors[errors.len() / 2], alone as f64 / depths.len() as f64)
}

/// Returns the scene with a multiple of its density.
fn dense(scene: Scene, times: f64) -> Scene {
    let before = &scene.transfer;
    let transfer = TransferFunction::new(before.points().to_vec(), before.rule(), before.unit_distance() / times);
    Scene { transfer: transfer.expect("as before").into(), ..scene }
}

fn cloud(name: &str, count: usize, opacity: f64) -> Scene {
    let (points, unit) = point_transfer_function(name).expect("a known phantom");
    let transfer = TransferFunction::new(points, OpacityRule::Power, unit / opacity).expect("valid points");
    Scene::new(points_by_name(name, count).expect("a known phantom").into(), transfer)
}

#[test]
fn depths_come_to_those_of_the_reference() {
    let scenes = [
        ("hydrogen", dense(phantom_scene::<f32>("hydrogen", 24, 1.0), 20.0)),
        ("turbulence", cloud("turbulence", 300, 20.0)),
    ];
    let operators = [
        Compositing::Over,
        Compositing::Accumulate { level: 0.7 },
        Compositing::Maximum,
        Compositing::Minimum,
        Compositing::First { threshold: 1.0 },
    ];
    for (name, scene) in scenes {
        for compositing in operators {
            // The smallest value of points is 0, where a support begins and where it ends.
            if compositing == Compositing::Minimum && scene.volume.points().is_some() {
                continue;
            }
            let threshold = |c: Compositing| match c {
                Compositing::First { .. } => {
                    let (low, high) = scene.volume.value_range().expect("a range");
                    Compositing::First { threshold: low + 0.1 * (high - low) }
                }
                other => other,
            };
            let scene = Scene { compositing: threshold(compositing), ..scene.clone() };
            let unit = match &scene.volume {
                Volume::Grid(grid) => grid.placement().spacing().min_element(),
                other => other.points().expect("points").mean_spacing(),
            };
            for (azimuth, elevation, fov) in [(33.0, 21.0, None), (-60.0, 50.0, Some(35.0))] {
                let view = view(&scene, azimuth, elevation, fov, 24);
                let of = |slice_spacing: f64| {
                    let renderer = Splatter { slice_spacing, termination: 1.0, ..Splatter::default() };
                    let (error, alone) = compare(&depths(&renderer, &scene, &view));
                    [error / unit, alone]
                };
                let [[a, _], [b, alone]] = [1.0, 0.125].map(of);
                println!("{name} {} {azimuth}: {a:.1e}, {b:.1e} units; {alone:.3} alone", compositing.name());
                // An extreme is placed in the middle of its sheet; other depths are as exact as the values.
                let bound = if scene.compositing.integrates_light() { 0.02 } else { 0.07 };
                assert!(b < bound && alone < 0.02, "{name} {} {azimuth}: {b} {alone}", compositing.name());
            }
        }
    }
}

#[test]
fn a_mean_is_nowhere_and_back_to_front_nothing_is_known() {
    let scene = phantom_scene::<u8>("hydrogen", 12, 1.0);
    let view = view(&scene, 33.0, 21.0, None, 8);
    let mean = Scene { compositing: Compositing::Average, ..scene.clone() };
    let frame = draw(&Splatter::default(), &mean, &view).frame;
    assert!(frame.depth().unwrap().iter().all(|d| *d == f32::INFINITY));
    let backwards = Splatter { buffers: Buffers::Axis, order: CompositingOrder::BackToFront, ..Splatter::default() };
    assert!(draw(&backwards, &scene, &view).frame.depth().is_none());
}

#[test]
fn own_sheets_and_samples_have_depths_to_a_voxel() {
    let scene = dense(phantom_scene::<f32>("hydrogen", 24, 1.0), 20.0);
    let unit = scene.volume.grid().unwrap().placement().spacing().min_element();
    let view = view(&scene, 33.0, 21.0, None, 24);
    for buffers in [Buffers::Axis, Buffers::Samples] {
        let renderer = Splatter { buffers, termination: 1.0, ..Splatter::default() };
        let (error, alone) = compare(&depths(&renderer, &scene, &view));
        println!("{buffers:?}: {:.2} voxels, {alone:.3} alone", error / unit);
        assert!(error < 1.5 * unit && alone < 0.1, "{buffers:?}: {error} {alone}");
    }
}
