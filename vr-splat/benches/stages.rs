//! Time of the stages of a splatted frame: visible voxels, footprints, and the picture, by buffers, kernels, zoom and kind of volume.

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use vr_core::Classification;
use vr_core::phantom::{self};
use vr_core::*;
use vr_splat::{Buffers, Shape, SplatKernel, Splatter};

/// Samples along each axis.
const SIDE: usize = 64;

fn grid(name: &str) -> Scene {
    let phantom = phantom::by_name(name).expect("a known phantom");
    phantom::sampled_scene::<u8>(&*phantom, SIDE, 1.0).expect("a valid size")
}

fn cloud(name: &str, count: usize) -> Scene {
    let (points, unit) = phantom::point_transfer_function(name).expect("a known phantom");
    let transfer = TransferFunction::new(points, OpacityRule::Power, unit).expect("valid points");
    Scene::new(phantom::points_by_name(name, count).expect("a known phantom").into(), transfer)
}

fn view(scene: &Scene, zoom: f64) -> View {
    let mut camera = Camera::framing(scene.volume.bounds(), 33.0, 21.0, None);
    if let Projection::Orthographic { height } = &mut camera.projection {
        *height /= zoom;
    }
    View::new(camera, [256; 2])
}

fn renderers() -> Vec<(&'static str, Splatter)> {
    let gaussian = Splatter { kernel: SplatKernel::new(Shape::Gaussian), ..Splatter::default() };
    let voxels = Splatter { classification: Classification::Pre, ..gaussian.clone() };
    vec![
        ("image bilinear", Splatter::default()),
        ("image gaussian", gaussian),
        ("image voxels", voxels.clone()),
        ("axis voxels", Splatter { buffers: Buffers::Axis, ..voxels.clone() }),
        ("samples", Splatter { buffers: Buffers::Samples, ..voxels }),
    ]
}

fn frames(c: &mut Criterion) {
    let control = Control::default().with_threads(1);
    let mut group = c.benchmark_group("frames");
    group.sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(1));
    for name in ["blobs", "fog"] {
        let scene = grid(name);
        for (how, renderer) in renderers() {
            let mut prepared = renderer.prepare(&scene, &control).expect("a scene that it can draw");
            for zoom in [1.0, 4.0] {
                let view = view(&scene, zoom);
                group.bench_with_input(BenchmarkId::new(format!("{name} {how}"), zoom), &view, |b, view| {
                    b.iter(|| prepared.render(view, &control).expect("a frame"));
                });
            }
        }
    }
    for name in phantom::POINT_NAMES {
        for count in [10_000, 100_000] {
            let scene = cloud(name, count);
            let view = view(&scene, 1.0);
            let mut prepared = Splatter::default().prepare(&scene, &control).expect("a scene that it can draw");
            group.bench_with_input(BenchmarkId::new(*name, count), &view, |b, view| {
                b.iter(|| prepared.render(view, &control).expect("a frame"));
            });
        }
    }
}

fn preparation(c: &mut Criterion) {
    let control = Control::default().with_threads(1);
    let mut group = c.benchmark_group("prepare");
    group.sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(1));
    for name in ["blobs", "fog"] {
        let scene = grid(name);
        for (how, renderer) in renderers() {
            group.bench_function(BenchmarkId::new(name, how), |b| {
                b.iter(|| renderer.prepare(&scene, &control).expect("a scene that it can draw"));
            });
        }
    }
}

criterion_group!(benches, frames, preparation);
criterion_main!(benches);
