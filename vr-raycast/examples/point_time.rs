//! Time of pictures of scattered points by packets of sixteen rays beside that of the plain engine, on one thread:
//! `cargo run --release -p vr-raycast --example point_time [turbulence|plummer] [thousands of points] [size] [repeats]`.
use std::sync::Arc;
use std::time::Instant;

use vr_core::*;
use vr_raycast::{RayCaster, Vector};

fn main() {
    let name = std::env::args().nth(1).unwrap_or_else(|| "turbulence".to_owned());
    let number = |i: usize, or: usize| std::env::args().nth(i).and_then(|n| n.parse().ok()).unwrap_or(or);
    let (count, size, repeats) = (1000 * number(2, 20), number(3, 96) as u32, number(4, 2));
    let points = phantom::points_by_name(&name, count).unwrap();
    let (control_points, unit) = phantom::point_transfer_function(&name).unwrap();
    let transfer = TransferFunction::new(control_points, OpacityRule::Power, unit).unwrap();
    let unshaded = Scene::new(points.into(), transfer);
    let view = View::new(Camera::framing(unshaded.volume.bounds(), 33.0, 21.0, None), [size, size]);
    let control = Control::default().with_threads(1);
    let shaded = Scene { shading: Some(Arc::new(Shading::default())), ..unshaded.clone() };
    for (name, scene) in [("unshaded", &unshaded), ("shaded", &shaded)] {
        let mut engines = [Vector::Auto, Vector::Off].map(|vector| {
            let caster = RayCaster { vector, ..RayCaster::uniform(0.5) };
            let start = Instant::now();
            let prepared = caster.prepare(scene, &control).unwrap();
            println!("{name} {vector:?}: prepared in {:.1} ms", 1e3 * start.elapsed().as_secs_f64());
            (prepared, f64::INFINITY, None)
        });
        for _ in 0..repeats {
            for (prepared, best, last) in &mut engines {
                let start = Instant::now();
                let rendered = prepared.render(&view, &control).unwrap();
                *best = best.min(start.elapsed().as_secs_f64());
                *last = Some(rendered.frame);
            }
        }
        let [(_, packets, Some(x)), (_, plain, Some(y))] = &engines else { unreachable!("both have drawn") };
        let pairs = x.pixels().as_flattened().iter().zip(y.pixels().as_flattened());
        let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        println!(
            "{name}: packets {:.1} ms, plain {:.1} ms, {:.2} times as fast, off by {off:.1e} at most",
            1e3 * packets,
            1e3 * plain,
            plain / packets
        );
    }
}
