//! Comparison of the vector engine with the plain one, and with itself.

use std::sync::Arc;

use glam::DVec3;
use proptest::prelude::*;
use vr_core::{Camera, Compositing, Control, ControlPoint, Light, OpacityRule, Placement, Shading, TransferFunction};

use super::super::compared::{bits, plain, row_by_row, same};
use super::super::random_scenes::{factors, grid, row_transfers, scenes, steps, sums};
use super::*;
use crate::caster::CompositingOrder;
use crate::render_tables::TablesByPrecision;

/// Returns the engine that a caster makes for a scene, if it can draw it.
fn engine(caster: &RayCaster, scene: &Scene) -> Option<PacketEngine> {
    let volume = scene.volume.grid().unwrap();
    match TablesByPrecision::new(caster, scene, volume, None) {
        TablesByPrecision::F32(tables) => PacketEngine::new(caster, scene, volume, &tables),
        TablesByPrecision::F64(_) => None,
    }
}

fn set_edge(engine: &mut PacketEngine, scene: &Scene, edge: Option<usize>) {
    let volume = scene.volume.grid().unwrap();
    let PacketLengths::Lattice(clear) = &mut engine.lengths else { panic!("uniform steps leap over blocks") };
    let (baked, integrated) = match &engine.light {
        StepLight::Sample(table) => (Some(table), None),
        StepLight::Course { table, .. } => (None, Some(table.pre_integrated())),
    };
    let visibility = Visibility::of_light(&scene.transfer, volume.calibration(), baked, integrated);
    *clear = edge.and_then(|edge| PacketEngine::clear_space(volume, &visibility, edge)).map(Arc::new);
}

fn trace(
    engine: &PacketEngine,
    scene: &Scene,
    view: &View,
    spots: &[ImageSample],
    starts: Option<&[u32]>,
) -> (Vec<RaySample>, Counts) {
    let layer = scene.layer(view, &Control::default()).unwrap();
    let frame = PacketFrame::new(engine, scene.volume.grid().unwrap(), (view, layer.as_ref())).unwrap();
    let (mut values, mut counts) = (Vec::new(), Counts::default());
    frame.trace(spots, starts, &mut values, &mut counts);
    (values, counts)
}

/// Checks that no bit of a picture depends on which rays are traced together.
fn same_alone(engine: &PacketEngine, scene: &Scene, view: &View, values: &[RaySample]) -> Result<(), TestCaseError> {
    let one = |s: &ImageSample| bits(&trace(engine, scene, view, &[*s], None).0)[0];
    prop_assert_eq!(row_by_row(view).iter().map(one).collect::<Vec<_>>(), bits(values));
    Ok(())
}

/// Largest difference of the engines: positions differ by some units in the last place of f32 (10⁻⁶ of a cell here), and the steepest
/// ramps turn that into ten times as much opacity at each of some dozen samples.
const TWO_ENGINES: f32 = 3e-5;

/// Largest difference of shaded pictures: the direction of a small gradient is set by rounding, and so is what a surface there reflects.
/// (The noise of these volumes keeps it from being small everywhere.)
const TWO_SHADINGS: f32 = 2e-3;

/// Largest difference in steps that follow the data: where a ray grazes an edge of blocks, f32 and f64 may see different ones, and
/// so take different steps. (The plain one classifies exactly, besides.)
const TWO_WALKS: f32 = 0.02;

