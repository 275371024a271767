//! Properties that must hold whatever the scene: checked on random ones, and on the hard ones by name.

use crate::common::*;
use glam::{DMat3, DVec3};
use proptest::prelude::*;
use std::sync::Arc;
use vr_core::*;
use vr_physics::check::FixedLayer;
use vr_raycast::{CompositingOrder, RayCaster, Step};

/// A random small scene under `over`, colours within [0, 1], and a view of it.
fn scenes() -> impl Strategy<Value = (Scene, View)> {
    let dims = prop::array::uniform3(2usize..7);
    let spacing = prop::array::uniform3(0.2f64..3.0);
    let samples = prop::collection::vec(prop_oneof![9 => 0.0f32..1.0, 1 => Just(f32::NAN)], 216);
    let point = (0.0f64..1.0, prop::array::uniform3(0.0f64..1.0), prop_oneof![0.0f64..1.0, Just(1.0), Just(0.0)]);
    let points = prop::collection::vec(point, 1..5);
    let angles = (-180.0f64..180.0, -80.0f64..80.0, prop::option::of(20.0f64..90.0));
    let filter = prop::sample::select(&Filter::ALL[..]);
    (dims, spacing, samples, points, angles, filter).prop_map(|(dims, spacing, samples, mut points, angles, filter)| {
        let placement = Placement::from_spacing(spacing).unwrap();
        let samples = samples[..dims.iter().product()].to_vec();
        let grid = UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let scene = Scene::new(grid.into(), transfer(&points, 1.0)).with_filter(filter);
        let camera = Camera::framing(scene.volume.bounds(), angles.0, angles.1, angles.2);
        (scene, View::new(camera, [6, 6]))
    })
}

/// Two f32 sums of the same steps: 32 roundings a run, a few per step.
const TWO_SUMS: f64 = 1e-5;

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn front_to_back_is_back_to_front((scene, view) in scenes(), step in 0.05f64..3.0) {
        let forwards = render(&RayCaster { step: Step::Uniform(step), order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) }, &scene, &view).frame;
        let backwards = render(&RayCaster { step: Step::Uniform(step), order: CompositingOrder::BackToFront, ..RayCaster::uniform(0.2) }, &scene, &view).frame;
        prop_assert!(max_error(&forwards, &backwards) <= TWO_SUMS, "{}", max_error(&forwards, &backwards));
    }

    #[test]
    fn opacity_is_one_and_termination_keeps_its_promise((scene, view) in scenes(), step in 0.05f64..3.0, level in 0.5f64..1.0) {
        let whole = render(&RayCaster { step: Step::Uniform(step), order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) }, &scene, &view).frame;
        for p in whole.pixels() {
            prop_assert!((0.0..=1.0).contains(&p[3]), "{p:?}");
            // Colours in [0, 1] are a density emitter's: light does not exceed opacity, but for its own rounding.
            prop_assert!(p[..3].iter().all(|&c| c >= 0.0 && c <= p[3] + 1e-5), "{p:?}");
        }
        let early = RayCaster { step: Step::Uniform(step), order: CompositingOrder::FrontToBack { termination: level }, ..RayCaster::uniform(0.2) };
        let early = render(&early, &scene, &view).frame;
        prop_assert!(max_error(&early, &whole) <= 1.0 - level + TWO_SUMS);
    }

    #[test]
    fn powers_of_two_change_no_bit((scene, view) in scenes(), exponent in -40i32..40) {
        let (small, small_view) = scaled(&scene, &view, 2f64.powi(exponent));
        let caster = RayCaster::uniform(0.2);
        let (one, other) = (render(&caster, &scene, &view).frame, render(&caster, &small, &small_view).frame);
        prop_assert_eq!(one.pixels(), other.pixels());
    }

    #[test]
    fn table_is_near_exact_where_nothing_jumps((scene, view) in scenes()) {
        prop_assume!(!scene.transfer.has_jumps() && scene.transfer.points().iter().all(|p| p.opacity < 0.95));
        // Control points nearer to each other than two entries are a jump to the table.
        prop_assume!(scene.transfer.points().windows(2).all(|w| w[1].value - w[0].value > 1e-2));
        let exact = RayCaster { transfer_lookup: vr_raycast::TransferLookup::Exact, order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) };
        let table = RayCaster { transfer_lookup: vr_raycast::TransferLookup::Table, ..exact.clone() };
        let (a, b) = (render(&exact, &scene, &view).frame, render(&table, &scene, &view).frame);
        prop_assert!(max_error(&a, &b) <= 2e-4, "{}", max_error(&a, &b));
    }

    #[test]
    fn every_operator_takes_every_scene((scene, view) in scenes(), value in 0.0f64..1.0) {
        for compositing in [
            Compositing::First { threshold: value },
            Compositing::Average,
            Compositing::Maximum,
            Compositing::Minimum,
            Compositing::Accumulate { level: value.max(1e-3) },
        ] {
            for shading in [None, Some(Arc::new(Shading { gradient_opacity: vec![(0.0, 0.0), (1.0, 2.0)], ..Shading::default() }))] {
                let scene = Scene { compositing, shading, ..scene.clone() };
                let frame = render(&RayCaster::uniform(0.2), &scene, &view).frame;
                for (p, &d) in frame.pixels().iter().zip(frame.depth().unwrap()) {
                    prop_assert!(p.iter().all(|c| c.is_finite()) && (0.0..=1.0).contains(&p[3]), "{compositing:?}: {p:?}");
                    prop_assert!(d >= 0.0, "{compositing:?}: depth {d}");
                }
            }
        }
    }
}

