//! Time of scattered points on one thread, and error against the reference on coarser rays of the same view.
//! `cargo run --release -p vr-splat --example points_speed -- plummer 1000000 24`: a phantom, its points, pixels across for the error (0: none).

use std::time::Instant;

use vr_core::phantom::{point_transfer_function, points_by_name};
use vr_core::*;
use vr_physics::check::pictures::error;
use vr_splat::Splatter;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let text = |i: usize, otherwise: &'static str| args.get(i).map_or(otherwise, String::as_str).to_owned();
    let (name, count): (String, usize) = (text(0, "plummer"), text(1, "1000000").parse()?);
    let across: u32 = text(2, "0").parse()?;
    let points = points_by_name(&name, count).ok_or("a known phantom and at least one point")?;
    let (control_points, unit) = point_transfer_function(&name).ok_or("a known phantom")?;
    let scene = Scene::new(points.into(), TransferFunction::new(control_points, OpacityRule::Power, unit)?);
    let view = |size| View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, None), [size; 2]);
    let control = Control::default().with_threads(1);
    let mut prepared = Splatter::default().prepare(&scene, &control)?;
    for _ in 0..3 {
        let start = Instant::now();
        let stats = prepared.render(&view(512), &control)?.stats;
        let ms = start.elapsed().as_secs_f64() * 1e3;
        let stages: Vec<String> =
            stats.stages.iter().map(|s| format!("{} {:.0}", s.0, s.1.as_secs_f64() * 1e3)).collect();
        println!("{name} {count}: {ms:.0} ms ({}), {} splats × blocks", stages.join(", "), stats.counts.samples);
    }
    if across > 0 {
        println!("error on {across}² rays: {}", error(&Splatter::default(), &scene, &view(across)));
    }
    Ok(())
}
