//! A volume that is a function of the position, without samples: drawn by the ray caster, and by the reference.
//!
//! `cargo run --release -p vr-examples --example own_volume`

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;
use vr_core::field::FunctionField;
use vr_core::{
    Camera, Control, ControlPoint, Model, OpacityRule, Renderer, Scene, Shading, TransferFunction, View, Volume,
};
use vr_io::PngOptions;
use vr_physics::Reference;
use vr_physics::metrics::Metrics;
use vr_raycast::RayCaster;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A gyroid: a surface of zeros that divides space into two alike halves.
    let gyroid = |p: DVec3| {
        let p = TAU * p;
        p.x.sin() * p.y.cos() + p.y.sin() * p.z.cos() + p.z.sin() * p.x.cos()
    };
    let slope = |p: DVec3| {
        let ([sx, sy, sz], [cx, cy, cz]) = ((TAU * p).to_array().map(f64::sin), (TAU * p).to_array().map(f64::cos));
        TAU * DVec3::new(cx * cy - sz * sx, cy * cz - sx * sy, cz * cx - sy * sz)
    };
    let field = FunctionField::new((DVec3::NEG_ONE, DVec3::ONE), gyroid)?.with_gradient(slope);
    let volume = Volume::from(field);

    // Opaque between -0.2 and 0.2, shaded by the function's own gradient.
    let point = |value, opacity| ControlPoint::new(value, [0.9, 0.6, 0.3], opacity);
    let points = vec![point(-0.3, 0.0), point(-0.2, 0.4), point(0.2, 0.4), point(0.3, 0.0)];
    let transfer = TransferFunction::new(points, OpacityRule::Power, 0.05)?;
    let scene = Scene { shading: Some(Arc::new(Shading::default())), ..Scene::new(volume, transfer) };
    let view = View::new(Camera::framing(scene.bounds(), 35.0, 25.0, Some(30.0)), [96, 96]);

    let control = Control::default();
    let frame = RayCaster::default().prepare(&scene, &control)?.render(&view, &control)?.frame;
    let reference = Reference::new(1e-6).solve(&scene, &view, &Model::Canonical, &control)?;
    let pixels: Vec<[f64; 4]> = reference.pixels.iter().map(|pixel| pixel.rgba).collect();
    println!("ray caster against the reference: {}", Metrics::of(&pixels, frame.pixels()));

    vr_io::write("own_volume.png", &frame, &PngOptions::default())?;
    Ok(())
}
