//! Errors of pictures against the renderer's own model done exactly, and against the canonical reference.
//!
//! `cargo run --release -p vr-shearwarp --example own_error -- [KEY=VALUE ...]`; the keys and their defaults:
//!
//! - `scenes=fog,hydrogen,marschner-lobb,blobs`: phantoms, sampled as u8
//! - `sizes=64,128`: samples along an edge
//! - `fov=0`: vertical angle of view in degrees; 0: parallel
//! - `pixels=64`: of the picture, along an edge
//!
//! The view is oblique and shows the inside of the volume: what ends at the volume's faces has an outline a texel wide whatever is done,
//! which is another thing. Prints a Markdown table: largest error and RMSE, against either.

use std::collections::HashMap;

use vr_core::phantom::{self};
use vr_core::{Camera, Control, Model, Projection, Renderer, Scene, View};
use vr_physics::{Metrics, Reference};
use vr_shearwarp::{ShearWarp, WarpFilter};

/// Largest error of a reference's pixel.
const TOLERANCE: f64 = 1e-6;

fn settings() -> [(&'static str, ShearWarp); 5] {
    let default = ShearWarp::default;
    let cubic = |slice_distance| ShearWarp { slice_distance, texel: 0.5, warp: WarpFilter::Cubic, ..default() };
    [
        ("classic", ShearWarp::classic()),
        ("values 1", ShearWarp { slice_distance: 1.0, ..default() }),
        ("default", default()),
        // Distances are in texels.
        ("values 1, 2x cubic", cubic(2.0)),
        ("values 1/2, 2x cubic", cubic(1.0)),
    ]
}

fn view(scene: &Scene, fov: f64, pixels: u32) -> View {
    let mut camera = Camera::framing(scene.volume.bounds(), 33.0, 21.0, None);
    let Projection::Orthographic { height } = camera.projection else { unreachable!("framed without an angle") };
    let height = 0.5 * height;
    camera.projection = Projection::Orthographic { height };
    if fov > 0.0 {
        let distance = 0.5 * height / (0.5 * fov.to_radians()).tan();
        let away = (camera.eye - camera.target).normalize();
        camera.eye = camera.target + away * distance;
        camera.projection = Projection::Perspective { fov };
    }
    View::new(camera, [pixels; 2])
}

fn main() {
    let given: HashMap<String, String> = std::env::args()
        .skip(1)
        .map(|arg| {
            let (key, value) = arg.split_once('=').expect("arguments: KEY=VALUE");
            assert!(["scenes", "sizes", "fov", "pixels"].contains(&key), "{key}: one of scenes, sizes, fov, pixels");
            (key.to_owned(), value.to_owned())
        })
        .collect();
    let text = |key: &str, default: &str| given.get(key).cloned().unwrap_or_else(|| default.to_owned());
    let fov: f64 = text("fov", "0").parse().expect("fov: degrees");
    let pixels: u32 = text("pixels", "64").parse().expect("pixels: a number");
    let control = Control::default();
    println!("| scene | setting | own: max | RMSE | canonical: max | RMSE |\n|---|---|--:|--:|--:|--:|");
    for name in text("scenes", "fog,hydrogen,marschner-lobb,blobs").split(',') {
        for size in text("sizes", "64,128").split(',') {
            let phantom = phantom::by_name(name).expect("scenes: known phantoms");
            let n: usize = size.parse().expect("sizes: numbers");
            let scene = phantom::sampled_scene::<u8>(&*phantom, n, 1.0).expect("sizes: two or more");
            let view = view(&scene, fov, pixels);
            let exact = |model: &Model| -> Vec<[f64; 4]> {
                let solved = Reference::new(TOLERANCE).solve(&scene, &view, model, &control).expect("a valid view");
                solved.pixels.iter().map(|p| p.rgba).collect()
            };
            let canonical = exact(&Model::Canonical);
            for (label, renderer) in settings() {
                let mut prepared = renderer.prepare(&scene, &control).expect("a scene that it can draw");
                let frame = prepared.render(&view, &control).expect("a valid view").frame;
                let own = Metrics::of(&exact(&prepared.model(&view).unwrap()), frame.pixels());
                let truth = Metrics::of(&canonical, frame.pixels());
                let [a, b, c, d] = [own.max, own.rmse, truth.max, truth.rmse];
                println!("| {name} {n} | {label} | {a:.1e} | {b:.1e} | {c:.1e} | {d:.1e} |");
            }
        }
    }
}
