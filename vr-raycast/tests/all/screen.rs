//! Tests of the choice of rays: pictures that must be the same, and pictures that may differ by a bound.

use crate::common;

use crate::common::{max_error, random, rms, transfer};
use glam::{DMat3, DVec3};
use proptest::prelude::*;
use vr_core::phantom::{self, TRANSFER_UNIT_DISTANCE};
use vr_core::*;
use vr_physics::Reference;
use vr_physics::cases::Case;
use vr_physics::check::{FixedLayer, survives_hard_cases};
use vr_raycast::{CompositingOrder, Connectivity, EmptySpace, ImageSampling, RayCaster, Rule, Step, Traversal, Vector};

fn caster(screen: ImageSampling) -> RayCaster {
    RayCaster { image_sampling: screen, step: Step::Uniform(0.5), ..RayCaster::uniform(0.2) }
}

/// A scene of balls in a clear box, of any placement.
fn balls(seed: u64, dims: [usize; 3], placement: Placement) -> Scene {
    let mut random = random(seed);
    let size = DVec3::from_array(dims.map(|n| (n - 1) as f64));
    let balls: Vec<(DVec3, f64)> = (0..6)
        .map(|_| (DVec3::new(random(), random(), random()) * size, (0.05 + 0.1 * random()) * size.max_element()))
        .collect();
    let field = |x: f64, y: f64, z: f64| {
        let p = DVec3::new(x, y, z);
        balls.iter().map(|&(c, r)| (1.0 - p.distance(c) / r).max(-0.2)).fold(-0.2, f64::max)
    };
    let points = [(0.05, [1.0, 0.5, 0.2], 0.0), (0.3, [0.2, 0.6, 1.0], 0.4), (0.9, [1.0; 3], 0.95)];
    Scene::new(common::grid(dims, placement, field).into(), transfer(&points, 1.0))
}

fn assert_same(got: &Frame, want: &Frame, what: &str) {
    let bits = |f: &Frame| f.pixels().iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(got), bits(want), "{what}: colours");
    let depths = |f: &Frame| f.depth().unwrap().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(depths(got), depths(want), "{what}: depths");
}

/// Draws views one after the other, by every pixel and by a coherent screen; returns the samples that either took.
fn assert_coherent(scene: &Scene, views: &[View], by: &RayCaster) -> (u64, u64) {
    let control = Control::default();
    let prepare = |screen| RayCaster { image_sampling: screen, ..by.clone() }.prepare(scene, &control).unwrap();
    let (mut plain, mut coherent) = (prepare(ImageSampling::EveryPixel), prepare(by.image_sampling));
    let mut samples = (0, 0);
    for (i, view) in views.iter().enumerate() {
        let want = plain.render(view, &control).unwrap();
        let got = coherent.render(view, &control).unwrap();
        assert_same(&got.frame, &want.frame, &format!("view {i}"));
        samples.0 += got.stats.counts.samples;
        samples.1 += want.stats.counts.samples;
    }
    samples
}

#[test]
fn coherent_turntables_are_the_same_and_cost_less() {
    let scene = balls(3, [41, 37, 29], Placement::from_spacing([1.0, 1.1, 1.3]).unwrap());
    for fov in [None, Some(35.0)] {
        let start = Camera::framing(scene.volume.bounds(), 10.0, 25.0, fov);
        let views: Vec<View> = (0..6).map(|k| View::new(start.orbit(10.0 * f64::from(k), 0.0), [61, 47])).collect();
        let without_leaping = RayCaster { empty_space: EmptySpace::None, ..caster(ImageSampling::Coherent) };
        let (with, without) = assert_coherent(&scene, &views, &without_leaping);
        assert!(10 * with < 9 * without, "{with} of {without} samples");
        // The same view again: what the first picture met is known now, and fewer samples are taken. (Rays that leap over clear cells begin there the first time.)
        let mut prepared = without_leaping.prepare(&scene, &Control::default()).unwrap();
        let samples = [(); 3].map(|()| prepared.render(&views[0], &Control::default()).unwrap().stats.counts.samples);
        assert!(samples[1] < samples[0] && samples[2] <= samples[1], "{samples:?}");
    }
}

