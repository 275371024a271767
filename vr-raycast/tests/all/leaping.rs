//! Leaping over empty space, and coarse steps in it: the same picture, bit for bit, with less work.

use crate::common::*;
use glam::DVec3;
use proptest::prelude::*;
use std::sync::Arc;
use vr_core::*;
use vr_raycast::{CompositingOrder, EmptySpace, Precision, RayCaster, Rule, Step, TransferLookup, Vector};

const LEAPINGS: [EmptySpace; 6] = [
    EmptySpace::Octree,
    EmptySpace::Pyramid,
    EmptySpace::ExactCloud,
    EmptySpace::ChessboardCloud,
    EmptySpace::Boxes,
    EmptySpace::Polyhedron,
];

/// The plain engine, which leaps as it is told; the vector engine has a way of its own.
fn plain() -> RayCaster {
    RayCaster {
        empty_space: EmptySpace::None,
        vector: Vector::Off,
        step: Step::Uniform(0.2),
        ..RayCaster::uniform(0.2)
    }
}

/// Every way to leap, and coarse steps of several lengths.
fn leaping_casters(plain: &RayCaster) -> Vec<RayCaster> {
    let Step::Uniform(fine) = plain.step else { panic!("steps of one length") };
    let leaping = LEAPINGS.map(|leaping| RayCaster { empty_space: leaping, ..plain.clone() });
    let coarse = [1.0, 5.5, 16.0].into_iter().filter(|&c| c > fine);
    let vicinity = coarse.map(|coarse| RayCaster { step: Step::Vicinity { coarse, fine }, ..plain.clone() });
    leaping.into_iter().chain(vicinity).collect()
}

/// Volumes several blocks across: 0 but for a few boxes of another value, or of NaN.
fn volumes() -> impl Strategy<Value = Volume> {
    let dims = prop::array::uniform3(2usize..45);
    let spacing = prop::array::uniform3(prop_oneof![3 => Just(1.0), 1 => 0.2f64..3.0]);
    let value = prop_oneof![8 => 0.1f32..1.0, 1 => Just(f32::NAN)];
    let boxes = prop::collection::vec((prop::array::uniform3(0.0f64..1.0), 0usize..7, value), 0..5);
    let any = (dims, spacing, boxes, prop::bool::ANY);
    any.prop_map(|(dims, spacing, boxes, bytes)| {
        let mut samples = vec![0.0f32; dims.iter().product()];
        for (at, size, value) in boxes {
            let first: [usize; 3] = std::array::from_fn(|a| (at[a] * dims[a] as f64) as usize);
            let end: [usize; 3] = std::array::from_fn(|a| (first[a] + size + 1).min(dims[a]));
            for z in first[2]..end[2] {
                for y in first[1]..end[1] {
                    let row = (z * dims[1] + y) * dims[0];
                    samples[row + first[0]..row + end[0]].fill(value);
                }
            }
        }
        let placement = Placement::from_spacing(spacing).unwrap();
        if bytes {
            let calibration = Calibration { slope: 1.0 / 255.0, intercept: 0.0 };
            let samples: Vec<u8> = samples.into_iter().map(|s| (255.0 * s) as u8).collect();
            UniformGrid::new(dims, samples, placement, calibration).unwrap().into()
        } else {
            UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap().into()
        }
    })
}

/// Transfer functions that are clear at 0, or nearly so, in most cases; with jumps, walls and emission of their own.
fn transfers() -> impl Strategy<Value = TransferFunction> {
    let opacity = prop_oneof![2 => Just(0.0), 3 => 0.0f64..0.9, 1 => Just(1.0)];
    let point = (0.0f64..1.0, prop::array::uniform3(0.0f64..1.0), opacity);
    let points = prop::collection::vec(point, 1..4);
    let first = prop_oneof![4 => Just(0.0), 1 => Just(0.01)];
    (points, first, prop::bool::weighted(0.2)).prop_map(|(mut points, first, emits)| {
        points.push((0.0, [1.0; 3], first));
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let emission = |c: [f64; 3], a: f64| emits.then_some(c.map(|c| if a > 0.5 { c } else { 0.0 }));
        let point =
            |&(v, c, a): &(f64, [f64; 3], f64)| ControlPoint { emission: emission(c, a), ..ControlPoint::new(v, c, a) };
        TransferFunction::new(points.iter().map(point).collect(), OpacityRule::Power, 3.0).unwrap()
    })
}

