//! Comparison of packets through scattered points with the plain engine.

use std::sync::Arc;

use glam::DVec3;
use proptest::prelude::*;
use vr_core::{
    Camera, Compositing, Control, ControlPoint, OpacityRule, PointKernel, PointMixing, PointSet, Rendered, Scene,
    Shading, TransferFunction, View, phantom,
};

use crate::caster::{CompositingOrder, RayCaster, Rule, Step};
use crate::engine::Engine;
use crate::packet::compared::{bits, plain, row_by_row, same, same_picks};
use crate::packet::random_scenes::{factors, picks, row_transfers, sums, transfers};
use crate::prepared::PreparedCaster;
use crate::tracer::RaySample;

/// Largest difference of the engines: sums of a few dozen kernels in f32, and positions in f32.
const TWO_ENGINES: f32 = 1e-4;

/// Part of a set's extent by which positions in f32 may be off. Means turn within little of the edges of supports, and pixels with them.
const MISPLACED: f64 = 4e-6;

/// Largest difference of shaded pictures: the direction of a small gradient is set by rounding, and so is what a surface there reflects.
const TWO_SHADINGS: f32 = 5e-3;

/// Clustered in place and radius, of values between 0 and 1, as far from the origin as 1000 radii.
fn sets() -> impl Strategy<Value = PointSet> {
    let place = prop::array::uniform3((-1.0f64..1.0).prop_map(|x| x * x.abs()));
    let one = (place, 0.1f32..0.5, 0.0f32..1.0);
    let kernel = prop::sample::select(PointKernel::ALL.to_vec());
    let mixing = prop::sample::select(PointMixing::ALL.to_vec());
    let far = prop_oneof![Just(0.0), Just(300.0)];
    (prop::collection::vec(one, 1..80), far, kernel, mixing, any::<bool>()).prop_map(
        |(all, far, kernel, mixing, colored)| {
            let positions = all.iter().map(|p| DVec3::from(p.0) + far).collect();
            let radii: Vec<f32> = all.iter().map(|p| p.1).collect();
            // All of them together make no more than twice the range of the transfer functions, wherever they lie.
            let share = 2.0 / all.len().max(2) as f32 / kernel.at(0.0) as f32;
            let weights = radii.iter().map(|r| share * r.powi(3)).collect();
            let values = all.iter().map(|p| p.2).collect();
            let points = PointSet::new(positions, radii, weights, values, kernel).unwrap().with_mixing(mixing).unwrap();
            if !colored {
                return points;
            }
            let color = |k: usize| [k * 7 % 11, k * 5 % 11, k * 3 % 11].map(|c| c as f32 / 10.0);
            let colors = (0..points.count()).map(color).collect();
            points.with_colors(colors).unwrap()
        },
    )
}

fn drawn(caster: &RayCaster, scene: &Scene, view: &View) -> Option<Vec<RaySample>> {
    let control = Control::default();
    let prepared = PreparedCaster::new(caster.clone(), scene, &control).unwrap();
    if !matches!(prepared.engine, Engine::Points(..) | Engine::PointPicks(..)) {
        return None;
    }
    let layer = scene.layer(view, &control).unwrap();
    let mut values = Vec::new();
    let tracer = prepared.tracer((view, layer.as_ref())).unwrap();
    tracer.trace(&row_by_row(view), None, &mut values, &mut vr_core::Counts::default());
    // No bit depends on company.
    let mut alone = Vec::new();
    for spot in row_by_row(view) {
        tracer.trace(&[spot], None, &mut alone, &mut vr_core::Counts::default());
    }
    assert_eq!(bits(&values), bits(&alone));
    Some(values)
}