#[test]
fn a_changed_transfer_function_is_seen() {
    let mut scene = balls(5, [30; 3], Placement::from_spacing([1.0; 3]).unwrap());
    let control = Control::default();
    let view = View::new(Camera::framing(scene.volume.bounds(), 40.0, 20.0, None), [40, 40]);
    let mut screens =
        [ImageSampling::Coherent, ImageSampling::CBuffer].map(|by| caster(by).prepare(&scene, &control).unwrap());
    for low in [0.5, 0.1, 0.3] {
        let points = [(low, [1.0; 3], 0.0), (low + 0.1, [1.0, 0.0, 0.0], 0.7)];
        scene.transfer = transfer(&points, 1.0).into();
        let want =
            caster(ImageSampling::EveryPixel).prepare(&scene, &control).unwrap().render(&view, &control).unwrap();
        for coherent in &mut screens {
            coherent.update(&scene, &control).unwrap();
            assert_same(&coherent.render(&view, &control).unwrap().frame, &want.frame, "after a change");
            assert_same(&coherent.render(&view, &control).unwrap().frame, &want.frame, "again");
        }
    }
}

fn cameras() -> impl Strategy<Value = Camera> {
    let point = || prop::array::uniform3(-1.0..1.0f64).prop_map(DVec3::from);
    (point(), 0.2..8.0f64, point(), prop::option::of(20.0..100.0f64), 0.4..2.5f64).prop_filter_map(
        "a direction",
        |(direction, distance, target, fov, height)| {
            let eye = target + direction.try_normalize()? * distance;
            let projection = fov.map_or(Projection::Orthographic { height }, |fov| Projection::Perspective { fov });
            let camera = Camera { eye, target: 0.3 * target, up: DVec3::new(0.1, 1.0, 0.2), projection };
            camera.frame().ok().map(|_| camera)
        },
    )
}

