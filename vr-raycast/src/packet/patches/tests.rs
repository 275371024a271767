//! Comparison of packets through patches with the plain engine, and with themselves.

use std::sync::Arc;

use glam::DVec3;
use proptest::prelude::*;
use vr_core::amr::{AmrCentring, AmrGrid, AmrSampling};
use vr_core::image_order::ImageSample;
use vr_core::rectilinear::{Centering, RectilinearGrid};
use vr_core::{
    Camera, Clip, Compositing, Control, ControlPoint, Counts, GradientMethod, Light, OpacityRule, Plane, Scene,
    Shading, TransferFunction, View, Volume,
};
use vr_physics::check::FixedLayer;

use super::super::compared::{bits, plain, row_by_row, same, same_picks};
use super::super::random_scenes::{factors, picks, steps, sums};
use super::{PatchEngine, PatchFrame};
use crate::caster::{CompositingOrder, EmptySpace, RayCaster, Step};
use crate::engine::{Engine, lengths};
use crate::prepared::PreparedCaster;
use crate::source::Source;
use crate::tracer::{RaySample, Tracer};

/// Numbers from a seed, 0 to 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}

const RATIOS: [&[[u32; 3]]; 5] = [&[[2; 3], [2; 3]], &[[4; 3]], &[[3; 3], [2; 3]], &[[2, 1, 3], [1, 2, 2]], &[]];

/// A mesh that is refined here and there, of waves and a little noise; with holes or without.
fn mesh(seed: u64, ratios: &[[u32; 3]], cells: bool, holed: bool) -> Volume {
    let centring = if cells { AmrCentring::Cells } else { AmrCentring::Points };
    // Few blocks of several bricks, or more of them in which everything is near a rim: most of the work is to make the mesh.
    let (blocks, block_cells) = match (seed.is_multiple_of(2), ratios) {
        (true, _) => ([2, 1, 2], [12; 3]),
        (false, [[4, 4, 4]]) => ([3, 2, 3], [4; 3]),
        (false, _) => ([3, 2, 3], [6; 3]),
    };
    let sampling = AmrSampling {
        origin: DVec3::new(-1.0, 2.0, 0.5),
        edge: 1.5,
        blocks,
        block_cells,
        ratios: ratios.to_vec(),
        centring,
    };
    let random = std::cell::RefCell::new(Random(seed));
    let value = |p: DVec3| {
        let mut random = random.borrow_mut();
        let wave = 0.5 + 0.4 * (1.7 * p.x + seed as f64).sin() * (1.3 * p.y).cos() * (2.1 * p.z).sin();
        let value = wave + 0.02 * random.next();
        if holed && random.next() < 0.001 { f32::NAN } else { value as f32 }
    };
    let first = sampling.origin;
    let refine = |low: DVec3, _: DVec3, level: usize| {
        let [x, y, z] = ((low - first) * 16.0).round().to_array().map(|x| x as i64);
        let mix = (x * 73_856_093) ^ (y * 19_349_663) ^ (z * 83_492_791);
        low == first || Random(seed ^ mix as u64 ^ level as u64).next() < [0.4, 0.1][level.min(1)]
    };
    AmrGrid::refining(&sampling, value, refine).unwrap().into()
}

/// A rectilinear grid of the same, whose axes are even, graded and random by turns; with holes or without, with either gradient.
fn uneven(seed: u64, is_analytic: bool, holed: bool) -> Volume {
    let mut random = Random(seed);
    let axes: [Vec<f64>; 3] = std::array::from_fn(|_| {
        let (mut places, mut width) = (vec![random.next()], 0.2);
        for _ in 0..1 + (random.next() * 3.0) as usize {
            let (kind, cells) = ((random.next() * 3.0) as usize, 1 + (random.next() * 11.0) as usize);
            let ratio = 0.7 + 0.7 * random.next();
            for _ in 0..cells {
                let own = [width, width, width * (0.4 + 1.2 * random.next())][kind];
                places.push(places[places.len() - 1] + own);
                width = (if kind == 1 { ratio * width } else { width }).clamp(0.02, 0.5);
            }
        }
        places
    });
    let mut values = Vec::new();
    for &z in &axes[2] {
        for &y in &axes[1] {
            for &x in &axes[0] {
                let wave = 0.5 + 0.4 * (1.7 * x + seed as f64).sin() * (1.3 * y).cos() * (2.1 * z).sin();
                let value = wave + 0.02 * random.next();
                values.push(if holed && random.next() < 0.003 { f32::NAN } else { value as f32 });
            }
        }
    }
    let grid = RectilinearGrid::new(axes, values, Centering::Points).unwrap();
    let gradient = if is_analytic { GradientMethod::Analytic } else { GradientMethod::CentralDifferences };
    Volume::Rectilinear(Arc::new(grid.with_gradient(gradient)))
}