fn scenes() -> impl Strategy<Value = (Scene, View)> {
    let filter = prop_oneof![4 => Just(Filter::Trilinear), 2 => prop::sample::select(&Filter::ALL[..])];
    let compositing = prop_oneof![
        3 => Just(Compositing::Over),
        1 => (0.1f64..1.0).prop_map(|level| Compositing::Accumulate { level }),
        2 => (0.05f64..1.0).prop_map(|threshold| Compositing::First { threshold }),
    ];
    // Also along the axes, where rays lie in the faces of blocks.
    let angle = |most: f64| prop_oneof![Just(0.0), Just(most / 2.0), -most..most];
    let camera = (angle(180.0), angle(90.0), prop::option::of(20.0f64..90.0), prop::bool::ANY);
    let shading = (prop::bool::ANY, prop::bool::ANY);
    (volumes(), transfers(), filter, compositing, camera, shading, prop::bool::ANY).prop_map(
        |(volume, transfer, filter, compositing, (azimuth, elevation, fov, inside), (shaded, modulated), clipped)| {
            let mut scene = Scene { compositing, ..Scene::new(volume.with_filter(filter), transfer) };
            if shaded {
                let gradient_opacity = if modulated { vec![(0.0, 0.2), (0.5, 1.0)] } else { Vec::new() };
                scene.shading = Some(Arc::new(Shading { gradient_opacity, ..Shading::default() }));
            }
            let (low, high) = scene.volume.bounds();
            let mut camera = Camera::framing((low, high), azimuth, elevation, fov);
            if inside && fov.is_some() {
                camera.eye = low + (high - low) * DVec3::new(0.3, 0.4, 0.5);
            }
            let mut view = View::new(camera, [9, 9]);
            if clipped {
                view.clip.crop = Some((low + (high - low) * 0.1, high - (high - low) * 0.05));
            }
            (scene, view)
        },
    )
}

/// Differences in any bit of any pixel, or of its depth.
fn differences(a: &Frame, b: &Frame) -> usize {
    let bits = |p: &[f32; 4]| p.map(f32::to_bits);
    let pixels = a.pixels().iter().zip(b.pixels()).filter(|(a, b)| bits(a) != bits(b)).count();
    let (a, b) = (a.depth().unwrap(), b.depth().unwrap());
    pixels + a.iter().zip(b).filter(|(a, b)| a.to_bits() != b.to_bits()).count()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 192, failure_persistence: None, ..ProptestConfig::default() })]

    /// The promise, for all operators that leaping applies to, both orders, both precisions, with and without a table.
    #[test]
    fn leaping_changes_no_bit(
        (scene, view) in scenes(),
        step in prop_oneof![0.05f64..1.0, 1.0f64..20.0],
        rule in prop::sample::select(&[Rule::Midpoint, Rule::Midpoint, Rule::Left, Rule::Linear][..]),
        backwards in prop::bool::ANY,
        whole in prop::bool::ANY,
        exact in prop::bool::weighted(0.2),
        double in prop::bool::weighted(0.2),
    ) {
        let plain = RayCaster {
            step: Step::Uniform(step),
            empty_space: EmptySpace::None,
            vector: Vector::Off,
            // A threshold is looked for between samples, whatever the rule.
            rule: if scene.compositing.integrates_light() && scene.volume.filter().unwrap().is_continuous() { rule } else { Rule::Midpoint },
            order: match scene.compositing {
                Compositing::Over if backwards => CompositingOrder::BackToFront,
                _ if whole => CompositingOrder::WHOLE_RAY,
                _ => CompositingOrder::default(),
            },
            transfer_lookup: if exact { TransferLookup::Exact } else { TransferLookup::Auto },
            precision: if double { Precision::F64 } else { Precision::F32 },
            ..RayCaster::uniform(0.2)
        };
        let want = render(&plain, &scene, &view);
        prop_assert_eq!(want.stats.counts.skipped, 0);
        let ends_early = scene.compositing != Compositing::Over || want.stats.counts.terminated > 0;
        for caster in leaping_casters(&plain) {
            let got = render(&caster, &scene, &view);
            let different = differences(&got.frame, &want.frame);
            prop_assert!(different == 0, "{different} differences: {:?} {:?}", caster.empty_space, caster.step);
            let (found, all) = (got.stats.counts, want.stats.counts);
            prop_assert!(found.samples <= all.samples);
            // Each step is sampled or skipped.
            // Where segments meet, they share a sample.
            prop_assert!(ends_early || plain.rule == Rule::Linear || found.samples + found.skipped == all.samples, "{found:?} {all:?}");
        }
    }
}

