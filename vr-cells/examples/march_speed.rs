//! Prints the time of a frame of tetrahedra by their number: six for each cell of a grid, 512² pixels, one thread.
//!
//! Blobs by their own transfer function, and the signal of Marschner & Lobb (1994) on 33³ points, translucent and as surfaces that are nearly opaque; and blobs
//! that are shaded.

use std::time::Instant;

use vr_cells::CellMarcher;
use vr_core::*;

/// A phantom as a mesh, from a voxel grid of `side`³ points.
fn mesh(name: &str, side: usize) -> Result<Scene, Box<dyn std::error::Error>> {
    let phantom = phantom::by_name(name).ok_or("no such phantom")?;
    let scene = phantom::sampled_scene::<u8>(&*phantom, side, 0.3)?;
    let mesh = CellMesh::of_grid(scene.volume.grid().ok_or("no grid")?)?;
    Ok(Scene { volume: mesh.into(), ..scene })
}

/// A transfer function over the range of a mesh, from parts of the range, grey levels and opacities of an eighth of a cell's edge.
fn transfer(volume: &Volume, points: &[(f64, f64)]) -> Result<TransferFunction, Box<dyn std::error::Error>> {
    let (low, high) = volume.value_range().ok_or("no values")?;
    let point = |&(part, opacity)| ControlPoint::new(low + (high - low) * part, [part, 0.5, 1.0 - part], opacity);
    Ok(TransferFunction::new(points.iter().map(point).collect(), OpacityRule::Power, 0.125 * 2.0 / 32.0)?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scenes = Vec::new();
    for side in [13, 33, 70] {
        scenes.push(("blobs", mesh("blobs", side)?));
    }
    let signal = mesh("marschner-lobb", 33)?;
    let thin =
        [(0.0, 0.0), (0.24, 0.0), (0.31, 0.04), (0.39, 0.0), (0.55, 0.0), (0.65, 0.06), (0.75, 0.0), (1.0, 0.01)];
    let thick = [(0.0, 0.0), (0.45, 0.0), (0.53, 0.85), (0.78, 0.9), (1.0, 0.95)];
    for (name, points) in [("signal, thin", &thin[..]), ("signal, thick", &thick)] {
        scenes.push((name, Scene { transfer: transfer(&signal.volume, points)?.into(), ..signal.clone() }));
    }
    let (_, blobs) = scenes[1].clone();
    scenes.push(("blobs, shaded", Scene { shading: Some(Shading::default().into()), ..blobs }));
    println!("{:13}  {:>9}  {:>9}  {:>9}  {:>9}  {:>12}", "", "cells", "ms", "M steps", "ns/step", "M cells/s");
    for (name, scene) in scenes {
        let cells = scene.volume.cells().map_or(0, |mesh| mesh.cells().len());
        let view = View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, None), [512; 2]);
        let control = Control::default().with_threads(1);
        let mut prepared = CellMarcher::default().prepare(&scene, &control)?;
        // The fastest of five.
        let mut best = f64::INFINITY;
        let mut steps = 0;
        for _ in 0..5 {
            let start = Instant::now();
            let rendered = prepared.render(&view, &control)?;
            best = best.min(start.elapsed().as_secs_f64());
            steps = rendered.stats.counts.samples;
        }
        let (ns, per_second) = (1e9 * best / steps as f64, cells as f64 / best);
        let (ms, steps, per_second) = (1e3 * best, steps as f64 * 1e-6, per_second * 1e-6);
        println!("{name:13}  {cells:9}  {ms:9.1}  {steps:9.2}  {ns:9.1}  {per_second:12.2}");
    }
    Ok(())
}