/// Largest change of a pixel of the plain engine as a view moves by as much as positions may be off, both ways along each axis together.
fn turned_by_moving(caster: &RayCaster, scene: &Scene, view: &View, picture: &Rendered) -> f32 {
    let (low, high) = scene.volume.bounds();
    let far = MISPLACED * (high - low).max_element();
    let mut turned = vec![0.0f32; picture.frame.pixels().len()];
    for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z] {
        let Camera { eye, target, .. } = view.camera;
        let camera = Camera { eye: eye + far * axis, target: target + far * axis, ..view.camera };
        let moved = plain(caster, scene, &View { camera, ..view.clone() }).frame;
        for ((turned, a), b) in turned.iter_mut().zip(moved.pixels()).zip(picture.frame.pixels()) {
            *turned += (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
        }
    }
    turned.into_iter().fold(0.0, f32::max)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn draws_what_the_plain_engine_draws(points in sets(), transfer in transfers(0.9), angles in (-180.0f64..180.0, -80.0f64..80.0, prop::option::of(20.0f64..90.0)), size in (1u32..13, 1u32..10), step in 0.2f64..2.5, left in any::<bool>(), shade in any::<bool>(), gradient_opacity in factors(), rows in prop::option::weighted(0.3, row_transfers(0.9)), compositing in sums()) {
        let gradient_opacity = if rows.is_some() { Vec::new() } else { gradient_opacity };
        let shading = shade.then(|| Arc::new(Shading { gradient_opacity, ..Shading::default() }));
        let shade = shade || rows.is_some();
        let turns = points.mixing() == PointMixing::Mean;
        let scene = Scene { compositing, shading, ..Scene::new(points.into(), rows.unwrap_or(transfer)) };
        let view = View::new(Camera::framing(scene.volume.bounds(), angles.0, angles.1, angles.2), [size.0, size.1]);
        let rule = if left { Rule::Left } else { Rule::Midpoint };
        let caster = RayCaster { step: Step::Uniform(step), rule, order: CompositingOrder::WHOLE_RAY, ..RayCaster::default() };
        let values = drawn(&caster, &scene, &view);
        // A ramp narrower than what f32 tells apart.
        let Some(values) = values else { return Ok(()) };
        let tolerance = if shade { TWO_SHADINGS } else { TWO_ENGINES };
        let want = plain(&caster, &scene, &view);
        let room = if turns { turned_by_moving(&caster, &scene, &view, &want) } else { 0.0 };
        same(&values, &want, tolerance + room)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn picks_what_the_plain_engine_picks(points in sets(), compositing in picks(), angles in (-180.0f64..180.0, -80.0f64..80.0, prop::option::of(20.0f64..90.0)), size in (1u32..13, 1u32..10), step in 0.2f64..2.5, left in any::<bool>(), shade in any::<bool>()) {
        let shading = shade.then(|| Arc::new(Shading::default()));
        let (turns, is_colored) = (points.mixing() == PointMixing::Mean, points.colors().is_some());
        let ramp = vec![ControlPoint::new(0.0, [0.0, 0.2, 1.0], 0.0), ControlPoint::new(1.0, [1.0, 0.7, 0.2], 1.0)];
        let ramp = TransferFunction::new(ramp, OpacityRule::Power, 1.0).unwrap();
        let scene = Scene { compositing, shading, ..Scene::new(points.into(), ramp) };
        let view = View::new(Camera::framing(scene.volume.bounds(), angles.0, angles.1, angles.2), [size.0, size.1]);
        let rule = if left { Rule::Left } else { Rule::Midpoint };
        let caster = RayCaster { rule, ..RayCaster::uniform(step) };
        let values = drawn(&caster, &scene, &view).expect("packets draw it");
        let want = plain(&caster, &scene, &view);
        let room = if turns { turned_by_moving(&caster, &scene, &view, &want) } else { 0.0 };
        let is_lit = shade && matches!(compositing, Compositing::First { .. });
        let tolerance = if is_lit { TWO_SHADINGS } else { TWO_ENGINES };
        // Rounding may choose between two samples as the extreme one, and their colours differ.
        let with_colors = !is_colored || matches!(compositing, Compositing::Average | Compositing::First { .. });
        same_picks(values.iter().map(|value| value.rgba), &want, (compositing, with_colors), tolerance + room)?;
    }
}

/// A cluster by its own transfer function, whose ramps are as wide as 0.45 and as 450.
#[test]
fn ramps_of_several_orders_of_magnitude_are_drawn() {
    let points = phantom::points_by_name("plummer", 500).unwrap();
    let (control_points, unit) = phantom::point_transfer_function("plummer").unwrap();
    let transfer = TransferFunction::new(control_points, OpacityRule::Power, unit).unwrap();
    let unshaded = Scene::new(points.into(), transfer);
    let shaded = Scene { shading: Some(Arc::new(Shading::default())), ..unshaded.clone() };
    let view = View::new(Camera::framing(unshaded.volume.bounds(), 33.0, 21.0, None), [24, 24]);
    let caster = RayCaster { order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.5) };
    for (scene, tolerance) in [(&unshaded, TWO_ENGINES), (&shaded, TWO_SHADINGS)] {
        let values = drawn(&caster, scene, &view).expect("packets draw it");
        same(&values, &plain(&caster, scene, &view), tolerance).unwrap();
    }
}
