//! Comparison of packets through grids with labels with the plain engine.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use proptest::prelude::*;
use vr_core::labels::{LabelMap, LabelStyle, LabelledGrid};
use vr_core::{
    AnyGrid, Calibration, Control, Counts, Filter, GradientMethod, GridVolume, Placement, Scene, Shading, UniformGrid,
    View, Volume,
};

use crate::caster::{CompositingOrder, EmptySpace, RayCaster, Step};
use crate::engine::Engine;
use crate::packet::compared::{bits, plain, row_by_row, same};
use crate::packet::random_scenes::{factors, scenes, sums};
use crate::prepared::PreparedCaster;
use crate::tracer::RaySample;

/// Largest difference of the engines: the plain one classifies exactly, and a table of 4096 entries over twice the range of the voxels (as far as cubics leave it) leaves
/// 10⁻⁴ of the extinction where opacity rises to 0.9 within a tenth of that range.
const TWO_ENGINES: f32 = 4e-4;

/// Largest difference of shaded pictures: the direction of a small gradient is set by rounding, and so is what a surface there reflects.
const TWO_SHADINGS: f32 = 5e-3;

/// Labels 0 to 4 in blocks, at the voxels of a grid or on a lattice of their own, twice as coarse and turned, that may leave corners of the grid without any.
fn labels(volume: &GridVolume, seed: u64, is_own: bool) -> LabelMap {
    let (dims, placement) = if is_own {
        let (low, high) = volume.bounds();
        let middle = 0.5 * (low + high);
        let axes = DMat3::from_rotation_z(0.4) * DMat3::from_diagonal((high - low) * 0.11);
        ([9, 10, 9], Placement::new(middle - axes * DVec3::splat(4.1), axes).unwrap())
    } else {
        (volume.dims(), *volume.placement())
    };
    let label = |i: usize| {
        let at = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
        let block = at.iter().fold(seed, |hash, &k| (hash ^ (k / 3) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        ((block >> 40) % 5) as u8
    };
    let voxels: Vec<u8> = (0..dims.iter().product()).map(label).collect();
    LabelMap::new(&AnyGrid::from(UniformGrid::new(dims, voxels, placement, Calibration::default()).unwrap())).unwrap()
}

/// A scene whose grid has labels in styles of every kind; solid ones not beside emission.
fn labelled(scene: Scene, filter: Filter, gradient: GradientMethod, seed: u64, is_own: bool) -> Option<Scene> {
    let volume = Volume::clone(&scene.volume).with_filter(filter);
    let grid = Arc::clone(volume.grid()?);
    let map = Arc::new(labels(&grid, seed, is_own));
    let color = [0.9, 0.1, 0.3];
    let style = |label| match label {
        1 => LabelStyle::Hidden,
        2 => LabelStyle::Tinted { color, opacity: 0.6 },
        3 if scene.transfer.has_emission() => LabelStyle::Tinted { color: [0.2, 1.0, 0.1], opacity: 1.0 },
        3 => LabelStyle::Solid { color: [0.2, 1.0, 0.1], opacity: 0.4 },
        4 => LabelStyle::Volume { opacity: 0.3 },
        _ => LabelStyle::VOLUME,
    };
    let field = LabelledGrid::new(grid, map, style).ok()?.with_gradient(gradient);
    let transfer = Arc::new(field.transfer(&scene.transfer).ok()?);
    Some(Scene { volume: Volume::Field(Arc::new(field)), transfer, ..scene })
}

fn drawn(caster: &RayCaster, scene: &Scene, view: &View) -> Option<(Vec<RaySample>, Counts)> {
    let control = Control::default();
    let prepared = PreparedCaster::new(caster.clone(), scene, &control).unwrap();
    if !matches!(prepared.engine, Engine::Labels(..)) {
        return None;
    }
    let layer = scene.layer(view, &control).unwrap();
    let tracer = prepared.tracer((view, layer.as_ref())).unwrap();
    let (mut values, mut counts) = (Vec::new(), Counts::default());
    tracer.trace(&row_by_row(view), None, &mut values, &mut counts);
    // No bit depends on company.
    let mut alone = Vec::new();
    for spot in row_by_row(view) {
        tracer.trace(&[spot], None, &mut alone, &mut Counts::default());
    }
    assert_eq!(bits(&values), bits(&alone));
    Some((values, counts))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 192, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn draws_what_the_plain_engine_draws((scene, view) in scenes(0.9), step in 0.1f64..2.5, filter in prop::sample::select(Filter::ALL.to_vec()), seed in any::<u64>(), is_own in any::<bool>(), compositing in sums()) {
        let scene = Scene { compositing, ..scene };
        let Some(scene) = labelled(scene, filter, GradientMethod::default(), seed, is_own) else { return Ok(()) };
        let caster = RayCaster { step: Step::Uniform(step), order: CompositingOrder::WHOLE_RAY, ..RayCaster::default() };
        let Some((values, counts)) = drawn(&caster, &scene, &view) else { return Ok(()) };
        same(&values, &plain(&caster, &scene, &view), TWO_ENGINES)?;
        // What is leaped over changes no bit.
        let all = RayCaster { empty_space: EmptySpace::None, ..caster };
        let (every, all_counts) = drawn(&all, &scene, &view).expect("packets draw it");
        prop_assert_eq!(bits(&values), bits(&every));
        prop_assert!(counts.samples <= all_counts.samples);
    }

    #[test]
    fn shades_as_the_plain_engine_shades((scene, view) in scenes(0.9), step in 0.1f64..2.5, filter in prop::sample::select(Filter::ALL.to_vec()), analytic in any::<bool>(), seed in any::<u64>(), is_own in any::<bool>(), gradient_opacity in factors(), compositing in sums()) {
        let gradient = if analytic { GradientMethod::Analytic } else { GradientMethod::CentralDifferences };
        let shading = Some(Arc::new(Shading { gradient, gradient_opacity, ..Shading::default() }));
        let scene = Scene { compositing, shading, ..scene };
        let Some(scene) = labelled(scene, filter, gradient, seed, is_own) else { return Ok(()) };
        let caster = RayCaster { step: Step::Uniform(step), order: CompositingOrder::WHOLE_RAY, ..RayCaster::default() };
        let Some((values, _)) = drawn(&caster, &scene, &view) else { return Ok(()) };
        same(&values, &plain(&caster, &scene, &view), TWO_SHADINGS)?;
    }
}

/// Packets draw scenes of labels at all.
#[test]
fn most_scenes_are_drawn_by_packets() {
    use proptest::strategy::ValueTree;
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let (mut taken, mut all) = (0, 0);
    for seed in 0..40 {
        let (scene, view) = scenes(0.9).new_tree(&mut runner).unwrap().current();
        let Some(scene) = labelled(scene, Filter::Trilinear, GradientMethod::default(), seed, seed % 2 == 0) else {
            continue;
        };
        all += 1;
        taken += usize::from(drawn(&RayCaster::uniform(0.5), &scene, &view).is_some());
    }
    // Some grids have holes, and in some the bands end beside a control point.
    assert!(all >= 30 && 2 * taken > all, "{taken} of {all}");
}