fn grid_of(scene: &Scene) -> &UniformGrid<f32> {
    match scene.volume.grid().unwrap().values() {
        AnyGrid::F32(grid) => grid,
        other => panic!("an f32 grid, not {other:?}"),
    }
}

/// The scene in a world `s` times as large.
fn scaled(scene: &Scene, view: &View, s: f64) -> (Scene, View) {
    let grid = grid_of(scene);
    let p = grid.placement();
    let placement = Placement::new(p.origin() * s, p.axes() * s).unwrap();
    let grid = UniformGrid::new(grid.dims(), grid.samples().to_vec(), placement, grid.calibration()).unwrap();
    let t = &scene.transfer;
    let transfer = TransferFunction::new(t.points().to_vec(), t.rule(), t.unit_distance() * s).unwrap();
    let projection = match view.camera.projection {
        Projection::Orthographic { height } => Projection::Orthographic { height: height * s },
        perspective @ Projection::Perspective { .. } => perspective,
    };
    let camera = Camera { eye: view.camera.eye * s, target: view.camera.target * s, up: view.camera.up, projection };
    let volume = Volume::from(grid).with_filter(scene.volume.filter().unwrap());
    let scene = Scene { volume, transfer: Arc::new(transfer), ..scene.clone() };
    (scene, View { camera, ..view.clone() })
}

/// A bumpy field with two translucent layers.
fn bumpy() -> Scene {
    let field = |x: f64, y: f64, z: f64| 0.5 + 0.4 * (0.9 * x).sin() * (0.7 * y + 0.2).cos() * (0.8 * z + 0.5).sin();
    let c = [1.0, 0.6, 0.2];
    Scene::new(volume([12, 10, 9], field), transfer(&[(0.2, c, 0.0), (0.5, [0.1, 0.4, 0.9], 0.3), (0.9, c, 0.6)], 1.0))
}

#[test]
fn neither_threads_nor_a_second_look_change_a_bit() {
    let shading = Some(Arc::new(Shading::default()));
    let scene = Scene { shading, ..bumpy() };
    let view = View { supersampling: 2, ..oblique(&scene, 40) };
    let one = Control::default().with_threads(1);
    let two = Control::default().with_threads(2);
    let mut prepared = RayCaster::uniform(0.2).prepare(&scene, &one).unwrap();
    let first = prepared.render(&view, &one).unwrap();
    prepared.render(&oblique(&scene, 16), &one).unwrap();
    assert_eq!(first.frame, prepared.render(&view, &two).unwrap().frame);
    assert_eq!(first.stats.counts, prepared.render(&view, &two).unwrap().stats.counts);
}

#[test]
fn turned_by_ninety_degrees() {
    let scene = bumpy();
    let grid = grid_of(&scene);
    // (x, y, z) → (ny − 1 − y, x, z), of the data and of the world.
    let [nx, ny, nz] = grid.dims();
    let turned = volume([ny, nx, nz], |x, y, z| {
        f64::from(grid.samples()[((z as usize) * ny + (ny - 1 - x as usize)) * nx + y as usize])
    });
    let turn = |v: DVec3| DVec3::new(-v.y, v.x, v.z);
    let shift = DVec3::new((ny - 1) as f64, 0.0, 0.0);
    let view = oblique(&scene, 24);
    let camera = Camera {
        eye: turn(view.camera.eye) + shift,
        target: turn(view.camera.target) + shift,
        up: turn(view.camera.up),
        ..view.camera
    };
    let turned = Scene { volume: turned, ..scene.clone() };
    let caster = RayCaster::uniform(0.2);
    let error =
        max_error(&render(&caster, &scene, &view).frame, &render(&caster, &turned, &View { camera, ..view }).frame);
    // Positions are rounded to f32 differently (10⁻⁶ of a voxel), and steps begin elsewhere by as little.
    assert!(error <= TWO_SUMS, "{error}");
}

