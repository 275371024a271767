//! Figures of `docs/figures/vr-splat.md` about speed and memory, on one thread: voxels, zoom, points. `cargo run --release -p vr-splat --example splat_speed`

use std::time::Instant;

use vr_core::Classification;
use vr_core::phantom::{self, TRANSFER_UNIT_DISTANCE};
use vr_core::*;
use vr_splat::{Buffers, Shape, SplatKernel, Splatter};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let control = Control::default().with_threads(1);
    let size = std::env::args().nth(1).map_or(Ok(128), |n| n.parse())?;
    voxels(size, &control)?;
    zoom(size, &control)?;
    points(&control)?;
    Ok(())
}

/// Milliseconds of the fastest of some frames, and what one did.
fn time(prepared: &mut dyn Prepared, view: &View, control: &Control) -> Result<(f64, RenderStats), RenderError> {
    let (mut min_ms, mut stats) = (f64::INFINITY, RenderStats::default());
    for _ in 0..3 {
        let start = Instant::now();
        let rendered = prepared.render(view, control)?;
        min_ms = min_ms.min(start.elapsed().as_secs_f64() * 1e3);
        stats = rendered.stats;
    }
    Ok((min_ms, stats))
}

/// Scene of a phantom's bytes, with the voxels that can be seen above a threshold alone.
fn scene(name: &str, n: usize) -> Result<Scene, Box<dyn std::error::Error>> {
    let phantom = phantom::by_name(name).ok_or("a known phantom")?;
    let transfer = TransferFunction::new(phantom.transfer_points(), OpacityRule::Power, TRANSFER_UNIT_DISTANCE)?;
    Ok(Scene::new(phantom::sample::<u8>(&*phantom, [n; 3])?.into(), transfer))
}

fn renderers() -> Vec<(&'static str, Splatter)> {
    let gaussian = Splatter { kernel: SplatKernel::new(Shape::Gaussian), ..Splatter::default() };
    let voxels = Splatter { classification: Classification::Pre, ..gaussian.clone() };
    vec![
        ("image", Splatter::default()),
        ("image gaussian", gaussian.clone()),
        ("image voxels", voxels.clone()),
        ("axis voxels", Splatter { buffers: Buffers::Axis, ..voxels.clone() }),
        ("samples", Splatter { buffers: Buffers::Samples, ..voxels }),
    ]
}

fn voxels(n: usize, control: &Control) -> Result<(), Box<dyn std::error::Error>> {
    println!("{n}³ bytes, 512² pixels, a voxel about 2 pixels wide at 256³\n");
    println!(
        "| scene | renderer | prepare, ms | frame, ms | 10⁶ splats × blocks | met a µs |\n|---|---|---|---|---|---|"
    );
    for name in ["blobs", "fog"] {
        let scene = scene(name, n)?;
        let view = View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, None), [512; 2]);
        for (how, renderer) in renderers() {
            let start = Instant::now();
            let mut prepared = renderer.prepare(&scene, control)?;
            let prepare = start.elapsed().as_secs_f64() * 1e3;
            let (ms, stats) = time(&mut *prepared, &view, control)?;
            let met = stats.counts.samples as f64;
            println!("| {name} | {how} | {prepare:.0} | {ms:.0} | {:.2} | {:.2} |", met / 1e6, met / ms / 1e3);
        }
    }
    println!();
    Ok(())
}

fn zoom(n: usize, control: &Control) -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "Zoom: the image's height in the world by factors, blobs {n}³\n\n| renderer | ×1, ms | ×4 | ×16 |\n|---|---|---|---|"
    );
    let scene = scene("blobs", n)?;
    for (how, renderer) in renderers() {
        let mut prepared = renderer.prepare(&scene, control)?;
        let mut row = format!("| {how} |");
        for factor in [1.0, 4.0, 16.0] {
            let mut camera = Camera::framing(scene.volume.bounds(), 33.0, 21.0, None);
            if let Projection::Orthographic { height } = &mut camera.projection {
                *height /= factor;
            }
            let (ms, _) = time(&mut *prepared, &View::new(camera, [512; 2]), control)?;
            row += &format!(" {ms:.0} |");
        }
        println!("{row}");
    }
    println!();
    Ok(())
}

fn points(control: &Control) -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "Points, 512² pixels\n\n| phantom | points | prepare, ms | frame, ms | of which sorting into tiles | ns a point |\n|---|---|---|---|---|---|"
    );
    for name in phantom::POINT_NAMES {
        for count in [100_000, 1_000_000, 10_000_000] {
            let points = phantom::points_by_name(name, count).ok_or("a known phantom")?;
            let (control_points, unit) = phantom::point_transfer_function(name).ok_or("a known phantom")?;
            let scene = Scene::new(points.into(), TransferFunction::new(control_points, OpacityRule::Power, unit)?);
            let view = View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, None), [512; 2]);
            let start = Instant::now();
            let mut prepared = Splatter::default().prepare(&scene, control)?;
            let prepare = start.elapsed().as_secs_f64() * 1e3;
            let (ms, stats) = time(&mut *prepared, &view, control)?;
            let bin: f64 = stats.stages.iter().filter(|s| s.0 == "bin").map(|s| s.1.as_secs_f64() * 1e3).sum();
            let each = ms * 1e6 / count as f64;
            println!("| {name} | {count} | {prepare:.0} | {ms:.0} | {bin:.0} | {each:.0} |");
        }
    }
    Ok(())
}