fn placements() -> impl Strategy<Value = DMat3> {
    prop::array::uniform9(-0.4..0.4f64)
        .prop_map(|m| DMat3::from_cols_array(&m) + DMat3::from_diagonal(DVec3::new(1.0, 0.8, 1.5)))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any sequence of views, of any grid, clip and size: eyes inside the volume, grazing views, layers.
    #[test]
    fn coherent_pictures_are_the_same_bit_for_bit(
        seed in any::<u64>(),
        dims in prop::array::uniform3(2usize..40),
        axes in placements(),
        cameras in prop::collection::vec(cameras(), 1..4),
        size in prop::array::uniform2(1u32..48),
        samples in 1u32..3,
        crop in prop::option::weighted(0.25, (prop::array::uniform3(-1.0..0.0f64), prop::array::uniform3(0.0..1.0f64))),
        plane in prop::option::weighted(0.25, prop::array::uniform3(-1.0..1.0f64)),
        layered in prop::option::weighted(0.25, 0.5..8.0f32),
        backwards in prop::bool::weighted(0.2),
        vector in prop::sample::select(vec![Vector::Auto, Vector::Off]),
        leaping in prop::sample::select(vec![EmptySpace::None, EmptySpace::Octree]),
        screen in prop::sample::select(vec![ImageSampling::Coherent, ImageSampling::CBuffer]),
        compositing in prop::sample::select(vec![
            Compositing::Over,
            Compositing::Over,
            Compositing::Accumulate { level: 0.6 },
            Compositing::First { threshold: 0.25 },
        ]),
        rule in prop::sample::select(vec![Rule::Midpoint, Rule::Midpoint, Rule::Left, Rule::Linear]),
        shaded in prop::bool::weighted(0.3),
    ) {
        // The box is about as large as the cameras' world.
        let last = DVec3::from_array(dims.map(|n| (n - 1) as f64));
        let axes = axes * DMat3::from_diagonal(1.0 / last);
        let placement = Placement::new(-0.5 * (axes * last), axes).unwrap();
        let mut scene = balls(seed, dims, placement);
        scene.transfer = transfer(&[(0.05, [1.0, 0.5, 0.2], 0.0), (0.9, [1.0; 3], 0.95)], 0.1).into();
        let views: Vec<View> = cameras
            .into_iter()
            // Each twice, a little turned: what the first one met is known to the second.
            .flat_map(|camera| [camera, camera.orbit(4.0, 2.0)])
            .map(|camera| {
                let mut view = View::new(camera, size);
                view.supersampling = samples;
                view.clip.crop = crop.map(|(low, high)| (DVec3::from(low) * 0.7, DVec3::from(high) * 0.7 + 0.01));
                view.clip.planes.extend(plane.map(|n| Plane { normal: DVec3::from(n) + 0.01, offset: -0.1 }));
                view
            })
            .collect();
        if let Some(depth) = layered {
            let pixel = |i: u32| ([0.1, 0.2, 0.3], if i.is_multiple_of(3) { f32::INFINITY } else { depth });
            scene = FixedLayer::new(&views[0], pixel).among(&scene);
        }
        scene.compositing = compositing;
        scene.shading = shaded.then(|| Shading::default().into());
        // A threshold is looked for between samples: no step is integrated.
        let rule = if rule == Rule::Linear && !compositing.integrates_light() { Rule::Midpoint } else { rule };
        let is_back = backwards && compositing == Compositing::Over;
        let order = if is_back { CompositingOrder::BackToFront } else { CompositingOrder::default() };
        assert_coherent(&scene, &views, &RayCaster { order, vector, rule, empty_space: leaping, ..caster(screen) });
    }
}

#[test]
fn adaptive_with_no_threshold_is_every_pixel() {
    let scene = balls(1, [20; 3], Placement::from_spacing([1.0; 3]).unwrap());
    let view = View::new(Camera::framing(scene.volume.bounds(), 30.0, 20.0, None), [53, 31]);
    let draw = |screen| common::render(&caster(screen), &scene, &view).frame;
    assert_same(&draw(ImageSampling::Adaptive { threshold: 0.0 }), &draw(ImageSampling::EveryPixel), "threshold 0");
}

fn of_phantom(name: &str, n: usize) -> Scene {
    let phantom = phantom::by_name(name).unwrap();
    let transfer = TransferFunction::new(phantom.transfer_points(), OpacityRule::Power, TRANSFER_UNIT_DISTANCE);
    Scene::new(phantom::sample::<f32>(&*phantom, [n; 3]).unwrap().into(), transfer.unwrap())
}

/// No law bounds what lies between rays on a line; on these pictures, of features wider than the first rays' distance, it is within
/// the threshold, and mostly nothing.
#[test]
fn adaptive_pictures_are_near_their_threshold() {
    for name in phantom::NAMES {
        let scene = of_phantom(name, 33);
        for fov in [None, Some(30.0)] {
            let view = View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, fov), [160, 157]);
            let want = common::render(&caster(ImageSampling::EveryPixel), &scene, &view);
            for threshold in [0.01, 0.05, 0.2] {
                let got = common::render(&caster(ImageSampling::Adaptive { threshold }), &scene, &view);
                let error = max_error(&got.frame, &want.frame);
                assert!(error <= threshold, "{name}, {fov:?}, threshold {threshold}: {error}");
                let share = got.stats.counts.rays as f64 / want.stats.counts.rays as f64;
                // Where nine tenths of what shows are refined, every pixel of that is traced; and the cells end beyond the picture.
                let is_busy = matches!(*name, "fog" | "marschner-lobb" | "blobs") || threshold < 0.1;
                let most = if is_busy { 1.02 } else { 0.85 };
                assert!(share <= most, "{name}, {fov:?}, threshold {threshold}: {share} of the rays");
            }
        }
    }
}