fn volumes() -> impl Strategy<Value = Volume> {
    let meshes = (0u64..1000, 0..RATIOS.len(), any::<bool>(), prop::bool::weighted(0.3))
        .prop_map(|(seed, ratios, cells, holed)| mesh(seed, RATIOS[ratios], cells, holed));
    let uneven = (any::<u64>(), any::<bool>(), prop::bool::weighted(0.3))
        .prop_map(|(seed, is_analytic, holed)| uneven(seed % 100_000, is_analytic, holed));
    prop_oneof![meshes, uneven]
}

/// True if a value of a volume is missing.
fn has_holes(volume: &Volume) -> bool {
    volume.amr().is_some_and(|grid| grid.missing_values() > 0)
        || volume.rectilinear().is_some_and(|grid| grid.lattice().vacuum_cells().is_some())
}

/// Clear below 0.3; its points lie on entries of the table, and its extinction is linear between them: the table has no error.
fn transfer(unit: f64, opacity: f64, emits: bool) -> TransferFunction {
    let points = [(0.25, 0.0), (0.375, 0.0), (0.5, opacity), (0.75, 0.3 * opacity), (1.0, opacity)];
    let points = points.map(|(value, opacity)| ControlPoint {
        emission: emits.then_some([opacity, 0.5 * opacity, 0.25]),
        ..ControlPoint::new(value, [1.0 - value, value, 0.5], opacity)
    });
    TransferFunction::new(points.to_vec(), OpacityRule::Extinction, unit).unwrap()
}

fn scenes() -> impl Strategy<Value = (Scene, View)> {
    let angles = (-180.0f64..180.0, -80.0f64..80.0, prop::option::of(20.0f64..90.0));
    let angles = prop_oneof![8 => angles, 1 => Just((90.0, 0.0, None)), 1 => Just((0.0, 0.0, Some(40.0)))];
    let looks = (0.5f64..2.0, 0.1f64..0.8, any::<bool>());
    (volumes(), looks, angles, [1u32..12, 1u32..9], 0u32..16, 0.0f64..1.0).prop_map(
        |(volume, (unit, opacity, emits), (azimuth, elevation, fov), size, cut, share)| {
            let scene = Scene::new(volume, transfer(unit, opacity, emits));
            let bounds = scene.volume.bounds();
            // In the very face of a hole, the two precisions may be on either side of it.
            let turned = if has_holes(&scene.volume) { 0.37 } else { 0.0 };
            let mut camera = Camera::framing(bounds, azimuth + turned, elevation + turned, fov);
            if cut & 1 == 1 {
                camera.eye = camera.target + (camera.eye - camera.target) * 0.05;
            }
            let mut view = View::new(camera, size);
            let extent = bounds.1 - bounds.0;
            let crop = (cut & 2 != 0).then(|| (bounds.0 + extent * 0.3 * share, bounds.1 - extent * 0.2));
            let normal = DVec3::new(1.0, -0.5, 0.3);
            let plane = Plane { normal, offset: normal.dot(camera.target) };
            view.clip = Clip { crop, planes: if cut & 4 != 0 { vec![plane] } else { Vec::new() } };
            if cut & 8 != 0 {
                let distance = (camera.target - camera.eye).length() as f32;
                let depth = |i: u32| distance * (0.8 + 0.1 * (i % 5) as f32);
                let pixel = |i: u32| ([0.1, 0.2, 0.3], if i.is_multiple_of(3) { f32::INFINITY } else { depth(i) });
                return (FixedLayer::new(&view, pixel).among(&scene), view);
            }
            (scene, view)
        },
    )
}

fn engine(caster: &RayCaster, scene: &Scene) -> PatchEngine {
    let source = Source::of(&scene.volume).unwrap();
    PatchEngine::new(caster, scene, &source, lengths(caster, scene, source.placement())).expect("it can draw this")
}

fn trace(engine: &PatchEngine, scene: &Scene, view: &View, spots: &[ImageSample]) -> (Vec<RaySample>, Counts) {
    let layer = scene.layer(view, &Control::default()).unwrap();
    let source = Source::of(&scene.volume).unwrap();
    let frame = PatchFrame::new(engine, &source, (view, layer.as_ref())).unwrap();
    let (mut values, mut counts) = (Vec::new(), Counts::default());
    frame.trace(spots, None, &mut values, &mut counts);
    (values, counts)
}

