//! Depths under every operator, and first points in every texture of values.

use std::sync::Arc;

use vr_core::*;
use vr_physics::check::pictures::*;
use vr_physics::{Metrics, Pixel, Reference};
use vr_texslice::{Blend, Format, Proxy, TextureSlicer};

const VIEWS: [(f64, f64, Option<f64>); 3] = [(0.0, 0.0, None), (33.0, 21.0, None), (-60.0, 50.0, Some(35.0))];

fn truth(scene: &Scene, view: &View) -> Vec<Pixel> {
    Reference::new(1e-7).solve(scene, view, &Model::Canonical, &Control::default()).unwrap().pixels
}

#[test]
fn the_order_of_blending_does_not_move_what_is_seen() {
    let mut seen = 0;
    for format in [Format::Scalar, Format::PreIntegrated, Format::Rgba] {
        for (density, slice_spacing) in [(3.0, 0.5), (3.0, 4.0)] {
            let scene = phantom_scene::<f32>("fog", 32, density);
            for (azimuth, elevation, fov) in VIEWS {
                let view = view(&scene, azimuth, elevation, fov, 24);
                let of = |blend| {
                    let renderer = TextureSlicer { format, blend, slice_spacing, ..TextureSlicer::brute_force() };
                    draw(&renderer, &scene, &view).frame.depth().unwrap().to_vec()
                };
                for (front, back) in of(Blend::FrontToBack).into_iter().zip(of(Blend::BackToFront)) {
                    // Some hundred roundings, of a distance of a few units.
                    assert!(front == back || (front - back).abs() < 2e-5, "{format:?} {azimuth}: {front} {back}");
                    seen += u32::from(front.is_finite());
                }
            }
        }
    }
    assert!(seen > 500, "{seen}");
}

#[test]
fn a_cut_in_the_slab_where_opacity_reaches_a_half_does_not_move_what_is_seen() {
    let scene = phantom_scene::<f32>("fog", 32, 3.0);
    let (view, mut seen) = (view(&scene, 33.0, 21.0, None, 24), 0);
    // Slabs of four voxels, so that many hold both places; bricks as well.
    for brick in [None, Some(16)] {
        let renderer = TextureSlicer { brick, slice_spacing: 4.0, ..TextureSlicer::brute_force() };
        let depths = |compositing| {
            let drawn = draw(&renderer, &Scene { compositing, ..scene.clone() }, &view);
            drawn.frame.depth().unwrap().to_vec()
        };
        let whole = depths(Compositing::Over);
        for level in [0.55, 0.8] {
            for (cut, whole) in depths(Compositing::Accumulate { level }).into_iter().zip(&whole) {
                // The same sums up to there; f32 tells 10⁻⁶ of a distance of a few units apart.
                assert!(cut == *whole || (cut - whole).abs() < 2e-5, "{brick:?} {level}: {cut} {whole}");
                seen += u32::from(cut.is_finite());
            }
        }
    }
    assert!(seen > 500, "{seen}");
}

#[test]
fn extremes_are_where_they_are_and_means_are_nowhere() {
    for compositing in [Compositing::Maximum, Compositing::Minimum] {
        for proxy in [Proxy::Planes, Proxy::Shells, Proxy::Stacks] {
            for (azimuth, elevation, fov) in VIEWS {
                let scene = Scene { compositing, ..phantom_scene::<f32>("fog", 32, 1.0) };
                let view = view(&scene, azimuth, elevation, fov, 24);
                let renderer = TextureSlicer { proxy, slice_spacing: 0.1, ..TextureSlicer::default() };
                let frame = draw(&renderer, &scene, &view).frame;
                let off = frame.depth().unwrap().iter().zip(truth(&scene, &view)).filter_map(|(got, want)| {
                    assert_eq!(got.is_finite(), want.depth.is_finite());
                    want.depth.is_finite().then(|| (f64::from(*got) - want.depth).abs())
                });
                let mut off: Vec<f64> = off.collect();
                off.sort_by(f64::total_cmp);
                let (half, most) = (off[off.len() / 2], off[off.len() * 9 / 10]);
                println!(
                    "{compositing:?} {proxy:?} {azimuth}: {} pixels, half within {half:.1e}, nine tenths {most:.1e}",
                    off.len()
                );
                // A tenth of a voxel is 0.006 long; along flat stretches a sample farther away may be the largest.
                assert!(half < 4e-3 && most < 2e-2, "{compositing:?} {proxy:?}: {half} {most}");
            }
        }
    }
    let scene = Scene { compositing: Compositing::Average, ..phantom_scene::<u8>("fog", 16, 1.0) };
    let frame = draw(&TextureSlicer::default(), &scene, &view(&scene, 33.0, 21.0, None, 12)).frame;
    assert!(frame.depth().unwrap().iter().all(|&depth| depth == f32::INFINITY) && frame.pixel(6, 6)[3] > 0.0);
}

#[test]
fn first_points_in_stacks_and_compressed_textures() {
    let compositing = Compositing::First { threshold: 0.45 };
    let plain = phantom_scene::<f32>("fog", 32, 1.0);
    let shading = Some(Arc::new(Shading::default()));
    // Stacks are off by the rounding of f32 alone: 1.2·10⁻⁸, and 2.5·10⁻⁷ in depths. The error of compression (3.3·10⁻² at the worst) is that of a point met or missed, and the
    // roughness of its gradients.
    for (scene, format, proxy, bound) in [
        (Scene { compositing, ..plain.clone() }, Format::Scalar, Proxy::Stacks, 1e-6),
        (Scene { compositing, shading: shading.clone(), ..plain.clone() }, Format::Scalar, Proxy::Stacks, 1e-6),
        (Scene { compositing, ..plain.clone() }, Format::Compressed, Proxy::Planes, 5e-2),
        (Scene { compositing, shading, ..plain }, Format::Compressed, Proxy::Shells, 5e-2),
    ] {
        for (azimuth, elevation, fov) in VIEWS {
            let view = view(&scene, azimuth, elevation, fov, 24);
            let renderer = TextureSlicer { format, proxy, slice_spacing: 0.25, ..TextureSlicer::default() };
            let frame = draw(&renderer, &scene, &view).frame;
            let truth = truth(&scene, &view);
            let colors: Vec<[f64; 4]> = truth.iter().map(|p| p.rgba).collect();
            let m = Metrics::of(&colors, frame.pixels());
            let both = frame.depth().unwrap().iter().zip(&truth).filter(|(a, b)| a.is_finite() && b.depth.is_finite());
            let off = both.map(|(a, b)| (f64::from(*a) - b.depth).abs()).fold(0.0, f64::max);
            println!("{format:?} {proxy:?} {azimuth}, shaded {}: {m}, depth {off:.1e}", scene.shading.is_some());
            assert!(m.rmse < bound, "{format:?} {proxy:?}: {m}");
            assert!(off < 1e-6 || format == Format::Compressed, "{format:?} {proxy:?}: {off}");
        }
    }
}
