//! Time of pictures by ray templates, on one thread, beside that of every pixel's own ray by the plain engine:
//! `cargo run --release -p vr-raycast --features classics --example template_time [phantom] [voxels an edge] [size] [pictures] [screen|all]`.
//!
//! The screens draw in turn, so that a busy machine is as busy for the one as for the other; each counts with its best time. With one screen
//! named, that one alone draws: for counting instructions.
use std::time::Instant;

use vr_core::phantom::{self, sampled_scene};
use vr_core::*;
use vr_raycast::{Connectivity, ImageSampling, RayCaster, Vector};

fn template(connectivity: Connectivity) -> ImageSampling {
    ImageSampling::Template { connectivity }
}

fn main() {
    let word = |i: usize, or: &str| std::env::args().nth(i).unwrap_or_else(|| or.to_owned());
    let number = |i: usize, or: &str| word(i, or).parse::<u32>().expect("a number");
    let (name, n, size, pictures, only) =
        (word(1, "fog"), number(2, "128"), number(3, "512"), number(4, "3"), word(5, "all"));
    let phantom = phantom::by_name(&name).expect("a phantom");
    let scene = sampled_scene::<u8>(&*phantom, n as usize, 1.0).expect("a valid size");
    let view = View::new(Camera::framing(scene.volume.bounds(), 30.0, 20.0, None), [size; 2]);
    let control = Control::default().with_threads(1);
    let screens = [
        ImageSampling::EveryPixel,
        template(Connectivity::Continuous),
        template(Connectivity::Discrete),
        template(Connectivity::Faces),
    ];
    let mut drawn: Vec<_> = screens
        .into_iter()
        .filter(|screen| only == "all" || only == screen.name())
        .map(|image_sampling| {
            let caster = RayCaster { image_sampling, vector: Vector::Off, ..RayCaster::uniform(1.0) };
            (
                image_sampling.name(),
                caster.prepare(&scene, &control).expect("a scene that it can draw"),
                f64::INFINITY,
                None,
            )
        })
        .collect();
    for _ in 0..pictures {
        for (_, prepared, best, picture) in &mut drawn {
            let start = Instant::now();
            *picture = Some(prepared.render(&view, &control).expect("a view that it can draw").frame);
            *best = best.min(start.elapsed().as_secs_f64());
        }
    }
    let (base, want) = (drawn[0].2, drawn[0].3.clone().expect("at least one picture"));
    for (screen, _, best, picture) in &drawn {
        let pairs =
            picture.iter().flat_map(|frame| frame.pixels().iter().flatten()).zip(want.pixels().iter().flatten());
        let squares: f64 = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum();
        let rmse = (squares / (4.0 * f64::from(size) * f64::from(size))).sqrt();
        println!("{name} {n}: {screen} {:.1} ms, {:.2} of the first, RMSE from it {rmse:.1e}", 1e3 * best, best / base);
    }
}