/// Opacity by the gradient.
#[derive(Clone, Debug)]
struct GradientLook {
    shaded: bool,
    /// Factors by the gradient's magnitude.
    factors: Vec<(f64, f64)>,
    /// Magnitudes at which the transfer function has a row of a tenth of its opacity, and one of all of it.
    rows: Option<[f64; 2]>,
}

impl GradientLook {
    /// The same scene, looked at like this.
    fn on(&self, scene: Scene) -> Scene {
        let Some(rows) = self.rows else {
            let shading = if self.shaded { Shading::default() } else { Shading::flat() };
            let shading = Shading { gradient_opacity: self.factors.clone(), ..shading };
            return Scene { shading: Some(Arc::new(shading)), ..scene };
        };
        let transfer = &scene.transfer;
        let thin = |p: &ControlPoint| ControlPoint { opacity: 0.1 * p.opacity, ..*p };
        let [low, high] = rows;
        let rows = vec![(low, transfer.points().iter().map(thin).collect()), (high, transfer.points().to_vec())];
        let transfer = TransferFunction::of_rows(rows, transfer.rule(), transfer.unit_distance()).unwrap();
        let shading = self.shaded.then(|| Arc::new(Shading::default()));
        Scene { transfer: Arc::new(transfer), shading, ..scene }
    }
}

/// Gradients of the volumes here are up to about 1 per unit, and steep between noisy samples.
fn gradient_looks() -> impl Strategy<Value = GradientLook> {
    let rows = (0.0f64..1.0, 0.1f64..2.0).prop_map(|(low, gap)| [low, low + gap]);
    (any::<bool>(), factors(), prop::option::of(rows)).prop_map(|(shaded, mut factors, rows)| {
        // Two factors at one magnitude are a jump, which rounding puts either way.
        factors.dedup_by(|a, b| a.0 - b.0 < 0.05);
        GradientLook { shaded, factors, rows }
    })
}

/// Largest difference of the engines, in parts of the brightest pixel, or of 1: a value is rounded some ten times in f32, to 3·10⁻⁷ of it, and its place to
/// as much of a cell. The steepest ramp here turns a difference of values into eight times as much opacity of a step, and a dozen such steps count. Most
/// pictures differ by 10⁻⁶; one in a hundred by more than 10⁻⁵.
const TWO_ENGINES: f32 = 4e-5;

/// Largest difference of shaded surfaces: their places are as exact as f32 has them, and gradients turn within a cell.
const TWO_SURFACES: f32 = 2e-3;

/// Largest difference of shaded pictures: gradients are differences, of a few per cent of the values that are rounded.
const TWO_SHADINGS: f32 = 1e-3;

/// The scene under an operator that picks values, and a ramp over all of them: a difference of values is one of pixels, and not larger.
fn picking(scene: Scene, compositing: Compositing, shaded: bool) -> Scene {
    let points = vec![ControlPoint::new(0.0, [0.0, 0.2, 1.0], 0.0), ControlPoint::new(1.0, [1.0, 0.7, 0.2], 1.0)];
    let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
    let shading = shaded.then(|| Arc::new(Shading::default()));
    Scene { compositing, shading, transfer: transfer.into(), ..scene }
}

/// Packets that pick values, made once for all that is traced by them.
fn picker(caster: &RayCaster, scene: &Scene) -> PreparedCaster {
    let prepared = PreparedCaster::new(caster.clone(), scene, &Control::default()).unwrap();
    assert!(matches!(prepared.engine, Engine::PatchPicks(..)));
    prepared
}