fn template(connectivity: Connectivity, step: f64) -> RayCaster {
    RayCaster {
        image_sampling: ImageSampling::Template { connectivity },
        step: Step::Uniform(step),
        ..RayCaster::uniform(0.2)
    }
}

/// A smooth bump that is clear well before the faces of the box, at `n`³ samples over [−1, 1]³.
fn bump(n: usize) -> Scene {
    let h = 2.0 / (n - 1) as f64;
    let placement = Placement::new(DVec3::NEG_ONE, DMat3::from_diagonal(DVec3::splat(h))).unwrap();
    let at = |i: f64| i * h - 1.0;
    let field = |x: f64, y: f64, z: f64| {
        let p = DVec3::new(at(x), at(y), at(z));
        libm::exp(-8.0 * p.length_squared()) * (1.0 + 0.4 * libm::sin(5.0 * p.x + 3.0 * p.y))
    };
    let points = [(0.0, [1.0, 0.2, 0.1], 0.0), (1.4, [0.3, 0.9, 1.0], 0.9)];
    Scene::new(common::grid([n; 3], placement, field).into(), transfer(&points, 0.5))
}

/// Change to a scene, the templates that draw it, and the order and the RMSE at 65³ samples that they must keep.
type TemplateCase<'a> = (&'a str, fn(&mut Scene), &'a [Connectivity], f64, f64);

/// The error against each pixel's own ray falls with the square of the voxel's size where templates are sampled between voxels, whatever the
/// operator. Nearest voxels leave the first order, but err to both sides alike: along a smooth ray little of it is left.
#[test]
fn templates_converge_with_the_voxel() {
    let continuous = &[Connectivity::Continuous, Connectivity::Faces][..];
    // The transfer function's kinks, at which the largest value and the cut turn sharply, are known to a voxel: half an order less.
    let cases: [TemplateCase<'_>; 6] = [
        ("over", |_| (), continuous, 1.8, 2e-4),
        ("over, voxels", |_| (), &[Connectivity::Discrete], 1.5, 4e-4),
        // Shading turns fast where the gradient is small.
        ("shaded", |scene| scene.shading = Some(Shading::default().into()), continuous, 1.0, 1e-3),
        ("average", |scene| scene.compositing = Compositing::Average, continuous, 1.5, 1e-3),
        ("maximum", |scene| scene.compositing = Compositing::Maximum, continuous, 1.5, 1e-3),
        ("accumulate", |scene| scene.compositing = Compositing::Accumulate { level: 0.4 }, continuous, 1.3, 1e-3),
    ];
    for (name, change, connectivities, least_order, largest) in cases {
        for &connectivity in connectivities {
            for (azimuth, elevation) in [(33.0, 21.0), (100.0, -40.0), (200.0, 5.0)] {
                let errors = [17, 65].map(|n| {
                    let mut scene = bump(n);
                    change(&mut scene);
                    let view = View::new(Camera::framing(scene.volume.bounds(), azimuth, elevation, None), [64, 64]);
                    let want = common::render(&RayCaster::uniform(0.2), &scene, &view).frame;
                    rms(&common::render(&template(connectivity, 0.2), &scene, &view).frame, &want)
                });
                let order = (errors[0] / errors[1]).log2() / 2.0;
                println!(
                    "{name}, {connectivity:?} from {azimuth}: order {order:.2}, errors {:.1e} {:.1e}",
                    errors[0], errors[1]
                );
                assert!(order >= least_order, "{name}, {connectivity:?} from {azimuth}: order {order}");
                assert!(errors[1] <= largest, "{name}, {connectivity:?} from {azimuth}: {}", errors[1]);
            }
        }
    }
}