proptest! {
    #![proptest_config(ProptestConfig { cases: 192, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn draws_what_the_plain_engine_draws((scene, view) in scenes(0.9), step in 0.1f64..2.5, left in any::<bool>(), compositing in sums()) {
        let scene = Scene { compositing, ..scene };
        let rule = if left { Rule::Left } else { Rule::Midpoint };
        let caster = RayCaster { step: Step::Uniform(step), rule, order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) };
        let Some(engine) = engine(&caster, &scene) else { return Ok(()) };
        let plain = plain(&caster, &scene, &view);
        let (values, counts) = trace(&engine, &scene, &view, &row_by_row(&view), None);
        // Those that meet nothing visible need not be begun.
        prop_assert!(counts.rays <= plain.stats.counts.rays);
        same(&values, &plain, TWO_ENGINES)?;
    }

    #[test]
    fn walks_as_the_plain_engine_walks((scene, view) in scenes(0.9), error in 1e-4f64..1e-2, compositing in sums()) {
        let scene = Scene { compositing, ..scene };
        let caster = RayCaster { step: Step::Local { error }, order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) };
        let Some(engine) = engine(&caster, &scene) else { return Ok(()) };
        let (values, counts) = trace(&engine, &scene, &view, &row_by_row(&view), None);
        let plain = plain(&caster, &scene, &view);
        // Those that meet nothing visible need not be begun.
        prop_assert!(counts.rays <= plain.stats.counts.rays);
        same(&values, &plain, TWO_WALKS)?;
        same_alone(&engine, &scene, &view, &values)?;
    }

    #[test]
    fn shades_as_the_plain_engine_shades((scene, view) in scenes(0.9), step in 0.1f64..2.5, power in 0.0f64..40.0, side in any::<bool>(), gradient_opacity in factors(), compositing in sums()) {
        let scene = Scene { compositing, ..scene };
        let direction = side.then(|| DVec3::new(0.3, -0.8, 0.5));
        let lights = vec![Light::default(), Light { direction, color: [0.5, 1.0, 0.2] }];
        let scene = Scene { shading: Some(Arc::new(Shading { power, gradient_opacity, ..Shading::default() })), lights, ..scene };
        let caster = RayCaster { step: Step::Uniform(step), order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) };
        let Some(engine) = engine(&caster, &scene) else { return Ok(()) };
        let plain = plain(&caster, &scene, &view);
        let (values, _) = trace(&engine, &scene, &view, &row_by_row(&view), None);
        same(&values, &plain, TWO_SHADINGS)?;
    }

    /// By rows of the transfer function, which the gradient mixes.
    #[test]
    fn mixes_the_rows_that_the_plain_engine_mixes((scene, view) in scenes(0.9), transfer in row_transfers(0.9), step in steps(), analytic in any::<bool>(), shaded in any::<bool>(), compositing in sums()) {
        let gradient = if analytic { GradientMethod::Analytic } else { GradientMethod::CentralDifferences };
        let shading = if shaded { Shading { gradient, ..Shading::default() } } else { Shading { gradient, ..Shading::flat() } };
        let scene = Scene { compositing, transfer: Arc::new(transfer), shading: Some(Arc::new(shading)), ..scene };
        let caster = RayCaster { step, order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) };
        let Some(engine) = engine(&caster, &scene) else { return Ok(()) };
        let plain = plain(&caster, &scene, &view);
        let (values, _) = trace(&engine, &scene, &view, &row_by_row(&view), None);
        // A gradient of the trilinear field itself jumps at the faces of cells, and so does the row.
        let tolerance = if matches!(step, Step::Local { .. }) || analytic { TWO_WALKS } else { TWO_SHADINGS };
        same(&values, &plain, tolerance)?;
        same_alone(&engine, &scene, &view, &values)?;
    }

    /// From node to node of an octree, some of which are crossed at their mean.
    #[test]
    fn crosses_the_nodes_that_the_plain_engine_crosses((scene, view) in scenes(0.9), step in 0.1f64..1.0, exponent in -4.0f64..-1.0, by_variance in any::<bool>(), shaded in any::<bool>(), compositing in sums()) {
        prop_assume!(compositing == Compositing::Over || !scene.transfer.has_emission());
        let shading = shaded.then(|| Arc::new(Shading::default()));
        let scene = Scene { compositing, shading, ..scene };
        let error = 10f64.powf(exponent);
        let step = if by_variance { Step::Variance { step, error } } else { Step::Homogeneous { step, error } };
        let caster = RayCaster { step, order: CompositingOrder::WHOLE_RAY, ..RayCaster::default() };
        let Some(engine) = engine(&caster, &scene) else { return Ok(()) };
        let plain = plain(&caster, &scene, &view);
        let (values, counts) = trace(&engine, &scene, &view, &row_by_row(&view), None);
        prop_assert!(counts.rays <= plain.stats.counts.rays);
        // Where a ray grazes an edge of nodes, the engines may cross different ones: each keeps the bound, where no source is brighter than 1.
        let bound = 2.0 * error as f32 * if by_variance { 4.0 } else { 1.0 } * if scene.transfer.has_emission() { 4.0 } else { 1.0 };
        same(&values, &plain, bound + TWO_WALKS)?;
        same_alone(&engine, &scene, &view, &values)?;
    }

    /// By rules that integrate over all values of a step, in steps of either kind.
    #[test]
    fn integrates_what_the_plain_engine_integrates((scene, view) in scenes(0.9), step in steps(), quadratic in any::<bool>(), is_shaded in any::<bool>(), power in 0.0f64..40.0, gradient_opacity in factors(), compositing in sums()) {
        let modulates = !gradient_opacity.is_empty();
        let shading = (is_shaded || modulates).then(|| Arc::new(Shading { power, gradient_opacity, diffuse: if is_shaded { 0.7 } else { 0.0 }, ..Shading::default() }));
        let scene = Scene { compositing, shading, ..scene };
        // A parabola may leave the values of its samples, and of the blocks that it goes through: which blocks are leaped over would show.
        let (rule, empty_space) = if quadratic { (Rule::Quadratic, EmptySpace::None) } else { (Rule::Linear, EmptySpace::default()) };
        let empty_space = if let Step::Local { .. } = step { EmptySpace::default() } else { empty_space };
        let caster = RayCaster { rule, empty_space, step, order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) };
        let engine = engine(&caster, &scene);
        // A transfer function that no table resolves, or an empty field.
        let Some(engine) = engine else { return Ok(()) };
        let plain = plain(&caster, &scene, &view);
        let (values, counts) = trace(&engine, &scene, &view, &row_by_row(&view), None);
        prop_assert!(counts.rays <= plain.stats.counts.rays);
        let tolerance = match step {
            Step::Local { .. } => TWO_WALKS,
            _ if is_shaded || modulates => TWO_SHADINGS,
            _ => TWO_ENGINES,
        };
        same(&values, &plain, tolerance)?;
        same_alone(&engine, &scene, &view, &values)?;
    }

    #[test]
    fn no_bit_depends_on_leaping_company_or_start((scene, view) in scenes(1.0), step in 0.1f64..2.5, edge in 0u32..4, linear in any::<bool>(), compositing in sums()) {
        let scene = Scene { compositing, ..scene };
        let rule = if linear { Rule::Linear } else { Rule::Midpoint };
        let caster = RayCaster { step: Step::Uniform(step), rule, ..RayCaster::uniform(0.2) };
        let Some(mut engine) = engine(&caster, &scene) else { return Ok(()) };
        set_edge(&mut engine, &scene, None);
        let hull = engine.hull.take();
        let mut spots = row_by_row(&view);
        let (values, all) = trace(&engine, &scene, &view, &spots, None);
        let want = bits(&values);
        set_edge(&mut engine, &scene, Some(1 << edge));
        engine.hull = hull;
        let (leaping, fewer) = trace(&engine, &scene, &view, &spots, None);
        prop_assert_eq!(&bits(&leaping), &want);
        prop_assert!(fewer.samples <= all.samples);
        // Other neighbours.
        spots.reverse();
        let backwards: Vec<_> = bits(&trace(&engine, &scene, &view, &spots, None).0).into_iter().rev().collect();
        prop_assert_eq!(&backwards, &want);
        let one_by_one: Vec<_> =
            spots.iter().rev().flat_map(|s| bits(&trace(&engine, &scene, &view, &[*s], None).0)).collect();
        prop_assert_eq!(&one_by_one, &want);
    }
}

