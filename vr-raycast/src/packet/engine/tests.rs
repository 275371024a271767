//! Comparison of the vector engine with the plain one, and with itself.

use std::sync::Arc;

use fearless_simd::Level;
use glam::{DMat3, DVec3};
use proptest::prelude::*;
use vr_core::{
    Calibration, Camera, Clip, Control, ControlPoint, Light, OpacityRule, Placement, Plane, Shading, TransferFunction,
    UniformGrid, Volume,
};

use vr_physics::check::FixedLayer;

use super::super::compared::{bits, plain, row_by_row, same};
use super::*;
use crate::render_tables::TablesByPrecision;

/// Returns every level that the machine has.
fn levels() -> Vec<Level> {
    let best = Level::new();
    let mut all = vec![best];
    #[cfg(target_arch = "x86_64")]
    all.extend([best.as_avx2().map(Level::Avx2), best.as_sse2().map(Level::Sse2)].into_iter().flatten());
    all
}

/// Makes a grid of one of the five types from numbers in [0, 1].
fn grid(kind: usize, dims: [usize; 3], samples: &[f64], placement: Placement) -> Volume {
    fn of<T: vr_core::Voxel>(
        dims: [usize; 3],
        samples: &[f64],
        placement: Placement,
        range: [f64; 2],
        round: impl Fn(f64) -> T,
    ) -> Volume
    where
        Volume: From<UniformGrid<T>>,
    {
        // Calibrated so that values are in [0, 1] again.
        let calibration =
            Calibration { slope: 1.0 / (range[1] - range[0]), intercept: -range[0] / (range[1] - range[0]) };
        let stored: Vec<T> = samples.iter().map(|x| round((range[0] + x * (range[1] - range[0])).round())).collect();
        UniformGrid::new(dims, stored, placement, calibration).unwrap().into()
    }
    match kind {
        0 => of(dims, samples, placement, [0.0, 255.0], |x| x as u8),
        1 => of(dims, samples, placement, [-128.0, 127.0], |x| x as i8),
        2 => of(dims, samples, placement, [0.0, 65535.0], |x| x as u16),
        3 => of(dims, samples, placement, [-32768.0, 32767.0], |x| x as i16),
        _ => {
            let stored: Vec<f32> = samples.iter().map(|&x| x as f32).collect();
            UniformGrid::new(dims, stored, placement, Calibration::default()).unwrap().into()
        }
    }
}

fn volumes() -> impl Strategy<Value = Volume> {
    let dims = prop::array::uniform3(2usize..20);
    let shape =
        (prop::array::uniform3(0.3f64..3.0), prop::array::uniform3(-0.3f64..0.3), prop::array::uniform3(-9.0f64..9.0));
    // Blobs: most of it empty, so that there is something to leap over.
    let blob = (prop::array::uniform3(0.0f64..1.0), 0.05f64..0.6);
    (0usize..5, dims, shape, prop::collection::vec(blob, 1..4), 0.0f64..0.1, any::<u64>()).prop_map(
        |(kind, dims, (spacing, shear, origin), blobs, noise, seed)| {
            let axes = DMat3::from_diagonal(DVec3::from(spacing))
                + DMat3::from_cols(DVec3::ZERO, DVec3::X * shear[0], DVec3::new(shear[1], shear[2], 0.0));
            let mut state = seed;
            let samples: Vec<f64> = (0..dims.iter().product::<usize>())
                .map(|i| {
                    state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                    let at = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
                    let at = DVec3::from_array(std::array::from_fn(|a| at[a] as f64 / (dims[a] - 1) as f64));
                    let blob = |(middle, radius): &([f64; 3], f64)| 1.0 - at.distance(DVec3::from(*middle)) / radius;
                    let value = blobs.iter().map(blob).fold(0.0, f64::max);
                    (value + noise * (state >> 40) as f64 / (1u64 << 24) as f64).min(1.0)
                })
                .collect();
            grid(kind, dims, &samples, Placement::new(origin.into(), axes).unwrap())
        },
    )
}

/// Strategy of transfer functions whose ramps are at least a tenth of the range wide; clear below the first.
fn transfers(max_opacity: f64) -> impl Strategy<Value = TransferFunction> {
    let point = (
        0.1f64..0.3,
        prop::array::uniform3(0.0f64..1.0),
        prop_oneof![0.0f64..max_opacity, Just(0.0), Just(max_opacity)],
    );
    (prop::collection::vec(point, 2..6), 0.2f64..3.0, any::<bool>(), any::<bool>()).prop_map(
        |(points, unit, power, emits)| {
            let mut value = 0.0;
            let emission = |c: [f64; 3], a: f64| emits.then(|| c.map(|c| if a == 0.0 { 0.0 } else { 3.0 * c }));
            let mut all =
                vec![ControlPoint { emission: emission([0.0; 3], 0.0), ..ControlPoint::new(0.12, [0.5; 3], 0.0) }];
            for (gap, color, opacity) in points {
                value += gap;
                let point = ControlPoint::new(value + 0.12, color, opacity);
                all.push(ControlPoint { emission: emission(color, opacity), ..point });
            }
            let rule = if power { OpacityRule::Power } else { OpacityRule::Extinction };
            TransferFunction::new(all, rule, unit).unwrap()
        },
    )
}

