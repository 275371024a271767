//! The reference's account of single rays.

use glam::DVec3;
use proptest::prelude::*;
use vr_core::field::Cut;
use vr_core::{
    Calibration, Camera, Compositing, Control, ControlPoint, Model, OpacityRule, Placement, Projection, Ray, Rays,
    Scene, TransferFunction, UniformGrid, View,
};
use vr_physics::check::TestScene;
use vr_physics::check::strategies::{scene, smooth_scene, tame_scene};
use vr_physics::{RaySegment, Reference};

/// The segments of the ray through a pixel's centre, and the pixel.
fn account(test: &TestScene, [x, y]: [u32; 2], cuts: &[f64]) -> (Vec<RaySegment>, vr_physics::Pixel) {
    let view = View { supersampling: 1, ..test.view.clone() };
    let ray = Rays::new(&view).unwrap().at(f64::from(x) + 0.5, f64::from(y) + 0.5);
    let reference = Reference::default();
    let segments = reference.segments(&test.scene, &view, &ray, cuts).unwrap();
    let pixel = reference.solve_pixels(&test.scene, &view, &Model::Canonical, &[[x, y]], &Control::default());
    (segments, pixel.unwrap().pixels[0])
}

/// Checks that the segments cover the ray and add up to the pixel.
fn holds(test: &TestScene, at: [f64; 2], parts: usize) -> Result<(), TestCaseError> {
    let pixel = [0, 1].map(|a| (at[a] * f64::from(test.view.size[a])) as u32);
    let (whole, truth) = account(test, pixel, &[]);
    if whole.is_empty() {
        prop_assert_eq!(truth.rgba, [0.0; 4]);
        return Ok(());
    }
    let (from, to) = (whole[0].from, whole[whole.len() - 1].to);
    let cuts: Vec<f64> = (0..=parts).map(|k| from + (to - from) * k as f64 / parts as f64).collect();
    for segments in [whole, account(test, pixel, &cuts).0] {
        prop_assert!(segments[0].front.contains(&Cut::Entry));
        prop_assert!(segments.windows(2).all(|w| w[0].to == w[1].from), "a gap");
        prop_assert!(segments.iter().all(|s| s.from < s.to && !s.front.is_empty()), "nothing");
        prop_assert_eq!(segments[segments.len() - 1].to, to);
        if !test.scene.compositing.integrates_light() {
            prop_assert!(segments.iter().all(|s| s.light.is_none()), "light");
            continue;
        }
        let light = segments[segments.len() - 1].light.unwrap();
        let [r, g, b] = light.radiance;
        let sum = [r, g, b, light.opacity()];
        let allowed = light.running.value() + truth.certainty.value();
        for c in 0..4 {
            prop_assert!((sum[c] - truth.rgba[c]).abs() <= allowed, "{sum:?} {truth:?} {allowed}");
        }
        // Their own light, composited, is the same again.
        let (mut again, mut clear) = ([0.0; 3], 1.0);
        for own in segments.iter().map(|s| s.light.unwrap()) {
            for c in 0..3 {
                again[c] += clear * own.light[c];
            }
            clear *= own.transparency;
        }
        if test.scene.compositing == Compositing::Over {
            let rounding = 1e-13 * segments.len() as f64 * (1.0 + again[0].max(again[1]).max(again[2]));
            for c in 0..3 {
                prop_assert!((again[c] - sum[c]).abs() <= rounding, "{again:?} {sum:?}");
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn of_any_scene_they_add_up(test in scene(), at in [0.0f64..1.0, 0.0f64..1.0], parts in 1usize..20) {
        holds(&test, at, parts)?;
    }

    #[test]
    fn of_a_tame_scene_they_add_up(test in tame_scene(), at in [0.0f64..1.0, 0.0f64..1.0], parts in 1usize..20) {
        holds(&test, at, parts)?;
    }

    #[test]
    fn of_a_tame_scene_the_bound_is_small(test in smooth_scene(), at in [0.2f64..0.8, 0.2f64..0.8]) {
        let pixel = [0, 1].map(|a| (at[a] * f64::from(test.view.size[a])) as u32);
        let (segments, _) = account(&test, pixel, &[]);
        if let Some(last) = segments.last() {
            let light = last.light.unwrap();
            prop_assert!(light.running.value() < 1e-9 * (1.0 + light.radiance[0]), "{:?}", light.running);
        }
    }
}

/// A ramp 0 to 4 along x, and the ray along it.
fn ramp(compositing: Compositing) -> (Scene, View, Ray) {
    let samples: Vec<f32> = (0..20).map(|i| (i % 5) as f32).collect();
    let placement = Placement::from_spacing([2.0, 1.0, 1.0]).unwrap();
    let grid = UniformGrid::new([5, 2, 2], samples, placement, Calibration::default()).unwrap();
    let point = |value, opacity| ControlPoint::new(value, [1.0, 0.5, 0.0], opacity);
    let points = vec![point(0.0, 0.0), point(1.5, 0.5), point(3.0, 0.5), point(3.0, 0.0)];
    let transfer = TransferFunction::new(points, OpacityRule::Extinction, 1.0).unwrap();
    let scene = Scene { compositing, ..Scene::new(grid.into(), transfer) };
    let eye = DVec3::new(-10.0, 0.5, 0.5);
    let projection = Projection::Orthographic { height: 1.0 };
    let view = View::new(Camera { eye, target: eye + DVec3::X, up: DVec3::Y, projection }, [1, 1]);
    let ray = Rays::new(&view).unwrap().at(0.5, 0.5);
    (scene, view, ray)
}

#[test]
fn a_ramp_is_cut_at_faces_knots_and_where_it_is_asked() {
    let (scene, view, ray) = ramp(Compositing::Over);
    let segments = Reference::default().segments(&scene, &view, &ray, &[5.0, 12.5, 16.0, 40.0]).unwrap();
    // Value v is at the distance 10 + 2v; a face wherever v is whole.
    let face = |at| Cut::Face { axis: 0, at };
    let knot = |value| Cut::Knot { value };
    let want = [
        (10.0, vec![Cut::Entry]),
        (12.0, vec![face(1.0)]),
        (12.5, vec![Cut::Asked]),
        (13.0, vec![knot(1.5)]),
        (14.0, vec![face(2.0)]),
        (16.0, vec![face(3.0), knot(3.0), Cut::Asked]),
    ];
    assert_eq!(segments.len(), want.len(), "{segments:#?}");
    for (segment, (from, front)) in segments.iter().zip(&want) {
        assert!((segment.from - from).abs() < 1e-12 && segment.front == *front, "{segment:#?}");
        assert!((segment.values[0] - 0.5 * (from - 10.0)).abs() < 1e-12, "{segment:#?}");
    }
    // κ = α: a ramp up to ½ over 3 units, then ½ over 3 units, then nothing.
    let depths = segments.iter().map(|s| s.light.unwrap().depth);
    for (depth, want) in depths.zip([1.0 / 3.0, 0.25 * 6.25 / 3.0, 0.75, 1.25, 2.25, 2.25]) {
        assert!((depth - want).abs() < 1e-12, "{depth} {want}");
    }
    let last = segments[5].light.unwrap();
    assert!((last.radiance[1] - 0.5 * (1.0 - f64::exp(-2.25))).abs() <= last.running.value());
    // But for the width of the jump's rounding.
    assert!(last.transparency > 1.0 - 1e-12 && last.light.iter().all(|b| *b < 1e-12), "{last:?}");
}

#[test]
fn a_level_ends_the_light_inside_a_segment_and_picks_have_none() {
    let level = 1.0 - f64::exp(-1.0);
    let (scene, view, ray) = ramp(Compositing::Accumulate { level });
    let segments = Reference::default().segments(&scene, &view, &ray, &[]).unwrap();
    let last = segments[segments.len() - 1].light.unwrap();
    assert!((last.depth - 1.0).abs() < 1e-12 && (last.radiance[0] - level).abs() < 1e-9, "{last:?}");
    let (scene, view, ray) = ramp(Compositing::Maximum);
    let segments = Reference::default().segments(&scene, &view, &ray, &[]).unwrap();
    assert!(segments.iter().all(|s| s.light.is_none()) && segments[segments.len() - 1].values[1] == 4.0);
    let beside = Ray { origin: ray.origin + DVec3::Y * 9.0, ..ray };
    assert!(Reference::default().segments(&scene, &view, &beside, &[11.0]).unwrap().is_empty());
}
