//! A picture brick by brick is the picture through one texture, bit for bit: whatever the texture, the operator, the blend and the shading.

use std::sync::Arc;

use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, RngSeed};
use vr_core::*;
use vr_physics::check::TestScene;
use vr_physics::check::pictures::*;
use vr_physics::check::strategies::Kind;
use vr_texslice::{Blend, Format, Proxy, TextureSlicer};

use crate::every_setting::{self, FORMATS, PROXIES, alike_in_every_setting, layered, random_scene};

/// Mebibytes for bricks: all of those with the smallest texels, and three or so of those with the largest.
const BUDGET: f64 = 0.06;

/// Returns the pictures through one texture and through bricks within a small budget; `None` if both are refused.
fn both(renderer: &TextureSlicer, edge: u32, scene: &Scene, view: &View) -> Option<[Rendered; 2]> {
    let bricked = TextureSlicer { brick: Some(edge), budget: BUDGET, ..renderer.clone() };
    every_setting::both([renderer.clone(), bricked], scene, view)
}

/// Grey fog of three bricks of eight cells along each axis, the last ones smaller.
fn grey<T: phantom::Quantize>() -> Scene
where
    AnyGrid: From<UniformGrid<T>>,
{
    every_setting::grey::<T>(22)
}

fn views(scene: &Scene) -> Vec<View> {
    every_setting::views(scene, [22, 19], [90.0, 0.0])
}

/// The same with a lone missing voxel on a face of bricks, and a wall of missing ones.
fn holed(scene: Scene) -> Scene {
    let grid = scene.volume.grid().unwrap();
    let [nx, ny, nz] = grid.dims();
    let mut samples = grid.filled_floats().unwrap().to_vec();
    for (i, sample) in samples.iter_mut().enumerate() {
        let [x, y, z] = [i % nx, i / nx % ny, i / (nx * ny)];
        if [x, y, z] == [8, 9, 11] || (z == 7 && x < 10) {
            *sample = f32::NAN;
        }
    }
    let holed = UniformGrid::new([nx, ny, nz], samples, *grid.placement(), grid.calibration()).unwrap();
    Scene { volume: holed.into(), ..scene }
}

#[test]
fn every_texture_operator_blend_and_shading() {
    let bytes = grey::<u8>();
    let floats = holed(grey::<f32>());
    let (mut drawn, mut fragments) = (0, 0);
    for scene in [bytes, floats] {
        // Slabs shorter than a voxel, and longer than a brick; of a stack two to a layer, and one.
        let spacing = |view| if view % 2 == 0 { 0.8 } else { 9.3 };
        let in_both = |renderer: &TextureSlicer, scene: &Scene, view: &View| both(renderer, 8, scene, view);
        let found = alike_in_every_setting(&scene, &views(&scene), spacing, in_both);
        (drawn, fragments) = (drawn + found.0, fragments + found.1);
    }
    println!("{drawn} pictures in both ways, {fragments} fragments");
    assert!(drawn > 300 && fragments > 1_000_000, "{drawn} {fragments}");
}

#[test]
fn what_cannot_be_seen_is_not_loaded() {
    let blobs = phantom_scene::<u8>("blobs", 48, 1.0);
    let shaded = Scene { shading: Some(Arc::new(Shading::default())), ..blobs.clone() };
    let formats = [Format::Scalar, Format::PreIntegrated, Format::Compressed, Format::Rgba, Format::Paletted];
    let stacks = formats.map(|format| (format, Proxy::Stacks));
    for (format, proxy) in formats.map(|format| (format, Proxy::Planes)).into_iter().chain(stacks) {
        for (scene, slice_spacing) in [(&blobs, 0.7), (&shaded, 0.7), (&shaded, 7.0)] {
            for fov in [None, Some(60.0)] {
                let view = view(scene, 33.0, 21.0, fov, 32);
                let brute = TextureSlicer { format, proxy, slice_spacing, ..TextureSlicer::brute_force() };
                let all = draw(&brute, scene, &view);
                let skipping = TextureSlicer { skip_empty_space: true, ..brute };
                let [whole, bricks] = both(&skipping, 10, scene, &view).expect("it can draw this");
                assert!(all.frame == whole.frame && whole.frame == bricks.frame, "{format:?} {slice_spacing} {fov:?}");
                let least = if slice_spacing < 1.0 { 400 } else { 50 };
                assert!(bricks.stats.counts.skipped > least, "{format:?} {slice_spacing}: {:?}", bricks.stats.counts);
                let ending = TextureSlicer { termination: 0.9999, ..skipping };
                let [whole, bricks] = both(&ending, 10, scene, &view).expect("it can draw this");
                assert!(whole.frame == bricks.frame, "{format:?} {slice_spacing} {fov:?}");
            }
        }
    }
}