/// Templates against the reference: shaded, under every operator, behind a surface and clipped.
#[test]
fn templates_agree_with_the_reference() {
    let plain = bump(41);
    let mut view = View::new(Camera::framing(plain.volume.bounds(), 33.0, 21.0, None), [24, 24]);
    view.clip.planes.push(Plane { normal: DVec3::new(1.0, 0.4, 0.2), offset: -0.35 });
    let distance = view.camera.eye.length() as f32;
    let wall = |i: u32| ([0.2, 0.1, 0.4], if i % 24 < 12 { distance } else { f32::INFINITY });
    let shading = Some(Shading::default().into());
    let under = |compositing| Scene { compositing, ..plain.clone() };
    let scenes = [
        ("shaded", Scene { shading: shading.clone(), ..plain.clone() }, 0.02),
        ("before a wall", FixedLayer::new(&view, wall).among(&plain), 0.02),
        ("maximum", under(Compositing::Maximum), 0.02),
        ("minimum", under(Compositing::Minimum), 0.02),
        ("average", under(Compositing::Average), 0.02),
        ("accumulate", under(Compositing::Accumulate { level: 0.3 }), 0.02),
        // The outline of a surface is as sharp as a voxel.
        ("first", Scene { shading, ..under(Compositing::First { threshold: 0.4 }) }, 0.6),
    ];
    for (name, scene, largest) in scenes {
        let want = common::truth(&scene, &view);
        for connectivity in [Connectivity::Continuous, Connectivity::Faces, Connectivity::Discrete] {
            let got = common::render(&template(connectivity, 0.3), &scene, &view).frame;
            let found = (max_error(&got, &want), rms(&got, &want));
            println!("{name}, {connectivity:?}: {:.1e}, RMSE {:.1e}", found.0, found.1);
            // A voxel's own value is half a voxel beside the ray.
            let largest = if connectivity == Connectivity::Discrete { 3.0 * largest } else { largest };
            assert!(found.0 <= largest && found.1 <= 0.1 * largest, "{name}, {connectivity:?}: {found:?}");
        }
    }
}

/// Rays that leap over what cannot be seen show the same, bit for bit.
#[test]
fn templates_leap() {
    let scene = balls(7, [33, 29, 37], Placement::from_spacing([1.0, 1.2, 0.9]).unwrap());
    let view = View::new(Camera::framing(scene.volume.bounds(), 30.0, 20.0, None), [40, 40]);
    for connectivity in [Connectivity::Continuous, Connectivity::Faces] {
        for compositing in [Compositing::Over, Compositing::First { threshold: 0.3 }] {
            let scene = Scene { compositing, ..scene.clone() };
            let by = |empty_space| {
                let caster = RayCaster { empty_space, ..template(connectivity, 0.5) };
                common::render(&caster, &scene, &view)
            };
            let want = by(EmptySpace::None);
            for empty_space in [EmptySpace::Auto, EmptySpace::Octree] {
                let got = by(empty_space);
                assert_same(&got.frame, &want.frame, &format!("{connectivity:?} {compositing:?} {empty_space:?}"));
                assert!(got.stats.counts.samples < want.stats.counts.samples);
            }
        }
    }
}

/// RMSE of templates on the hard cases: measured, and half as much again. Faces of the box and edges are as sharp as a voxel, which is a tenth of the picture
/// in the small cases.
#[test]
fn templates_survive_hard_cases() {
    let bound = |case: &Case| {
        DocumentedError::Rmse(match case.name {
            "opaque-wall" | "two-samples" => 0.13,
            "full-u16" | "marschner-lobb" => 0.1,
            "thin-shell" | "missing-voxels" => 0.08,
            "anisotropy" | "constant" => 0.05,
            "bright" | "grazing-rays" | "far-origin" => 0.04,
            "axis-aligned" | "faint" => 0.01,
            // Nothing but rounding.
            _ => 3e-7,
        })
    };
    for connectivity in [Connectivity::Continuous, Connectivity::Faces, Connectivity::Discrete] {
        let table = survives_hard_cases(&template(connectivity, 0.2), bound, &Reference::new(1e-5));
        println!("{}", table.unwrap_or_else(|e| panic!("{e}")));
    }
}