/// Samples of the packets that pick values.
fn picked(prepared: &PreparedCaster, scene: &Scene, view: &View, spots: &[ImageSample]) -> (Vec<RaySample>, Counts) {
    let layer = scene.layer(view, &Control::default()).unwrap();
    let (mut values, mut counts) = (Vec::new(), Counts::default());
    prepared.tracer((view, layer.as_ref())).unwrap().trace(spots, None, &mut values, &mut counts);
    (values, counts)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 192, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn picks_what_the_plain_engine_picks((scene, view) in scenes(), compositing in picks(), step in 0.1f64..2.5, shaded in any::<bool>()) {
        let scene = picking(scene, compositing, shaded);
        let caster = RayCaster::uniform(step);
        let (values, counts) = picked(&picker(&caster, &scene), &scene, &view, &row_by_row(&view));
        let plain = plain(&caster, &scene, &view);
        prop_assert_eq!(counts.rays, plain.stats.counts.rays);
        let turns = shaded && matches!(compositing, Compositing::First { .. });
        same_picks(values.iter().map(|value| value.rgba), &plain, (compositing, true), if turns { TWO_SURFACES } else { TWO_ENGINES })?;
    }

    #[test]
    fn no_bit_of_what_is_picked_depends_on_leaping_or_company((scene, view) in scenes(), compositing in picks(), step in 0.1f64..2.5, shaded in any::<bool>()) {
        let scene = picking(scene, compositing, shaded);
        let leaping = RayCaster::uniform(step);
        let spots = row_by_row(&view);
        let prepared = picker(&leaping, &scene);
        let (values, fewer) = picked(&prepared, &scene, &view, &spots);
        let through_all = RayCaster { empty_space: EmptySpace::None, ..leaping.clone() };
        let (all, every) = picked(&picker(&through_all, &scene), &scene, &view, &spots);
        prop_assert!(fewer.samples <= every.samples);
        prop_assert_eq!(bits(&values), bits(&all));
        let alone: Vec<_> = spots.iter().flat_map(|s| bits(&picked(&prepared, &scene, &view, &[*s]).0)).collect();
        prop_assert_eq!(alone, bits(&values));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn draws_what_the_plain_engine_draws((scene, view) in scenes(), step in 0.1f64..2.5, compositing in sums()) {
        let scene = Scene { compositing, ..scene };
        let caster = RayCaster { order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(step) };
        let plain = plain(&caster, &scene, &view);
        let (values, counts) = trace(&engine(&caster, &scene), &scene, &view, &row_by_row(&view));
        prop_assert_eq!(counts.rays, plain.stats.counts.rays);
        same(&values, &plain, TWO_ENGINES)?;
    }

    #[test]
    fn takes_the_local_steps_of_the_plain_engine((scene, view) in scenes(), error in 1e-4f64..1e-2) {
        let step = Step::Local { error };
        let caster = RayCaster { step, order: CompositingOrder::WHOLE_RAY, ..RayCaster::default() };
        let plain = plain(&caster, &scene, &view);
        let (values, _) = trace(&engine(&caster, &scene), &scene, &view, &row_by_row(&view));
        same(&values, &plain, TWO_ENGINES)?;
    }

    #[test]
    fn shades_as_the_plain_engine_shades((scene, view) in scenes(), step in 0.1f64..2.5, side in any::<bool>()) {
        let direction = side.then(|| DVec3::new(0.3, -0.8, 0.5));
        let lights = vec![Light::default(), Light { direction, color: [0.5, 1.0, 0.2] }];
        let scene = Scene { shading: Some(Arc::new(Shading::default())), lights, ..scene };
        let caster = RayCaster { order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(step) };
        let plain = plain(&caster, &scene, &view);
        let (values, _) = trace(&engine(&caster, &scene), &scene, &view, &row_by_row(&view));
        same(&values, &plain, TWO_SHADINGS)?;
    }

    #[test]
    fn opacity_follows_the_gradient_as_in_the_plain_engine((scene, view) in scenes(), step in steps(), look in gradient_looks()) {
        let scene = look.on(scene);
        let caster = RayCaster { step, order: CompositingOrder::WHOLE_RAY, ..RayCaster::default() };
        let plain = plain(&caster, &scene, &view);
        let (values, _) = trace(&engine(&caster, &scene), &scene, &view, &row_by_row(&view));
        same(&values, &plain, TWO_SHADINGS)?;
    }

    #[test]
    fn no_bit_depends_on_leaping_or_company((scene, view) in scenes(), step in 0.1f64..2.5, shaded in any::<bool>(), look in prop::option::of(gradient_looks())) {
        let shading = shaded.then(|| Arc::new(Shading::default()));
        let scene = Scene { shading, ..scene };
        let scene = match look {
            Some(look) => look.on(scene),
            None => scene,
        };
        let caster = RayCaster::uniform(step);
        let engine_of_all = engine(&RayCaster { empty_space: EmptySpace::None, ..caster.clone() }, &scene);
        let mut spots = row_by_row(&view);
        let (values, all) = trace(&engine_of_all, &scene, &view, &spots);
        let want = bits(&values);
        let engine = engine(&caster, &scene);
        let (leaping, fewer) = trace(&engine, &scene, &view, &spots);
        prop_assert_eq!(&bits(&leaping), &want);
        prop_assert!(fewer.samples <= all.samples);
        // Other neighbours.
        spots.reverse();
        let one_by_one: Vec<_> =
            spots.iter().rev().flat_map(|s| bits(&trace(&engine, &scene, &view, &[*s]).0)).collect();
        prop_assert_eq!(&one_by_one, &want);
    }
}
