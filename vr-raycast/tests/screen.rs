//! Which rays are cast: pictures that must be the same, and pictures that may differ by a bound.

mod common;

use common::{max_error, transfer, volume};
use glam::{DMat3, DVec3};
use proptest::prelude::*;
use vr_core::*;
use vr_raycast::{Order, RayCaster, Screen, Step};

fn caster(screen: Screen) -> RayCaster {
    RayCaster { screen, step: Step::Uniform(0.5), ..RayCaster::default() }
}

/// A scene of balls in a clear box, of any placement.
fn balls(seed: u64, dims: [usize; 3], placement: Placement) -> Scene {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
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

/// Draws views one after the other both ways; returns the samples that either took.
fn assert_coherent(scene: &Scene, views: &[View], order: Order) -> (u64, u64) {
    let control = Control::default();
    let prepare = |screen| RayCaster { order, ..caster(screen) }.prepare(scene, &control).unwrap();
    let (mut plain, mut coherent) = (prepare(Screen::EveryPixel), prepare(Screen::Coherent));
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
        let (with, without) = assert_coherent(&scene, &views, Order::default());
        assert!(3 * with < without, "{with} of {without} samples");
        // The same view again: what the first picture met is known now, and fewer samples are taken.
        let mut prepared = caster(Screen::Coherent).prepare(&scene, &Control::default()).unwrap();
        let samples = [(); 3].map(|()| prepared.render(&views[0], &Control::default()).unwrap().stats.counts.samples);
        assert!(samples[1] < samples[0] && samples[2] <= samples[1], "{samples:?}");
    }
}

#[test]
fn a_changed_transfer_function_is_seen() {
    let mut scene = balls(5, [30; 3], Placement::from_spacing([1.0; 3]).unwrap());
    let control = Control::default();
    let view = View::new(Camera::framing(scene.volume.bounds(), 40.0, 20.0, None), [40, 40]);
    let mut coherent = caster(Screen::Coherent).prepare(&scene, &control).unwrap();
    for low in [0.5, 0.1, 0.3] {
        let points = [(low, [1.0; 3], 0.0), (low + 0.1, [1.0, 0.0, 0.0], 0.7)];
        scene.transfer = transfer(&points, 1.0).into();
        coherent.update(&scene, &control).unwrap();
        let want = caster(Screen::EveryPixel).prepare(&scene, &control).unwrap().render(&view, &control).unwrap();
        for _ in 0..2 {
            assert_same(&coherent.render(&view, &control).unwrap().frame, &want.frame, "after a change");
        }
    }
}

fn cameras() -> impl Strategy<Value = Camera> {
    let point = || prop::array::uniform3(-1.0..1.0f64).prop_map(DVec3::from);
    (point(), 0.2..3.0f64, point(), prop::option::of(20.0..100.0f64), 0.4..2.5f64).prop_filter_map(
        "a direction",
        |(direction, distance, target, fov, height)| {
            let eye = target + direction.try_normalize()? * distance;
            let projection =
                fov.map_or(Projection::Orthographic { height }, |fov| Projection::Perspective { fov });
            let camera = Camera { eye, target: 0.3 * target, up: DVec3::new(0.1, 1.0, 0.2), projection };
            camera.frame().ok().map(|_| camera)
        },
    )
}

fn placements() -> impl Strategy<Value = DMat3> {
    prop::array::uniform9(-0.4..0.4f64).prop_map(|m| {
        DMat3::from_cols_array(&m) + DMat3::from_diagonal(DVec3::new(1.0, 0.8, 1.5))
    })
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
        crop in prop::option::of((prop::array::uniform3(-1.0..0.0f64), prop::array::uniform3(0.0..1.0f64))),
        plane in prop::option::of(prop::array::uniform3(-1.0..1.0f64)),
        layered in prop::option::of(0.5..4.0f32),
        backwards in any::<bool>(),
    ) {
        // The box is about as large as the cameras' world.
        let last = DVec3::from_array(dims.map(|n| (n - 1) as f64));
        let axes = axes * DMat3::from_diagonal(1.0 / last);
        let placement = Placement::new(-0.5 * (axes * last), axes).unwrap();
        let mut scene = balls(seed, dims, placement);
        scene.transfer = transfer(&[(0.05, [1.0, 0.5, 0.2], 0.0), (0.9, [1.0; 3], 0.95)], 0.1).into();
        let views: Vec<View> = cameras.into_iter().map(|camera| {
            let mut view = View::new(camera, size);
            view.samples = samples;
            view.clip.crop = crop.map(|(low, high)| (DVec3::from(low) * 0.7, DVec3::from(high) * 0.7 + 0.01));
            view.clip.planes.extend(plane.map(|n| Plane { normal: DVec3::from(n) + 0.01, offset: -0.1 }));
            view.layer = layered.map(|depth| {
                let pixel = |i: u32| ([0.1, 0.2, 0.3], if i % 3 == 0 { f32::INFINITY } else { depth });
                std::sync::Arc::new(Layer { pixels: (0..size[0] * size[1]).map(pixel).collect() })
            });
            view
        }).collect();
        assert_coherent(&scene, &views, if backwards { Order::BackToFront } else { Order::default() });
    }
}

#[test]
fn adaptive_with_no_threshold_is_every_pixel() {
    let scene = balls(1, [20; 3], Placement::from_spacing([1.0; 3]).unwrap());
    let view = View::new(Camera::framing(scene.volume.bounds(), 30.0, 20.0, None), [53, 31]);
    let draw = |screen| common::render(&caster(screen), &scene, &view).frame;
    assert_same(&draw(Screen::Adaptive { threshold: 0.0 }), &draw(Screen::EveryPixel), "threshold 0");
}
