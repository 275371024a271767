//! A picture slice by slice is the picture tile by tile, bit for bit: each slab's triangles are rasterised, and its fragments go through the same stages.

use std::sync::Arc;

use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, RngSeed};
use vr_core::*;
use vr_physics::check::TestScene;
use vr_physics::check::pictures::*;
use vr_physics::check::strategies::Kind;
use vr_texslice::{Blend, DrawOrder, Format, TextureSlicer};

use crate::every_setting::{self, FORMATS, PROXIES, alike_in_every_setting, both, layered, random_scene};

/// Returns the pictures in both orders, tiles first; `None` if both orders refuse.
fn in_both_orders(renderer: &TextureSlicer, scene: &Scene, view: &View) -> Option<[Rendered; 2]> {
    let of = |order| TextureSlicer { order, ..renderer.clone() };
    both([of(DrawOrder::Tiles), of(DrawOrder::Slices)], scene, view)
}

/// Grey fog in a small box.
fn grey() -> Scene {
    every_setting::grey::<u8>(14)
}

/// Pictures 23 pixels high: no multiple of four.
fn views(scene: &Scene) -> Vec<View> {
    every_setting::views(scene, [26, 23], [33.0, 21.0])
}

#[test]
fn every_texture_operator_blend_and_proxy() {
    let scene = grey();
    let (drawn, fragments) = alike_in_every_setting(&scene, &views(&scene), |_| 0.8, in_both_orders);
    println!("{drawn} pictures in both orders, {fragments} fragments");
    assert!(drawn > 300 && fragments > 1_000_000, "{drawn} {fragments}");
}

#[test]
fn several_samples_a_pixel_and_opaque_layers() {
    let scene = grey();
    for view in views(&scene) {
        let several = View { supersampling: 3, ..view.clone() };
        let layered = layered(&scene, &view);
        for proxy in PROXIES {
            for format in [Format::Scalar, Format::PreIntegrated, Format::Compressed, Format::Rgba] {
                let renderer = TextureSlicer { format, proxy, ..TextureSlicer::default() };
                for (scene, view) in [(&scene, &several), (&layered, &view)] {
                    let [tiles, slices] = in_both_orders(&renderer, scene, view).expect("it can draw this");
                    assert!(tiles.frame == slices.frame, "{renderer:?} {:?}", view.camera);
                    assert!(slices.stats.counts.samples > 100);
                }
            }
        }
    }
}

#[test]
fn what_cannot_be_seen_is_left_out_and_opaque_pixels_end() {
    let blobs = phantom_scene::<u8>("blobs", 48, 1.0);
    let view = view(&blobs, 33.0, 21.0, None, 32);
    for format in [Format::Scalar, Format::PreIntegrated, Format::Rgba] {
        let of = |skip_empty_space| {
            let renderer = TextureSlicer { format, skip_empty_space, ..TextureSlicer::brute_force() };
            in_both_orders(&renderer, &blobs, &view).expect("it can draw this")
        };
        let ([_, some], [tiles, all]) = (of(true), of(false));
        assert!(some.frame == all.frame && some.frame == tiles.frame, "{format:?}");
        let (some, all) = (some.stats.counts, all.stats.counts);
        assert!(some.skipped > 1000 && all.skipped == 0, "{format:?}: {some:?} {all:?}");
        assert_eq!(some.samples + some.skipped, all.samples, "{format:?}");
    }
    let mut dense = blobs.clone();
    let opaque = ControlPoint::new(0.0, [0.9, 0.5, 0.2], 0.9);
    dense.transfer = Arc::new(TransferFunction::new(vec![opaque], OpacityRule::Power, 0.01).unwrap());
    let [tiles, slices] = in_both_orders(&TextureSlicer::default(), &dense, &view).expect("it can draw this");
    let all = draw(&TextureSlicer::brute_force(), &dense, &view).stats.counts.samples;
    assert!(tiles.frame == slices.frame);
    assert_eq!(tiles.stats.counts.samples, slices.stats.counts.samples);
    assert!(slices.stats.counts.samples < all / 4);
}

#[test]
fn threads_change_nothing() {
    let scene = grey();
    let view = view(&scene, 33.0, 21.0, Some(30.0), 70);
    let renderer = TextureSlicer { order: DrawOrder::Slices, ..TextureSlicer::default() };
    let with = |threads| {
        let control = Control::default().with_threads(threads);
        renderer.prepare(&scene, &control).unwrap().render(&view, &control).unwrap().frame
    };
    assert_eq!(with(1), with(3));
}

fn renderer() -> impl Strategy<Value = TextureSlicer> {
    let choice = (prop::sample::select(FORMATS.to_vec()), prop::sample::select(PROXIES.to_vec()));
    (choice, any::<bool>(), any::<bool>(), 0.3..2.0f64).prop_map(|((format, proxy), back, skips, slice_spacing)| {
        let blend = if back { Blend::BackToFront } else { Blend::FrontToBack };
        TextureSlicer { format, proxy, blend, slice_spacing, skip_empty_space: skips, ..TextureSlicer::brute_force() }
    })
}

#[test]
fn random_scenes_of_every_kind() {
    let config = ProptestConfig {
        cases: 600,
        failure_persistence: None,
        rng_algorithm: RngAlgorithm::ChaCha,
        rng_seed: RngSeed::Fixed(0x5eed),
        ..ProptestConfig::default()
    };
    let drawn = std::cell::Cell::new(0);
    proptest!(config, |(renderer in renderer(), test in random_scene(&Kind::ALL))| {
        let TestScene { scene, view } = &test;
        if let Some([tiles, slices]) = in_both_orders(&renderer, scene, view) {
            drawn.set(drawn.get() + 1);
            prop_assert!(tiles.frame == slices.frame);
            let [a, b] = [tiles.stats.counts, slices.stats.counts];
            prop_assert_eq!(a.rays, b.rays);
            prop_assert_eq!(a.samples + a.skipped, b.samples + b.skipped);
        }
    });
    println!("{} pictures in both orders", drawn.get());
    assert!(drawn.get() > 150);
}
