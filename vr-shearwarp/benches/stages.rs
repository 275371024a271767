//! Time of each stage: classification, encoding of an axis, compositing and the warp, one thread.
//!
//! `cargo bench -p vr-shearwarp --bench stages` measures volumes of 128³, 256³ and 512³ voxels; `VR_BENCH_SIZE=128` one size alone.
//! Volumes of 512³ take minutes to make and a few gigabytes.

use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, SamplingMode};
use vr_core::phantom::{self, Phantom, TRANSFER_UNIT_DISTANCE};
use vr_core::{
    Camera, Control, ControlPoint, OpacityRule, Prepared, Projection, Renderer, Scene, TransferFunction, View,
};
use vr_shearwarp::{EmptySpace, ShearWarp};

const PHANTOMS: [(&str, &str); 2] = [("dense", "fog"), ("sparse", "blobs")];
const SIZES: [usize; 3] = [128, 256, 512];
const ENCODINGS: [(&str, EmptySpace); 2] = [("runs", EmptySpace::Runs), ("octree", EmptySpace::Octree)];
/// Pixels of the picture, each way.
const PICTURE: u32 = 512;

/// A volume under two transfer functions. The second one shows less of it: a ramp that begins later.
fn scenes(name: &str, n: usize) -> [Scene; 2] {
    let phantom: Box<dyn Phantom> = phantom::by_name(name).expect("a known phantom");
    let grid = phantom::sample::<u8>(&*phantom, [n; 3]).expect("a valid size");
    let (low, high) = phantom.value_range();
    let ramp = vec![
        ControlPoint::new(low + 0.25 * (high - low), [0.2, 0.4, 0.9], 0.0),
        ControlPoint::new(high, [1.0, 0.8, 0.3], 0.2),
    ];
    let transfer = |points| TransferFunction::new(points, OpacityRule::Power, TRANSFER_UNIT_DISTANCE);
    let first = Scene::new(grid.into(), transfer(phantom.transfer_points()).expect("valid points"));
    let second = Scene { transfer: transfer(ramp).expect("valid points").into(), ..first.clone() };
    [first, second]
}

fn picture(scene: &Scene) -> View {
    View::new(Camera::framing(scene.volume.bounds(), 20.0, 15.0, None), [PICTURE; 2])
}

/// A view of next to nothing along the same axis: asks for its encoding and draws hardly a texel.
fn keyhole(scene: &Scene) -> View {
    let whole = picture(scene).camera;
    View::new(Camera { projection: Projection::Orthographic { height: 1e-3 }, ..whole }, [1; 2])
}

fn prepared(empty_space: EmptySpace, scene: &Scene, control: &Control) -> Box<dyn Prepared> {
    let renderer = ShearWarp { empty_space, ..ShearWarp::default() };
    renderer.prepare(scene, control).expect("a scene that it can draw")
}

/// The time of a stage of one picture.
fn stage(prepared: &mut dyn Prepared, view: &View, control: &Control, name: &str) -> Duration {
    let rendered = prepared.render(view, control).expect("a view that it can draw");
    rendered.stats.stages.iter().filter(|(stage, _)| *stage == name).map(|(_, time)| *time).sum()
}

fn classification(c: &mut Criterion, label: &str, n: usize, scenes: &[Scene; 2], control: &Control) {
    let mut group = group(c, "classify");
    for (encoding_name, encoding) in ENCODINGS {
        let id = |what: &str| BenchmarkId::new(format!("{what}/{encoding_name}"), format!("{label} {n}"));
        group.bench_function(id("prepare"), |b| b.iter(|| prepared(encoding, &scenes[0], control)));
        let mut renderer = prepared(encoding, &scenes[0], control);
        let mut turn = 0;
        group.bench_function(id("update"), |b| {
            b.iter(|| {
                turn ^= 1;
                renderer.update(&scenes[turn], control).expect("a scene that it can draw");
            });
        });
        // What an update leaves to the first picture; without the update's own time.
        let view = keyhole(&scenes[0]);
        group.bench_function(id("encode"), |b| {
            b.iter_custom(|iterations| {
                let mut time = Duration::ZERO;
                for _ in 0..iterations {
                    // To the second scene and back: it is always the first scene's encoding that is measured.
                    for scene in [&scenes[1], &scenes[0]] {
                        renderer.update(scene, control).expect("a scene that it can draw");
                    }
                    time += stage(&mut *renderer, &view, control, "encode");
                }
                time
            });
        });
        // All that a user waits for after a change of the transfer function, but drawing.
        group.bench_function(id("update and encode"), |b| {
            b.iter_custom(|iterations| {
                let mut time = Duration::ZERO;
                for _ in 0..iterations {
                    turn ^= 1;
                    let start = Instant::now();
                    renderer.update(&scenes[turn], control).expect("a scene that it can draw");
                    time += start.elapsed() + stage(&mut *renderer, &view, control, "encode");
                }
                time
            });
        });
    }
}

fn drawing(c: &mut Criterion, label: &str, n: usize, scene: &Scene, control: &Control) {
    let mut group = group(c, "draw");
    let view = picture(scene);
    for (encoding_name, encoding) in ENCODINGS {
        let mut renderer = prepared(encoding, scene, control);
        // The first picture encodes.
        renderer.render(&view, control).expect("a view that it can draw");
        for name in ["composite", "warp"] {
            let id = BenchmarkId::new(format!("{name}/{encoding_name}"), format!("{label} {n}"));
            group.bench_function(id, |b| {
                b.iter_custom(|iterations| (0..iterations).map(|_| stage(&mut *renderer, &view, control, name)).sum());
            });
        }
    }
}

fn group<'a>(c: &'a mut Criterion, name: &str) -> criterion::BenchmarkGroup<'a, criterion::measurement::WallTime> {
    let mut group = c.benchmark_group(name);
    // Flat: the largest volumes take a second an iteration.
    group.sample_size(10).sampling_mode(SamplingMode::Flat);
    group.warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(800));
    group
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let control = Control::default().with_threads(1);
    let only: Option<usize> = std::env::var("VR_BENCH_SIZE").ok().map(|n| n.parse().expect("a number"));
    for n in only.map_or(SIZES.to_vec(), |n| vec![n]) {
        for (label, name) in PHANTOMS {
            let scenes = scenes(name, n);
            classification(&mut criterion, label, n, &scenes, &control);
            drawing(&mut criterion, label, n, &scenes[0], &control);
        }
    }
    criterion.final_summary();
}