/// One voxel in 64³ is visible. (Its eight cells touch one block of 8³, or two along an axis.)
fn speck() -> Scene {
    let volume = volume([65; 3], |x, y, z| f64::from(u8::from([x, y, z] == [20.0, 36.0, 44.0])));
    Scene::new(volume, transfer(&[(0.0, [1.0; 3], 0.0), (1.0, [1.0; 3], 0.5)], 1.0))
}

#[test]
fn most_steps_past_a_speck_are_skipped() {
    let scene = speck();
    let view = oblique(&scene, 32);
    for caster in leaping_casters(&plain()) {
        let counts = render(&caster, &scene, &view).stats.counts;
        let share = counts.samples as f64 / (counts.samples + counts.skipped) as f64;
        // One block is 0.2 % of the volume, 27 are 5 %; the coarsest flags are set in 27 blocks of 16³ of 64.
        let most = if matches!(caster.step, Step::Vicinity { coarse: 16.0, .. }) { 0.5 } else { 0.06 };
        assert!(counts.samples > 0 && share < most, "{:?} {:?}: {share}", caster.empty_space, caster.step);
    }
}

/// Operators that depend on what is transparent sample everything: a way to leap would do nothing.
#[test]
fn values_of_clear_samples_cannot_be_skipped() {
    for compositing in [Compositing::Average, Compositing::Maximum, Compositing::Minimum] {
        let scene = Scene { compositing, ..speck() };
        for caster in leaping_casters(&plain()) {
            let refused = caster.prepare(&scene, &Control::default()).err();
            let Some(RenderError::Unsupported(Unsupported { what: feature, .. })) = refused else {
                panic!("{:?}", caster.empty_space)
            };
            assert!(feature.contains(compositing.name()), "{feature}");
        }
        let counts = render(&plain(), &scene, &oblique(&scene, 8)).stats.counts;
        assert!(counts.samples > 0 && counts.skipped == 0);
    }
}

/// Tests that data kept from one scene to the next never shows: neither the structure of another transfer function, nor of another threshold.
#[test]
fn an_update_is_a_new_start() {
    let control = Control::default();
    let blobs = volume([33; 3], |x, y, z| ((0.3 * x).sin() * (0.4 * y).cos() * (0.2 * z + 1.0).sin()).abs());
    let scene = |low: f64, compositing| Scene {
        compositing,
        ..Scene::new(blobs.clone(), transfer(&[(low, [0.3, 0.5, 1.0], 0.0), (1.0, [1.0; 3], 0.5)], 1.0))
    };
    let scenes = [
        scene(0.9, Compositing::Over),
        scene(0.5, Compositing::Over),
        scene(0.5, Compositing::First { threshold: 0.95 }),
        scene(0.5, Compositing::First { threshold: 0.3 }),
        scene(0.3, Compositing::Over),
        scene(0.95, Compositing::Accumulate { level: 0.5 }),
    ];
    let view = oblique(&scenes[0], 16);
    for caster in leaping_casters(&plain()) {
        let mut prepared = caster.prepare(&scenes[0], &control).unwrap();
        for scene in &scenes[1..] {
            prepared.update(scene, &control).unwrap();
            let (got, want) = (prepared.render(&view, &control).unwrap(), render(&caster, scene, &view));
            assert_eq!(differences(&got.frame, &want.frame), 0);
            assert_eq!(got.stats.counts, want.stats.counts, "{:?}", caster.empty_space);
        }
    }
}