/// Views of a volume from all sides, from far and from within, clipped or not, with or without a layer; odd sizes.
fn scene_of(
    scene: Scene,
    (azimuth, elevation, fov): (f64, f64, Option<f64>),
    size: [u32; 2],
    cut: u32,
    share: f64,
) -> (Scene, View) {
    let bounds = scene.volume.bounds();
    let mut camera = Camera::framing(bounds, azimuth, elevation, fov);
    if cut & 1 == 1 {
        camera.eye = camera.target + (camera.eye - camera.target) * 0.05;
    }
    let mut view = View::new(camera, size);
    let extent = bounds.1 - bounds.0;
    let crop = (cut & 2 != 0).then(|| (bounds.0 + extent * 0.3 * share, bounds.1 - extent * 0.2));
    let plane = Plane { normal: DVec3::new(1.0, -0.5, 0.3), offset: DVec3::new(1.0, -0.5, 0.3).dot(camera.target) };
    view.clip = Clip { crop, planes: if cut & 4 != 0 { vec![plane] } else { Vec::new() } };
    if cut & 8 != 0 {
        let distance = (camera.target - camera.eye).length() as f32;
        let pixel = |i: u32| {
            ([0.1, 0.2, 0.3], if i.is_multiple_of(3) { f32::INFINITY } else { distance * (0.8 + 0.1 * (i % 5) as f32) })
        };
        return (FixedLayer::new(&view, pixel).among(&scene), view);
    }
    (scene, view)
}

fn scenes(max_opacity: f64) -> impl Strategy<Value = (Scene, View)> {
    let angles = (-180.0f64..180.0, -80.0f64..80.0, prop::option::of(20.0f64..90.0));
    let angles = prop_oneof![8 => angles, 1 => Just((90.0, 0.0, None)), 1 => Just((0.0, 0.0, Some(40.0)))];
    (volumes(), transfers(max_opacity), angles, 1u32..13, 1u32..10, 0u32..16, 0.0f64..1.0).prop_map(
        |(volume, transfer, angles, w, h, cut, share)| {
            scene_of(Scene::new(volume, transfer), angles, [w, h], cut, share)
        },
    )
}

/// Returns the engine that a caster makes for a scene, if it can draw it.
fn engine(caster: &RayCaster, scene: &Scene) -> Option<PacketEngine> {
    let volume = scene.volume.grid().unwrap();
    match TablesByPrecision::new(caster, scene, volume, None) {
        TablesByPrecision::F32(tables) => PacketEngine::new(caster, scene, volume, &tables),
        TablesByPrecision::F64(_) => None,
    }
}

fn set_edge(engine: &mut PacketEngine, scene: &Scene, edge: Option<usize>) {
    let PacketSteps::Lattice { table, distances } = &mut engine.steps else { panic!("uniform steps leap over blocks") };
    *distances = edge.and_then(|edge| PacketEngine::distances(scene.volume.grid().unwrap(), scene, table, edge));
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
    fn draws_what_the_plain_engine_draws((scene, view) in scenes(0.9), step in 0.1f64..2.5, left in any::<bool>()) {
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
    fn walks_as_the_plain_engine_walks((scene, view) in scenes(0.9), error in 1e-4f64..1e-2) {
        let caster = RayCaster { step: Step::Local { error }, order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) };
        let Some(engine) = engine(&caster, &scene) else { return Ok(()) };
        let (values, counts) = trace(&engine, &scene, &view, &row_by_row(&view), None);
        let plain = plain(&caster, &scene, &view);
        // Those that meet nothing visible need not be begun.
        prop_assert!(counts.rays <= plain.stats.counts.rays);
        same(&values, &plain, TWO_WALKS)?;
        // No bit depends on the level or on company.
        let want = bits(&values);
        let mut other = engine.clone();
        for level in levels() {
            other.level = level;
            prop_assert_eq!(&bits(&trace(&other, &scene, &view, &row_by_row(&view), None).0), &want, "{:?}", level);
        }
        let one = |s: &ImageSample| bits(&trace(&engine, &scene, &view, &[*s], None).0)[0];
        prop_assert_eq!(&row_by_row(&view).iter().map(one).collect::<Vec<_>>(), &want);
    }

    #[test]
    fn shades_as_the_plain_engine_shades((scene, view) in scenes(0.9), step in 0.1f64..2.5, power in 0.0f64..40.0, side in any::<bool>()) {
        let direction = side.then(|| DVec3::new(0.3, -0.8, 0.5));
        let lights = vec![Light::default(), Light { direction, color: [0.5, 1.0, 0.2] }];
        let scene = Scene { shading: Some(Arc::new(Shading { power, ..Shading::default() })), lights, ..scene };
        let caster = RayCaster { step: Step::Uniform(step), order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) };
        let Some(engine) = engine(&caster, &scene) else { return Ok(()) };
        let plain = plain(&caster, &scene, &view);
        let (values, _) = trace(&engine, &scene, &view, &row_by_row(&view), None);
        same(&values, &plain, TWO_SHADINGS)?;
    }

    #[test]
    fn no_bit_depends_on_leaping_level_company_or_start((scene, view) in scenes(1.0), step in 0.1f64..2.5, edge in 0u32..4) {
        let caster = RayCaster { step: Step::Uniform(step), ..RayCaster::uniform(0.2) };
        let Some(mut engine) = engine(&caster, &scene) else { return Ok(()) };
        set_edge(&mut engine, &scene, None);
        let hull = engine.hull.take();
        let mut spots = row_by_row(&view);
        let (values, all) = trace(&engine, &scene, &view, &spots, None);
        let want = bits(&values);
        for level in levels() {
            engine.level = level;
            prop_assert_eq!(&bits(&trace(&engine, &scene, &view, &spots, None).0), &want, "{:?}", level);
        }
        engine.level = Level::new();
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