/// Along each axis both ways, with a pixel for each voxel, the template's rays are the pixels' own.
#[test]
fn along_an_axis_a_template_is_the_plain_caster() {
    let dims = [17, 13, 15];
    let placement = Placement::from_spacing([1.0, 1.0, 1.0]).unwrap();
    let mut scene = balls(11, dims, placement);
    scene.transfer = transfer(&[(-0.2, [1.0, 0.5, 0.2], 0.1), (0.9, [0.2, 1.0, 1.0], 0.8)], 1.0).into();
    let middle = DVec3::from_array(dims.map(|n| 0.5 * (n - 1) as f64));
    for (direction, up, [right, down]) in [
        (DVec3::Z, DVec3::Y, [0, 1]),
        (-DVec3::Z, DVec3::Y, [0, 1]),
        (DVec3::X, DVec3::Y, [2, 1]),
        (-DVec3::Y, DVec3::Z, [0, 2]),
    ] {
        let size = [dims[right] as u32, dims[down] as u32];
        let projection = Projection::Orthographic { height: f64::from(size[1]) };
        let camera = Camera { eye: middle - 40.0 * direction, target: middle, up, projection };
        for step in [0.3, 1.0, 2.5] {
            let view = View::new(camera, size);
            let want =
                common::render(&RayCaster { step: Step::Uniform(step), ..RayCaster::uniform(0.2) }, &scene, &view);
            let got = common::render(&template(Connectivity::Continuous, step), &scene, &view);
            // Rounding of f32 positions, which the template's weights do not have.
            assert!(max_error(&got.frame, &want.frame) < 2e-5, "{direction} {step}");
            let depths = got.frame.depth().unwrap().iter().zip(want.frame.depth().unwrap());
            for (a, b) in depths {
                assert!(a == b || (a - b).abs() < 1e-3, "{a} {b}");
            }
        }
    }
}

#[test]
fn a_discrete_template_sums_voxels() {
    // Three slices: half, whole and half a step; the last is the voxel's own value, however wild its neighbours are.
    let grid = common::grid([5, 5, 3], Placement::from_spacing([1.0, 1.0, 2.0]).unwrap(), |x, y, z| {
        if (x, y) == (2.0, 2.0) { [0.1, 0.2, 0.3][z as usize] } else { 0.9 }
    });
    let scene = Scene::new(grid.into(), transfer(&[(0.0, [1.0; 3], 0.0), (1.0, [1.0; 3], 1.0)], 1.0));
    let projection = Projection::Orthographic { height: 1.0 };
    let camera = Camera { eye: DVec3::new(2.0, 2.0, 9.0), target: DVec3::new(2.0, 2.0, 0.0), up: DVec3::Y, projection };
    let got = common::render(&template(Connectivity::Discrete, 1.0), &scene, &View::new(camera, [1, 1]));
    let clear = 0.9f64.powf(1.0) * 0.8f64.powf(2.0) * 0.7f64.powf(1.0);
    let alpha = 1.0 - clear;
    common::assert_close(got.frame.pixels()[0], [alpha; 4], 1e-5, "voxels");
}

