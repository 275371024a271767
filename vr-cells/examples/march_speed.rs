//! Prints the time of a frame of tetrahedra by their number: six for each cell of a grid of blobs, 512² pixels, one thread.

use std::time::Instant;

use vr_cells::CellMarcher;
use vr_core::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("{:>9}  {:>9}  {:>9}  {:>9}  {:>12}", "cells", "ms", "M steps", "ns/step", "M cells/s");
    for side in [13, 33, 70] {
        let blobs = phantom::by_name("blobs").ok_or("no blobs")?;
        let scene = phantom::sampled_scene::<u8>(&*blobs, side, 0.3)?;
        let mesh = CellMesh::of_grid(scene.volume.grid().ok_or("no grid")?)?;
        let cells = mesh.cells().len();
        let scene = Scene { volume: mesh.into(), ..scene };
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
        println!("{cells:9}  {:9.1}  {:9.2}  {ns:9.1}  {:12.2}", 1e3 * best, steps as f64 * 1e-6, per_second * 1e-6);
    }
    Ok(())
}