#[test]
fn several_samples_a_pixel_opaque_layers_and_threads() {
    let scene = Scene { shading: Some(Arc::new(Shading::default())), ..grey::<u16>() };
    let stacks = FORMATS.map(|format| (format, Proxy::Stacks));
    for view in views(&scene).into_iter().skip(1) {
        let several = View { supersampling: 2, ..view.clone() };
        let layered = layered(&scene, &view);
        for (format, proxy) in FORMATS.map(|format| (format, Proxy::Planes)).into_iter().chain(stacks) {
            let renderer = TextureSlicer { format, proxy, ..TextureSlicer::default() };
            for (scene, view) in [(&scene, &several), (&layered, &view)] {
                let [whole, bricks] = both(&renderer, 9, scene, view).expect("it can draw this");
                assert!(whole.frame == bricks.frame, "{format:?} {:?}", view.camera);
                let one = Control::default().with_threads(1);
                let bricked = TextureSlicer { brick: Some(9), ..renderer.clone() };
                let alone = bricked.prepare(scene, &one).unwrap().render(view, &one).unwrap();
                assert!(alone.frame == bricks.frame, "{format:?}");
            }
        }
    }
}

/// Returns the bytes that a renderer says it needs, and the bytes that it has.
fn refused(renderer: &TextureSlicer, scene: &Scene, view: &View) -> Option<[u64; 2]> {
    let control = Control::default();
    match renderer.prepare(scene, &control).and_then(|mut prepared| prepared.render(view, &control)) {
        Ok(_) => None,
        Err(RenderError::TooLarge { what, bytes, limit }) if what.contains("a brick") => Some([bytes, limit]),
        Err(other) => panic!("{renderer:?}: {other}"),
    }
}

/// Checks that a renderer with bricks of eight cells needs so many bytes.
fn needs(renderer: TextureSlicer, scene: &Scene, bytes: u64) {
    let view = view(scene, 20.0, 10.0, None, 8);
    let with = |bytes: u64| TextureSlicer { brick: Some(8), budget: bytes as f64 / 1_048_576.0, ..renderer.clone() };
    assert_eq!(refused(&with(bytes - 1), scene, &view), Some([bytes, bytes - 1]), "{renderer:?}");
    assert_eq!(refused(&with(bytes), scene, &view), None, "{renderer:?}");
}

#[test]
fn a_budget_needs_room_for_one_brick() {
    let plain = grey::<f32>();
    let shaded = Scene { shading: Some(Arc::new(Shading::default())), ..plain.clone() };
    let holes = holed(shaded.clone());
    // Nine texels along an edge; gradients reach one further on both sides, and beside holes are of values of their own.
    for (scene, format, texels, texel, beside) in [
        (&plain, Format::Scalar, 729, 4, 0),
        (&shaded, Format::Scalar, 1331, 4, 0),
        (&holes, Format::PreIntegrated, 1331, 8, 0),
        // Six blocks of 40 bytes along each axis stay beside the bricks.
        (&plain, Format::Compressed, 729, 4, 216 * 40),
        (&shaded, Format::Rgba, 729, 16, 0),
        (&shaded, Format::LuminanceAlpha, 729, 8, 0),
        (&plain, Format::Paletted, 729, 1, 0),
        (&shaded, Format::Paletted, 729, 25, 0),
    ] {
        needs(TextureSlicer { format, ..TextureSlicer::default() }, scene, texels * texel + beside);
    }
    let holed_plain = holed(plain.clone());
    for (scene, format, texels, texel) in [
        (&plain, Format::PreIntegrated, 729, 4),
        (&shaded, Format::Scalar, 1331, 4),
        // Beside holes a layer belongs to the cells before it, too; and the middle of a segment may lie in these.
        (&holed_plain, Format::Scalar, 810, 4),
        (&holes, Format::Scalar, 1331, 8),
        (&holes, Format::PreIntegrated, 1452, 8),
        (&shaded, Format::Rgba, 729, 16),
        (&holed_plain, Format::Rgba, 810, 16),
        (&holes, Format::Paletted, 810, 25),
    ] {
        needs(TextureSlicer { format, proxy: Proxy::Stacks, ..TextureSlicer::default() }, scene, texels * texel);
    }
}

