//! The time and the error of two settings of one renderer.
//!
//! `cargo run --release -p vr-examples --example two_settings`

use std::time::Instant;

use vr_core::phantom::{Phantom, Shells};
use vr_core::{Camera, Control, Model, Renderer, View};
use vr_physics::Reference;
use vr_physics::metrics::Metrics;
use vr_raycast::RayCaster;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Shells.scene(64)?;
    let view = View::new(Camera::framing(scene.bounds(), 30.0, 20.0, None), [128, 128]);
    let control = Control::default();

    // The truth, with a bound on its own error.
    let solution = Reference::default().solve(&scene, &view, &Model::Canonical, &control)?;
    let truth: Vec<[f64; 4]> = solution.pixels.iter().map(|pixel| pixel.rgba).collect();
    println!("reference: within {:.1e}", solution.certainty().value());

    for step in [1.0, 0.25] {
        let mut prepared = RayCaster::uniform(step).prepare(&scene, &control)?;
        prepared.render(&view, &control)?;
        let start = Instant::now();
        let frame = prepared.render(&view, &control)?.frame;
        println!("step {step}: {:.1?}, {}", start.elapsed(), Metrics::of(&truth, frame.pixels()));
    }
    Ok(())
}