#[test]
fn radiance_is_linear_in_emission() {
    let with_emission = |e: [f64; 3]| {
        let mut scene = bumpy();
        let points = scene.transfer.points().iter();
        let points = points.map(|p| ControlPoint { emission: Some(std::array::from_fn(|c| e[c] * p.value)), ..*p });
        let transfer = TransferFunction::new(points.collect(), OpacityRule::Power, 1.0).unwrap();
        scene.transfer = Arc::new(transfer);
        let view = oblique(&scene, 16);
        render(&RayCaster { order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) }, &scene, &view).frame
    };
    let (a, b, sum) =
        (with_emission([1.0, 0.0, 0.25]), with_emission([0.5, 3.0, 0.0]), with_emission([1.5, 3.0, 0.25]));
    for ((a, b), sum) in a.pixels().iter().zip(b.pixels()).zip(sum.pixels()) {
        for c in 0..3 {
            assert!((a[c] + b[c] - sum[c]).abs() <= 1e-6 * sum[c].max(1.0), "{a:?} + {b:?}, {sum:?}");
        }
    }
}

#[test]
fn far_origins_and_flat_voxels() {
    // The same field in a world of spacing 10⁻³ a million units away. f64 leaves 10⁻¹⁰ of position there, 10⁻⁷ of a voxel.
    let near = bumpy();
    let (small, view) = scaled(&near, &oblique(&near, 24), 1e-3);
    let grid = grid_of(&small);
    let away = DVec3::new(1e6, -1e6, 1e6);
    let placement = Placement::new(away, grid.placement().axes()).unwrap();
    let grid = UniformGrid::new(grid.dims(), grid.samples().to_vec(), placement, grid.calibration()).unwrap();
    let far = Scene { volume: grid.into(), ..small.clone() };
    let camera = Camera { eye: view.camera.eye + away, target: view.camera.target + away, ..view.camera };
    let caster = RayCaster::uniform(0.2);
    let there = render(&caster, &far, &View { camera, ..view.clone() }).frame;
    let error = max_error(&render(&caster, &small, &view).frame, &there);
    assert!(error < 1e-4, "{error}");

    // 1 : 1 : 50, homogeneous: the chord alone decides, and steps are fractions of the *smallest* edge.
    let placement = Placement::oriented(DVec3::ZERO, [1.0, 1.0, 50.0], DMat3::IDENTITY).unwrap();
    let flat = Scene::new(grid_of_ones([3, 3, 3], placement), homogeneous(0.01));
    let picture = render(&caster, &flat, &down(1.0, 1.0));
    assert_close(picture.frame.pixels()[0], [1.0 - 0.99f64.powi(100); 4], 1e-5, "flat voxels");
    assert_eq!(picture.stats.counts.samples, (100.0 / 0.2) as u64);
}

fn grid_of_ones(dims: [usize; 3], placement: Placement) -> Volume {
    grid(dims, placement, |_, _, _| 1.0).into()
}

#[test]
fn from_inside() {
    let scene = Scene::new(volume([9; 3], |_, _, _| 1.0), homogeneous(0.2));
    let eye = DVec3::splat(4.0);
    let projection = Projection::Perspective { fov: 60.0 };
    let view = View::new(Camera { eye, target: eye - DVec3::Z, up: DVec3::Y, projection }, [1, 1]);
    assert_close(
        pixel(&RayCaster::uniform(0.2), &scene, &view).0,
        [1.0 - 0.8f64.powi(4); 4],
        1e-6,
        "four units to the face",
    );
}

#[test]
fn layers_hide_and_are_seen_through() {
    let scene = Scene::new(volume([9; 3], |_, _, _| 1.0), homogeneous(0.5));
    let view = down(4.0, 4.0);
    let walled = |depth| FixedLayer::new(&view, |_| ([0.0, 0.8, 0.0], depth)).among(&scene);
    // Two units of the volume lie before the layer.
    let (rgba, depth) = pixel(&RayCaster::uniform(0.2), &walled(994.0), &view);
    assert_close(rgba, [0.75, 0.75 + 0.25 * 0.8, 0.75, 1.0], 1e-6, "two units before the layer");
    assert!((depth - 993.0).abs() < 1e-3, "half way at one unit: {depth}");
    // All of it, and the layer before it.
    assert_eq!(pixel(&RayCaster::uniform(0.2), &walled(10.0), &view), ([0.0, 0.8, 0.0, 1.0], 10.0));
    assert_eq!(
        pixel(&RayCaster::uniform(0.2), &walled(f32::INFINITY), &view).0,
        pixel(&RayCaster::uniform(0.2), &scene, &down(4.0, 4.0)).0
    );
}

