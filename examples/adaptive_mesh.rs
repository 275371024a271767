//! An adaptive mesh of a function, fine where the function turns, drawn with steps as long as its cells allow; and how far the picture is from the reference.
//!
//! `cargo run --release -p vr-examples --example adaptive_mesh`

use glam::DVec3;
use vr_core::amr::{AmrCentring, AmrGrid, AmrSampling};
use vr_core::{Camera, Control, ControlPoint, Model, OpacityRule, Renderer, Scene, Shading, TransferFunction, View};
use vr_io::PngOptions;
use vr_physics::Reference;
use vr_raycast::RayCaster;

/// Density of a disc around a star: spiral arms, thin towards the rim.
fn disc(p: DVec3) -> f64 {
    let (radius, angle) = (p.truncate().length(), p.y.atan2(p.x));
    let arms = 0.55 + 0.45 * (2.0 * angle - 9.0 * (radius + 0.1).ln()).cos();
    let height = 0.04 + 0.08 * radius;
    arms * (-(p.z / height).powi(2)).exp() * (-3.5 * radius).exp() + 0.8 * (-(p.length() / 0.12).powi(2)).exp()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Blocks of 8³ cells; a block is refined where the disc is dense, up to four times.
    let sampling = AmrSampling {
        origin: DVec3::NEG_ONE,
        edge: 1.0,
        blocks: [2; 3],
        block_cells: [8; 3],
        ratios: vec![[2; 3]; 4],
        centring: AmrCentring::Cells,
    };
    let is_dense = |low: DVec3, high: DVec3, level: usize| {
        let nearest = DVec3::ZERO.clamp(low, high);
        let places =
            [0.5 * (low + high), nearest, DVec3::new(low.x, high.y, nearest.z), DVec3::new(high.x, low.y, nearest.z)];
        places.into_iter().any(|at| disc(at) > 0.06 * (level + 1) as f64)
    };
    let grid = AmrGrid::refining(&sampling, |p| disc(p) as f32, is_dense)?;
    for level in 0..grid.levels() {
        println!("level {level}: {} blocks, {} cells", grid.blocks_of(level).len(), grid.leaf_cells(level));
    }
    let uniform: u64 = grid.finest_dims().iter().product();
    println!("{:.1} MB; as fine everywhere: {:.1} MB", grid.bytes() as f64 / 1e6, 4.0 * uniform as f64 / 1e6);

    let points = [
        (0.02, [0.05, 0.1, 0.4], 0.0),
        (0.1, [0.3, 0.4, 0.9], 0.02),
        (0.3, [1.0, 0.7, 0.4], 0.25),
        (0.9, [1.0; 3], 0.8),
    ];
    let points = points.map(|(value, color, opacity)| ControlPoint::new(value, color, opacity));
    let transfer = TransferFunction::new(points.to_vec(), OpacityRule::Power, 0.02)?;
    let scene = Scene { shading: Some(Shading::default().into()), ..Scene::new(grid.into(), transfer) };

    let camera = Camera::framing(scene.bounds(), 30.0, 50.0, Some(30.0));
    let control = Control::default();
    let mut prepared = RayCaster::uniform(0.5).prepare(&scene, &control)?;
    let rendered = prepared.render(&View::new(camera, [384, 384]), &control)?;
    vr_io::write("adaptive_mesh.png", &rendered.frame, &PngOptions::default())?;
    let counts = &rendered.stats.counts;
    println!("adaptive_mesh.png: {} samples, {} steps left out", counts.samples, counts.skipped);

    // A few pixels of the correct picture.
    let view = View::new(camera, [16, 16]);
    let drawn = prepared.render(&view, &control)?.frame;
    let solved = Reference::default().solve(&scene, &view, &Model::Canonical, &control)?;
    let errors = solved
        .pixels
        .iter()
        .zip(drawn.pixels())
        .flat_map(|(exact, drawn)| (0..4).map(move |c| (exact.rgba[c] - f64::from(drawn[c])).abs()));
    println!("largest error of a pixel: {:.1e}", errors.fold(0.0, f64::max));
    Ok(())
}
