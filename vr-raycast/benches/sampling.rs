//! Nanoseconds per sample, on one core: of the plain engine, and of the vector one, which has to beat it.
//!
//! `average` costs sampling and a sum, in the plain engine alone; `over` adds table and compositing, in both (`packets`: the vector one).
//! All take every sample of every ray of an oblique view,
//! at a step of one voxel, through fog that is transparent enough for no ray to end early. The error that belongs to a speed is
//! in the tests: `convergence.rs` prints it.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use vr_core::phantom::{self, Fog, Phantom, Quantize};
use vr_core::{
    Camera, Compositing, Control, ControlPoint, OpacityRule, Renderer, Scene, TransferFunction, UniformGrid, View,
    Volume,
};
use vr_raycast::{CompositingOrder, RayCaster, Step, Vector};

/// Fog of `n`³ samples of a type, thin: opacity 10⁻³ a voxel at most.
fn fog<T: Quantize>(n: usize) -> Scene
where
    Volume: From<UniformGrid<T>>,
{
    let fog = Fog::new(1);
    let (low, high) = fog.value_range();
    let grid = phantom::sample::<T>(&fog, [n; 3]).expect("a valid size");
    let points = vec![
        ControlPoint::new(low, [0.1, 0.3, 1.0], 0.0),
        ControlPoint::new(0.5 * (low + high), [0.8, 0.8, 0.8], 2e-4),
        ControlPoint::new(high, [1.0, 0.6, 0.2], 1e-3),
    ];
    let unit = 2.0 / (n - 1) as f64;
    Scene::new(grid.into(), TransferFunction::new(points, OpacityRule::Power, unit).expect("valid points"))
}

fn samples(c: &mut Criterion) {
    let mut group = c.benchmark_group("sample");
    group.sample_size(10).warm_up_time(std::time::Duration::from_millis(300));
    group.measurement_time(std::time::Duration::from_secs(1));
    let control = Control::default().with_threads(1);
    for n in [128, 256, 512] {
        for (name, scene) in [("u8", fog::<u8>(n)), ("u16", fog::<u16>(n)), ("f32", fog::<f32>(n))] {
            for (word, compositing, vector) in [
                ("average", Compositing::Average, Vector::Off),
                ("over", Compositing::Over, Vector::Off),
                ("packets", Compositing::Over, Vector::Auto),
            ] {
                let scene = Scene { compositing, ..scene.clone() };
                let step = Step::Uniform(1.0);
                let caster = RayCaster { step, vector, order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) };
                let mut prepared = caster.prepare(&scene, &control).expect("a uniform grid");
                let view = View::new(Camera::framing(scene.volume.bounds(), 30.0, 20.0, None), [64, 64]);
                let counts = prepared.render(&view, &control).expect("a valid view").stats.counts;
                group.throughput(Throughput::Elements(counts.samples));
                let id = BenchmarkId::new(format!("{word}/{name}"), n);
                group.bench_function(id, |b| b.iter(|| prepared.render(&view, &control).expect("a valid view")));
            }
        }
    }
}

fn frames(c: &mut Criterion) {
    let mut group = c.benchmark_group("frame");
    group.sample_size(10).warm_up_time(std::time::Duration::from_millis(300));
    group.measurement_time(std::time::Duration::from_secs(2));
    let scene = fog::<u8>(128);
    for threads in [1, 2] {
        let control = Control::default().with_threads(threads);
        let mut prepared = RayCaster::uniform(0.2).prepare(&scene, &control).expect("a uniform grid");
        let view = View::new(Camera::framing(scene.volume.bounds(), 30.0, 20.0, Some(30.0)), [256, 256]);
        group.bench_function(BenchmarkId::new("fog 128 u8, 256x256, threads", threads), |b| {
            b.iter(|| prepared.render(&view, &control).expect("a valid view"));
        });
    }
}

criterion_group!(benches, samples, frames);
criterion_main!(benches);