#[test]
fn what_templates_cannot_do_is_said() {
    let scene = bump(9);
    let control = Control::default();
    let good = template(Connectivity::Continuous, 1.0);
    let refuses = |caster: &RayCaster, scene: &Scene, what: &str| match caster.prepare(scene, &control).err() {
        Some(RenderError::Unsupported(Unsupported { what: feature, .. })) => {
            assert!(feature.contains(what), "{feature}")
        }
        other => panic!("{what}: {other:?}"),
    };
    refuses(&RayCaster { step: Step::Local { error: 0.01 }, ..good.clone() }, &scene, "steps that each ray sets");
    refuses(&RayCaster { step: Step::ErrorBound(0.01), ..good.clone() }, &scene, "steps that each ray sets");
    refuses(&RayCaster { traversal: Traversal::Cells, ..good.clone() }, &scene, "template-faces");
    let voxels = template(Connectivity::Discrete, 1.0);
    refuses(&RayCaster { rule: Rule::Left, ..voxels.clone() }, &scene, "rule");
    refuses(&RayCaster { empty_space: EmptySpace::Octree, ..voxels }, &scene, "beside");
    let coherent = caster(ImageSampling::Coherent);
    refuses(&coherent, &Scene { compositing: Compositing::Average, ..scene.clone() }, "compositing");
    refuses(&RayCaster { rule: Rule::Quadratic, ..coherent.clone() }, &scene, "rule 'quadratic'");
    refuses(&RayCaster { traversal: Traversal::Cells, ..coherent }, &scene, "steps");
    let adaptive = caster(ImageSampling::Adaptive { threshold: 0.1 });
    refuses(&RayCaster { step: Step::ErrorBound(0.01), ..adaptive }, &scene, "promised");
    let mut prepared = good.prepare(&scene, &control).unwrap();
    let view = |fov| View::new(Camera::framing(scene.volume.bounds(), 0.0, 0.0, fov), [4, 4]);
    assert!(matches!(prepared.render(&view(Some(30.0)), &control), Err(RenderError::Unsupported { .. })));
    assert!(prepared.render(&view(None), &control).is_ok());
    let odd = caster(ImageSampling::Adaptive { threshold: f64::NAN });
    assert!(matches!(odd.prepare(&scene, &control), Err(RenderError::Option(_))));
}