#[test]
fn update_is_prepare() {
    let control = Control::default();
    let old = bumpy();
    let view = oblique(&old, 16);
    let c = [0.3, 0.9, 0.4];
    let variants = [
        Scene { transfer: Arc::new(transfer(&[(0.1, c, 0.2), (0.8, c, 0.4)], 1.0)), ..old.clone() },
        old.with_filter(Filter::BSpline),
        Scene { shading: Some(Arc::new(Shading::default())), ..old.clone() },
        Scene { compositing: Compositing::Average, ..old.clone() },
        Scene { volume: volume([5; 3], |x, y, z| 0.1 * (x + y + z)), ..old.clone() },
        old.clone(),
    ];
    let mut prepared = RayCaster::uniform(0.2).prepare(&old, &control).unwrap();
    for new in &variants {
        prepared.update(new, &control).unwrap();
        assert_eq!(prepared.render(&view, &control).unwrap().frame, render(&RayCaster::uniform(0.2), new, &view).frame);
    }
}

#[test]
fn what_cannot_be_drawn_is_said() {
    let control = Control::default();
    let backwards = RayCaster { order: CompositingOrder::BackToFront, ..RayCaster::uniform(0.2) };
    let scene = Scene { compositing: Compositing::Maximum, ..bumpy() };
    let error = backwards.prepare(&scene, &control).err().unwrap();
    assert!(matches!(error, RenderError::Unsupported(Unsupported { renderer: "raycast", .. })), "{error}");
    let early = RayCaster { order: CompositingOrder::FrontToBack { termination: 0.5 }, ..RayCaster::uniform(0.2) };
    let error = early.prepare(&scene, &control).err().unwrap();
    assert!(error.to_string().contains("a termination under 'maximum'"), "{error}");
    for step in [0.0, -1.0, f64::NAN, 65.0] {
        let caster = RayCaster { step: Step::Uniform(step), ..RayCaster::uniform(0.2) };
        assert!(matches!(caster.prepare(&bumpy(), &control), Err(RenderError::Option(_))), "{step}");
    }
    control.cancel_flag().store(true, std::sync::atomic::Ordering::Relaxed);
    assert!(matches!(RayCaster::uniform(0.2).prepare(&bumpy(), &control), Err(RenderError::Cancelled)));
}

#[test]
fn another_filter_is_another_model() {
    let scene = bumpy();
    let model = |filter| {
        let prepared = RayCaster { filter, ..RayCaster::uniform(0.2) }.prepare(&scene, &Control::default()).unwrap();
        prepared.model(&oblique(&scene, 4)).unwrap()
    };
    assert!(matches!(model(None), Model::Canonical));
    assert!(matches!(model(Some(Filter::Trilinear)), Model::Canonical));
    assert!(matches!(model(Some(Filter::BSpline)), Model::Filtered(Filter::BSpline)));
}

#[test]
fn shaded_ramps() {
    // A ramp along z seen along z by a headlight: n·l = n·h = 1, and the colour becomes c (ka + kd) + ks.
    let ramp = grid([3, 3, 9], Placement::from_spacing([1.0, 1.0, 0.5]).unwrap(), |_, _, z| 1.0 - 0.1 * z);
    for gradient in [GradientMethod::CentralDifferences, GradientMethod::Analytic] {
        let shading = Shading { gradient, ..Shading::default() };
        let c = [0.5, 0.25, 0.0];
        let mut scene = Scene::new(ramp.clone().into(), transfer(&[(0.0, c, 0.4)], 1.0));
        scene.shading = Some(Arc::new(shading.clone()));
        let shaded = c.map(|c| c * 0.9 + 0.3);
        let alpha = 1.0 - 0.6f64.powi(4);
        let want = [shaded[0] * alpha, shaded[1] * alpha, shaded[2] * alpha, alpha];
        assert_close(pixel(&RayCaster::uniform(0.2), &scene, &down(1.0, 1.0)).0, want, 1e-6, "over");
        scene.compositing = Compositing::First { threshold: 0.55 };
        let (rgba, _) = pixel(&RayCaster::uniform(0.2), &scene, &down(1.0, 1.0));
        assert_close(rgba, [shaded[0], shaded[1], shaded[2], 1.0], 1e-6, "first");
        // The slope is 0.2 a world unit: a factor of 0.25 on κ, whatever classifies.
        let faint = Shading { gradient_opacity: vec![(0.0, 0.0), (0.8, 1.0)], ..shading };
        scene.shading = Some(Arc::new(faint));
        scene.compositing = Compositing::Over;
        let alpha = 1.0 - 0.6f64;
        let want = [shaded[0] * alpha, shaded[1] * alpha, shaded[2] * alpha, alpha];
        for caster in [RayCaster::uniform(0.2), RayCaster::exact(0.3)] {
            assert_close(pixel(&caster, &scene, &down(1.0, 1.0)).0, want, 1e-5, "gradient opacity");
        }
    }
}
