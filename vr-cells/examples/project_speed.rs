//! Prints the time of a frame of tetrahedra by the projector and by the marcher, and how far their pictures are apart: 512² pixels, one thread.
//! Times are those of the processor where the system tells them, so that other programs do not count.

use std::sync::LazyLock;
use std::time::Instant;

use glam::DVec3;
use vr_cells::{Attenuation, CellMarcher, CellProjector};
use vr_core::phantom::{self, MarschnerLobb, Phantom};
use vr_core::*;

/// Seconds that the process has run, or that have passed where the system does not tell.
fn clock() -> f64 {
    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    let nanoseconds = |task: std::fs::DirEntry| {
        let text = std::fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split(' ').next()?.parse::<f64>().ok()
    };
    let tasks = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let run: f64 = tasks.filter_map(nanoseconds).sum();
    if run > 0.0 { 1e-9 * run } else { BEGIN.elapsed().as_secs_f64() }
}

/// The fastest of several frames in seconds, and the picture.
fn frame(
    renderer: &dyn Renderer,
    scene: &Scene,
    view: &View,
    control: &Control,
    frames: u32,
) -> Result<(f64, Rendered), RenderError> {
    let mut prepared = renderer.prepare(scene, control)?;
    let mut best: Option<(f64, Rendered)> = None;
    for _ in 0..frames {
        let start = clock();
        let rendered = prepared.render(view, control)?;
        let seconds = clock() - start;
        if best.as_ref().is_none_or(|b| seconds < b.0) {
            best = Some((seconds, rendered));
        }
    }
    Ok(best.expect("at least one frame"))
}

/// Largest difference and root mean square of two pictures.
fn difference(a: &Frame, b: &Frame) -> (f64, f64) {
    let (mut largest, mut sum) = (0.0f64, 0.0);
    for (a, b) in a.pixels().iter().zip(b.pixels()) {
        for c in 0..4 {
            let off = f64::from(a[c] - b[c]).abs();
            (largest, sum) = (largest.max(off), sum + off * off);
        }
    }
    (largest, (sum / (4 * a.pixels().len()) as f64).sqrt())
}

fn row(name: &str, scene: &Scene, view: &View, control: &Control) -> Result<(), RenderError> {
    let cells = scene.volume.cells().map_or(0, |mesh| mesh.cells().len());
    let (seconds, projected) = frame(&CellProjector::default(), scene, view, control, 5)?;
    let (march, marched) = frame(&CellMarcher::default(), scene, view, control, 1)?;
    let classic = CellProjector { attenuation: Attenuation::Linear, ..CellProjector::default() };
    let (classic_seconds, classic) = frame(&classic, scene, view, control, 1)?;
    let (largest, rms) = difference(&projected.frame, &marched.frame);
    let (classic_largest, classic_rms) = difference(&classic.frame, &marched.frame);
    println!(
        "{name:>12} {cells:9}  {:8.1} ms  {:6.2} M cells/s  {:6.1} M fragments  {largest:.1e} {rms:.1e}  march {:8.1} ms  linear {:8.1} ms {classic_largest:.1e} {classic_rms:.1e}",
        1e3 * seconds,
        1e-6 * cells as f64 / seconds,
        1e-6 * projected.stats.counts.samples as f64,
        1e3 * march,
        1e3 * classic_seconds,
    );
    for (stage, time) in &projected.stats.stages {
        print!("  {stage} {:.1}", 1e3 * time.as_secs_f64());
    }
    println!();
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The scene of shared/peers: a signal of 33³ bytes in six tetrahedra a cell.
    let size = 33;
    let values: Vec<u8> = (0..size * size * size)
        .map(|i: usize| {
            let at = [i % size, i / size % size, i / (size * size)].map(|x| x as f64 * 2.0 / (size - 1) as f64 - 1.0);
            (255.0 * MarschnerLobb::default().value(DVec3::from_array(at))).round().clamp(0.0, 255.0) as u8
        })
        .collect();
    let grid = UniformGrid::new([size; 3], values, Placement::from_spacing([1.0; 3])?, Calibration::default())?;
    let mesh = CellMesh::of_grid(&GridVolume::new(grid.into(), Filter::Trilinear))?;
    let p = ControlPoint::new;
    let translucent = vec![
        p(0.0, [0.0; 3], 0.0),
        p(60.0, [0.15, 0.3, 0.95], 0.0),
        p(80.0, [0.2, 0.6, 1.0], 0.04),
        p(100.0, [0.3, 0.8, 0.8], 0.0),
        p(140.0, [0.8, 0.8, 0.2], 0.0),
        p(165.0, [1.0, 0.7, 0.2], 0.06),
        p(190.0, [1.0, 0.35, 0.15], 0.0),
        p(255.0, [1.0, 0.2, 0.2], 0.01),
    ];
    let opaque = vec![
        p(0.0, [0.0; 3], 0.0),
        p(115.0, [0.2, 0.4, 0.85], 0.0),
        p(135.0, [0.35, 0.65, 0.95], 0.85),
        p(200.0, [0.95, 0.8, 0.35], 0.9),
        p(255.0, [1.0, 0.45, 0.2], 0.95),
    ];
    // Kept to the end: what its thread has run is counted as long as it lives.
    let control = Control::default().with_threads(1);
    let camera = Camera {
        eye: DVec3::new(68.083051606, -74.210491595, 53.913360989),
        target: DVec3::splat(16.0),
        up: DVec3::Z,
        projection: Projection::Orthographic { height: 47.271867726 },
    };
    let view = View::new(camera, [512; 2]);
    for (name, points) in [("translucent", translucent), ("opaque", opaque)] {
        let transfer = TransferFunction::new(points, OpacityRule::Power, 0.125)?;
        row(name, &Scene::new(mesh.clone().into(), transfer), &view, &control)?;
    }
    // Six for each cell of a grid of blobs.
    for side in [13, 33, 70] {
        let blobs = phantom::by_name("blobs").ok_or("no blobs")?;
        let scene = phantom::sampled_scene::<u8>(&*blobs, side, 0.3)?;
        let mesh = CellMesh::of_grid(scene.volume.grid().ok_or("no grid")?)?;
        let scene = Scene { volume: mesh.into(), ..scene };
        for fov in [None, Some(30.0)] {
            let view = View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, fov), [512; 2]);
            row(if fov.is_some() { "perspective" } else { "parallel" }, &scene, &view, &control)?;
        }
    }
    Ok(())
}