#[test]
fn bricks_stay_until_they_are_of_no_use() {
    let scene = Scene { shading: Some(Arc::new(Shading::default())), ..phantom_scene::<u8>("fog", 22, 1.0) };
    let recolored = Scene { transfer: phantom_scene::<u8>("fog", 8, 0.3).transfer, ..scene.clone() };
    let side = Light { direction: Some(glam::DVec3::new(1.0, -0.4, 0.3)), color: [0.6; 3] };
    let relit = Scene { lights: vec![side], ..recolored.clone() };
    let unlit = Scene { shading: None, ..relit.clone() };
    let control = Control::default();
    for (format, again) in [
        // Values stay but for their apron; light goes with all that it depends on; indices stay where only colours are new.
        (Format::Scalar, [true, false, false, false, false, true]),
        (Format::PreIntegrated, [true, false, false, false, false, true]),
        (Format::Compressed, [true, false, false, false, false, true]),
        (Format::Rgba, [true, false, true, true, true, true]),
        (Format::Paletted, [true, false, false, true, true, true]),
    ] {
        let renderer = TextureSlicer { format, brick: Some(8), ..TextureSlicer::default() };
        let mut prepared = renderer.prepare(&scene, &control).unwrap();
        let turns =
            [(&scene, 20.0), (&scene, 20.0), (&recolored, 20.0), (&recolored, 50.0), (&relit, 50.0), (&unlit, 50.0)];
        for ((scene, azimuth), again) in turns.into_iter().zip(again) {
            let view = view(scene, azimuth, 10.0, None, 16);
            prepared.update(scene, &control).unwrap();
            let drawn = prepared.render(&view, &control).unwrap();
            let loaded = drawn.stats.stages.iter().any(|(stage, _)| *stage == "brick");
            assert_eq!(loaded, again, "{format:?} {azimuth}: {:?}", drawn.stats.stages);
            assert!(drawn.frame == draw(&renderer, scene, &view).frame, "{format:?} {azimuth}");
        }
    }
}

fn renderer() -> impl Strategy<Value = (TextureSlicer, u32)> {
    let choice = (prop::sample::select(FORMATS.to_vec()), prop::sample::select(PROXIES.to_vec()));
    (choice, any::<[bool; 3]>(), 0.3..12.0f64, 8..12u32).prop_map(
        |((format, proxy), [back, skips, ends], slice_spacing, edge)| {
            let blend = if back { Blend::BackToFront } else { Blend::FrontToBack };
            let termination = if ends && !back { TextureSlicer::default().termination } else { 1.0 };
            let renderer = TextureSlicer {
                format,
                proxy,
                blend,
                slice_spacing,
                skip_empty_space: skips,
                termination,
                ..TextureSlicer::default()
            };
            (renderer, edge)
        },
    )
}

#[test]
fn random_scenes_of_every_kind() {
    let config = ProptestConfig {
        cases: 300,
        failure_persistence: None,
        rng_algorithm: RngAlgorithm::ChaCha,
        rng_seed: RngSeed::Fixed(0xb1c5),
        ..ProptestConfig::default()
    };
    let drawn = std::cell::Cell::new(0);
    proptest!(config, |((renderer, edge) in renderer(), test in random_scene(&Kind::ALL))| {
        let TestScene { scene, view } = &test;
        if let Some([whole, bricks]) = both(&renderer, edge, scene, view) {
            drawn.set(drawn.get() + 1);
            prop_assert!(whole.frame == bricks.frame);
            let [a, b] = [whole.stats.counts, bricks.stats.counts];
            prop_assert_eq!(a.rays, b.rays);
        }
    });
    println!("{} pictures in both ways", drawn.get());
    assert!(drawn.get() > 100);
}
