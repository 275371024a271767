//! Paths per second on one thread through the phantom fog: `cargo run --release -p vr-light --example fog_paths [GRID [SIZE [SAMPLES]]]`.
//!
//! A grid of 256³ voxels, a picture of 128² pixels and 16 samples of each unless said otherwise. The fog has the albedo 0.9 and forward scattering of
//! g = 0.5, in uniform light from all sides under one sun. The error halves for four times the time: error · √seconds is printed after each pass.

use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use vr_core::phantom;
use vr_core::scattering::{Albedo, PhaseFunction, Scattering};
use vr_core::{Camera, Clip, Control, ControlPoint, TransferFunction, View};
use vr_light::{Environment, Film, LightScene, LightSource, PathTracer, SceneMedium, Spectrum, Until};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut numbers = std::env::args().skip(1).map(|word| word.parse::<usize>());
    let mut next = |default: usize| numbers.next().unwrap_or(Ok(default));
    let (grid, size, samples) = (next(256)?, next(128)?, next(16)?);

    let mut fog = phantom::by_name("fog").ok_or("there is a fog")?.scene(grid)?;
    // Black: under a constant albedo the colour is that of a glow, which this fog does not have.
    let black = fog.transfer.points().iter().map(|point| ControlPoint { color: [0.0; 3], ..*point }).collect();
    fog.transfer = Arc::new(TransferFunction::new(black, fog.transfer.rule(), fog.transfer.unit_distance())?);
    let scattering = Scattering {
        albedo: Albedo::Constant([0.9; 3]),
        phase: PhaseFunction::henyey_greenstein(0.5)?,
        ..Scattering::default()
    };
    let started = Instant::now();
    let medium = SceneMedium::new(&fog, &Clip::default(), &scattering)?;
    let sun = LightSource::Directional { towards: DVec3::new(1.0, 2.0, 1.0), color: Spectrum::grey(1.0) };
    let scene = LightScene::new(Some(Arc::new(medium)), 3)?
        .with_environment(Environment::from([0.5; 3]))?
        .with_lights(vec![sun])?;
    println!("prepared in {:.2} s", started.elapsed().as_secs_f64());

    let camera = Camera::framing((DVec3::NEG_ONE, DVec3::ONE), 30.0, 20.0, Some(30.0));
    let view = View::new(camera, [size as u32; 2]);
    let mut film = Film::new(view.size, 3)?;
    let control = Control::default().with_threads(1);
    let started = Instant::now();
    let mut report = |film: &Film| {
        let (seconds, paths) = (started.elapsed().as_secs_f64(), film.count(0) as f64 * (size * size) as f64);
        let error = film.rms_error();
        println!(
            "{:4} samples: {:9.0} paths/s, error {error:.5}, error·√s {:.5}",
            film.count(0),
            paths / seconds,
            error * seconds.sqrt()
        );
    };
    PathTracer::new(&scene, 1).run(&view, &mut film, &Until::samples(samples as u64), &control, &mut report)?;
    let pixels = (size * size) as f64;
    let mean: f64 = (0..size * size).map(|pixel| film.mean(pixel, 1)).sum::<f64>() / pixels;
    println!("mean green {mean:.5}");
    Ok(())
}