#[test]
fn templates_keep_clips_and_holes() {
    let n = 41;
    let mut samples = Vec::new();
    for z in 0..n {
        for y in 0..n {
            for x in 0..n {
                let hole = (15..25).contains(&x) && (10..30).contains(&y) && z > 20;
                samples.push(if hole { f32::NAN } else { (x + y + z) as f32 / 120.0 });
            }
        }
    }
    let grid = UniformGrid::new([n; 3], samples, Placement::from_spacing([1.0; 3]).unwrap(), Calibration::default());
    let scene =
        Scene::new(grid.unwrap().into(), transfer(&[(0.0, [1.0, 0.5, 0.0], 0.02), (1.0, [0.0, 0.5, 1.0], 0.05)], 1.0));
    for (azimuth, elevation) in [(20.0, 30.0), (-75.0, 10.0)] {
        let mut view = View::new(Camera::framing(scene.volume.bounds(), azimuth, elevation, None), [80, 80]);
        view.clip.crop = Some((DVec3::new(3.0, 5.0, -9.0), DVec3::new(35.0, 60.0, 38.0)));
        view.clip.planes.push(Plane { normal: DVec3::new(1.0, 1.0, 1.0), offset: 30.0 });
        let want = common::render(&caster(ImageSampling::EveryPixel), &scene, &view).frame;
        // Faces of the clip and of the hole are known to a step and to a voxel, of which these have several per cent of opacity;
        // twice what was measured.
        for (connectivity, largest, mean) in [
            (Connectivity::Continuous, 0.13, 9e-3),
            (Connectivity::Faces, 0.13, 9e-3),
            (Connectivity::Discrete, 0.3, 3.2e-2),
        ] {
            let got = common::render(&template(connectivity, 0.5), &scene, &view).frame;
            let found = (max_error(&got, &want), rms(&got, &want));
            assert!(found.0 <= largest && found.1 <= mean, "{connectivity:?} from {azimuth}: {found:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any size, placement and clip; the same on any number of threads.
    #[test]
    fn inexact_screens_are_sound(
        seed in any::<u64>(),
        dims in prop::array::uniform3(2usize..30),
        axes in placements(),
        camera in cameras(),
        size in prop::array::uniform2(1u32..60),
        samples in 1u32..3,
        screen in prop::sample::select(vec![
            ImageSampling::Adaptive { threshold: 0.01 },
            ImageSampling::Template { connectivity: Connectivity::Continuous },
            ImageSampling::Template { connectivity: Connectivity::Discrete },
            ImageSampling::Template { connectivity: Connectivity::Faces },
        ]),
        shaded in any::<bool>(),
        compositing in prop::sample::select(vec![
            Compositing::Over,
            Compositing::Over,
            Compositing::First { threshold: 0.2 },
            Compositing::Maximum,
            Compositing::Average,
            Compositing::Accumulate { level: 0.5 },
        ]),
        layered in prop::bool::weighted(0.3),
        crop in prop::option::of((prop::array::uniform3(-1.0..0.0f64), prop::array::uniform3(0.01..1.0f64))),
    ) {
        let last = DVec3::from_array(dims.map(|n| (n - 1) as f64));
        let axes = axes * DMat3::from_diagonal(1.0 / last);
        let mut scene = balls(seed, dims, Placement::new(-0.5 * (axes * last), axes).unwrap());
        let is_template = matches!(screen, ImageSampling::Template { .. });
        let projection = if is_template { Projection::Orthographic { height: 1.5 } } else { camera.projection };
        // Cubics between adaptive rays leave the range of colours at the edges of surfaces.
        let (shaded, layered) = (shaded && is_template, layered && is_template);
        if is_template {
            scene.compositing = compositing;
            scene.shading = shaded.then(|| Shading::default().into());
        }
        let mut view = View::new(Camera { projection, ..camera }, size);
        view.supersampling = samples;
        view.clip.crop = crop.map(|(low, high)| (low.into(), high.into()));
        if layered {
            let pixel = |i: u32| ([0.1, 0.2, 0.3], if i.is_multiple_of(3) { f32::INFINITY } else { 1.0 + (i % 5) as f32 });
            scene = FixedLayer::new(&view, pixel).among(&scene);
        }
        let draw = |threads| {
            let control = Control::default().with_threads(threads);
            caster(screen).prepare(&scene, &control).unwrap().render(&view, &control).unwrap()
        };
        let (one, three) = (draw(1), draw(3));
        assert_same(&one.frame, &three.frame, "threads");
        prop_assert_eq!(one.stats.counts, three.stats.counts);
        for p in one.frame.pixels() {
            // A highlight adds to a colour, by 0.3 at most.
            let most = if shaded { 1.31 } else { 1.0 + 1e-5 };
            prop_assert!(p.iter().all(|x| x.is_finite() && (0.0..=most).contains(x)), "{:?}", p);
        }
    }
}

#[test]
fn adaptive_refines_whatever_traces() {
    let scene = of_phantom("hydrogen", 33);
    let view = View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, None), [120, 120]);
    for (step, traversal, rule) in [
        (Step::Uniform(1.0), Traversal::Cells, Rule::Quadratic),
        (Step::Auto, Traversal::Voxels, Rule::Midpoint),
        (Step::Local { error: 0.002 }, Traversal::Samples, Rule::Midpoint),
    ] {
        let draw = |screen| {
            common::render(
                &RayCaster { image_sampling: screen, step, traversal, rule, ..RayCaster::uniform(0.2) },
                &scene,
                &view,
            )
        };
        let want = draw(ImageSampling::EveryPixel);
        let got = draw(ImageSampling::Adaptive { threshold: 0.05 });
        assert!(max_error(&got.frame, &want.frame) <= 0.05, "{step:?} {traversal:?}");
        assert!(4 * got.stats.counts.rays < 3 * want.stats.counts.rays, "{step:?} {traversal:?}");
        assert_same(&draw(ImageSampling::Adaptive { threshold: 0.0 }).frame, &want.frame, "threshold 0");
    }
}