#[test]
fn thousands_of_faint_steps_add_up() {
    // 4096 steps of α = 10⁻⁷ behind half an opacity.
    let mut samples = vec![1.0; 4 * 4 * 4097];
    samples[..32].fill(0.0);
    let volume = grid(4, [4, 4, 4097], &samples, Placement::from_spacing([1.0; 3]).unwrap());
    let points = vec![ControlPoint::new(0.0, [1.0; 3], 0.75), ControlPoint::new(1.0, [1.0; 3], 1e-7)];
    let scene = Scene::new(volume, TransferFunction::new(points, OpacityRule::Extinction, 1.0).unwrap());
    let camera = Camera {
        eye: DVec3::new(1.5, 1.5, -5.0),
        target: DVec3::new(1.5, 1.5, 1.0),
        up: DVec3::Y,
        projection: vr_core::Projection::Orthographic { height: 1.0 },
    };
    let view = View::new(camera, [1, 1]);
    let caster = RayCaster { step: Step::Uniform(1.0), order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) };
    let engine = engine(&caster, &scene).unwrap();
    let alpha = trace(&engine, &scene, &view, &row_by_row(&view), None).0[0].rgba[3];
    // Midpoint: a whole step of 0.75, one of the ramp's middle, and 4094 faint ones.
    let want = 1.0 - libm::exp(-(0.75 + 0.5 * (0.75 + 1e-7) + 4094.0 * 1e-7));
    assert!((f64::from(alpha) - want).abs() < 2e-7, "{alpha} {want}");
}
