//! Times of one frame by kernel and buffer, on one thread, relative to bilinear weights. `cargo run --release -p vr-splat --example kernel_speed [KERNEL]`: with
//! a kernel's name a single frame of it, to count instructions of.

use std::time::Instant;

use vr_core::phantom::{self, TRANSFER_UNIT_DISTANCE};
use vr_core::*;
use vr_splat::{Buffers, Shape, SplatKernel, Splatter};

/// Voxels along each axis.
const SIDE: usize = 64;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let control = Control::default().with_threads(1);
    let phantom = phantom::by_name("fog").ok_or("a known phantom")?;
    let transfer = TransferFunction::new(phantom.transfer_points(), OpacityRule::Power, TRANSFER_UNIT_DISTANCE)?;
    let scene = Scene::new(phantom::sample::<u8>(&*phantom, [SIDE; 3])?.into(), transfer);
    let view = View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, None), [256; 2]);
    let only = std::env::args().nth(1);
    println!("{SIDE}³ bytes, 256² pixels\n\n| buffers | kernel | frame, ms | by bilinear |\n|---|---|---|---|");
    for buffers in [Buffers::Image, Buffers::Axis] {
        let mut bilinear = f64::NAN;
        for shape in Shape::ALL {
            if only.as_ref().is_some_and(|only| *only != format!("{buffers:?} {shape:?}")) {
                continue;
            }
            let renderer = Splatter { buffers, kernel: SplatKernel::new(shape), ..Splatter::default() };
            let mut prepared = renderer.prepare(&scene, &control)?;
            let mut best = f64::INFINITY;
            for _ in 0..if only.is_some() { 1 } else { 5 } {
                let start = Instant::now();
                prepared.render(&view, &control)?;
                best = best.min(start.elapsed().as_secs_f64() * 1e3);
            }
            if shape == Shape::Bilinear {
                bilinear = best;
            }
            println!("| {buffers:?} | {shape:?} | {best:.0} | {:.2} |", best / bilinear);
        }
    }
    Ok(())
}
