//! Changes of brightness as a volume turns, in parallel projection and in perspective.
//!
//! `cargo run --release -p vr-texslice --example brightness -- [KEY=VALUE ...]`; the keys and their defaults:
//!
//! - `scenes=fog,hydrogen`: phantoms, sampled as u8
//! - `opacity=0.05`: a factor of the opacities of the phantom's transfer function
//! - `angles=24`: steps of a whole turn
//! - `size=48`, `pixels=96`: samples of the volume and pixels of the picture, along an edge
//! - `distance=0.5`: of slices
//! - `fov=0`: of a perspective view in degrees; 0: parallel
//!
//! A bias is the mean of all errors of red, green and blue, with their sign, as a part of the mean of the reference; a step is the change of the bias from one
//! angle to the next: for stacks, the jump at the switch.

use std::collections::HashMap;

use vr_core::phantom::{self};
use vr_core::{Camera, Control, Model, Renderer, Scene, View};
use vr_physics::Reference;
use vr_texslice::{Format, Proxy, TextureSlicer};

fn scene(name: &str, n: usize, opacity: f64) -> Scene {
    let phantom = phantom::by_name(name).expect("a known phantom");
    phantom::sampled_scene::<u8>(&*phantom, n, opacity).expect("a valid size")
}

fn light(pixels: impl Iterator<Item = [f64; 4]>) -> f64 {
    pixels.map(|p| p[0] + p[1] + p[2]).sum()
}

fn main() {
    let defaults =
        [("scenes", "fog,hydrogen"), ("opacity", "0.05"), ("angles", "24"), ("size", "48"), ("pixels", "96")];
    let mut keys: HashMap<String, String> = defaults.map(|(k, v)| (k.to_owned(), v.to_owned())).into();
    keys.extend([("distance", "0.5"), ("fov", "0")].map(|(k, v)| (k.to_owned(), v.to_owned())));
    for argument in std::env::args().skip(1) {
        let (key, value) = argument.split_once('=').expect("arguments are KEY=VALUE");
        assert!(keys.insert(key.to_owned(), value.to_owned()).is_some(), "unknown key {key}");
    }
    let number = |key: &str| -> f64 { keys[key].parse().unwrap_or_else(|_| panic!("{key}: no number")) };
    let control = Control::default();
    let angles = number("angles") as u32;
    let plain = TextureSlicer { slice_spacing: number("distance"), ..TextureSlicer::default() };
    let settings = [
        ("planes", plain.clone()),
        ("planes, uncorrected", TextureSlicer { correction: false, ..plain.clone() }),
        ("shells", TextureSlicer { proxy: Proxy::Shells, ..plain.clone() }),
        ("pre-integrated", TextureSlicer { format: Format::PreIntegrated, ..plain.clone() }),
        ("stacks", TextureSlicer { proxy: Proxy::Stacks, ..plain.clone() }),
        ("stacks, uncorrected", TextureSlicer { proxy: Proxy::Stacks, correction: false, ..plain }),
    ];
    println!("| scene | setting | bias farthest from 0 | at | largest step |\n|---|---|--:|--:|--:|");
    for name in keys["scenes"].split(',') {
        let scene = scene(name, number("size") as usize, number("opacity"));
        let fov = (number("fov") > 0.0).then(|| number("fov"));
        let views: Vec<View> = (0..angles)
            .map(|k| {
                let azimuth = 360.0 * f64::from(k) / f64::from(angles);
                View::new(Camera::framing(scene.volume.bounds(), azimuth, 0.0, fov), [number("pixels") as u32; 2])
            })
            .collect();
        let reference = Reference::new(1e-4);
        let truth: Vec<f64> = views
            .iter()
            .map(|v| {
                let solution =
                    reference.solve(&scene, v, &Model::Canonical, &control).expect("a view that it can solve");
                light(solution.pixels.iter().map(|p| p.rgba))
            })
            .collect();
        for (label, renderer) in &settings {
            let mut prepared = renderer.prepare(&scene, &control).expect("a scene that it can draw");
            let biases: Vec<f64> = views
                .iter()
                .zip(&truth)
                .map(|(view, truth)| {
                    let frame = prepared.render(view, &control).expect("a view that it can draw").frame;
                    light(frame.pixels().iter().map(|p| p.map(f64::from))) / truth - 1.0
                })
                .collect();
            let at = (0..biases.len()).max_by(|&a, &b| biases[a].abs().total_cmp(&biases[b].abs())).expect("an angle");
            let steps = (0..biases.len()).map(|i| (biases[(i + 1) % biases.len()] - biases[i]).abs());
            println!(
                "| {name} | {label} | {:+.4} % | {}° | {:.4} % |",
                100.0 * biases[at],
                360.0 / f64::from(angles) * at as f64,
                100.0 * steps.fold(0.0, f64::max),
            );
        }
    }
}
