//! A volume, a transfer function, a camera, and a PNG.
//!
//! `cargo run --release -p vr-examples --example first_picture`

use vr_core::phantom::{Hydrogen, Phantom};
use vr_core::{Camera, Control, Renderer, View};
use vr_io::PngOptions;
use vr_raycast::RayCaster;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A phantom comes with a transfer function. `vr_io::read` reads a file, and `Scene::new` takes any volume and transfer function.
    let scene = Hydrogen.scene(64)?;
    let view = View::new(Camera::framing(scene.bounds(), 30.0, 20.0, None), [512, 512]);

    let control = Control::default();
    let mut prepared = RayCaster::default().prepare(&scene, &control)?;
    let rendered = prepared.render(&view, &control)?;

    vr_io::write("first_picture.png", &rendered.frame, &PngOptions::default())?;
    println!("first_picture.png: {} samples", rendered.stats.counts.samples);
    Ok(())
}
