//! A volume that turns keeps its brightness where opacity is corrected, and does not where it is not.

use vr_core::{Control, Model, Renderer, Scene};
use vr_physics::check::pictures::*;
use vr_texslice::{Proxy, TextureSlicer};

/// The error of brightness farthest from 0 in a turn, as a part of the brightness.
fn bias(renderer: &TextureSlicer, scene: &Scene, fov: Option<f64>) -> f64 {
    let control = Control::default();
    let mut prepared = renderer.prepare(scene, &control).unwrap();
    let light = |p: &[f64; 4]| p[0] + p[1] + p[2];
    let biases = (0..12).map(|k| {
        let view = view(scene, 30.0 * f64::from(k) + 15.0 * f64::from(k % 2), 0.0, fov, 40);
        let frame = prepared.render(&view, &control).unwrap().frame;
        let truth: f64 = solve(scene, &view, &Model::Canonical, 1e-5).iter().map(light).sum();
        frame.pixels().iter().map(|p| light(&p.map(f64::from))).sum::<f64>() / truth - 1.0
    });
    biases.fold(0.0, |worst: f64, b| if b.abs() > worst.abs() { b } else { worst })
}

#[test]
fn corrected_slices_keep_their_brightness() {
    for scene in [phantom_scene::<u8>("fog", 32, 0.05), phantom_scene::<u8>("hydrogen", 48, 0.05)] {
        for proxy in [Proxy::Planes, Proxy::Shells, Proxy::Stacks] {
            for fov in [None, Some(30.0)] {
                let renderer = TextureSlicer { proxy, ..TextureSlicer::default() };
                let worst = bias(&renderer, &scene, fov);
                println!("{proxy:?} {fov:?}: {:+.3} %", 100.0 * worst);
                assert!(worst.abs() < 5e-3, "{proxy:?} {fov:?}: {worst}");
            }
        }
    }
}

#[test]
fn uncorrected_ones_do_not() {
    let scene = phantom_scene::<u8>("fog", 32, 0.05);
    let plain = TextureSlicer { correction: false, slice_spacing: 1.0, ..TextureSlicer::default() };
    // At 45° layers are √2 times as far apart along a ray as they are taken to be: 1 − 1/√2 of thin light is missing there.
    let stacks = bias(&TextureSlicer { proxy: Proxy::Stacks, ..plain.clone() }, &scene, None);
    assert!((-0.3..-0.2).contains(&stacks), "{stacks}");
    // Planes are farther apart along rays that are not perpendicular to them: those towards the picture's edge.
    let planes = bias(&plain, &scene, Some(60.0));
    assert!((-0.1..-0.01).contains(&planes), "{planes}");
    assert!(bias(&plain, &scene, None).abs() < 5e-3, "parallel rays are all perpendicular");
}
