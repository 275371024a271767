//! Time of a sample in adaptive meshes beside that in a uniform grid, in the same engine: `cargo run --release -p vr-raycast --example amr_time`.

use std::time::Instant;

use glam::{DMat3, DVec3};
use vr_core::amr::{AmrCentring, AmrGrid, AmrSampling};
use vr_core::{
    Calibration, Camera, Control, ControlPoint, OpacityRule, Placement, Renderer, Scene, TransferFunction, UniformGrid,
    View, Volume,
};
use vr_raycast::{EmptySpace, RayCaster};

/// Finest cells along the edge of the unit cube.
const SIDE: usize = 128;

fn main() {
    let value = |p: DVec3| (0.5 + 0.5 * (9.0 * p.x).sin() * (7.0 * p.y).cos() * (5.0 * p.z).sin()) as f32;
    let step = 1.0 / SIDE as f64;
    let at = |i: usize| DVec3::new((i % SIDE) as f64, (i / SIDE % SIDE) as f64, (i / (SIDE * SIDE)) as f64);
    let samples: Vec<f32> = (0..SIDE.pow(3)).map(|i| value((at(i) + 0.5) * step)).collect();
    let placement =
        Placement::new(DVec3::splat(0.5 * step), DMat3::from_diagonal(DVec3::splat(step))).expect("it is one");
    let uniform = UniformGrid::new([SIDE; 3], samples, placement, Calibration::default()).expect("it is one");
    let mesh = |levels: usize, block: usize, centring| {
        let sampling = AmrSampling {
            origin: DVec3::ZERO,
            edge: (block << (levels - 1)) as f64 * step,
            blocks: [(SIDE / block) >> (levels - 1); 3],
            block_cells: [block; 3],
            ratios: vec![[2; 3]; levels - 1],
            centring,
        };
        // Fine near the surface of a ball.
        let near = |low: DVec3, high: DVec3, _: usize| {
            let distance = (0.5 * (low + high)).distance(DVec3::splat(0.5)) - 0.3;
            distance.abs() < 0.6 * (high - low).length()
        };
        AmrGrid::refining(&sampling, value, near).expect("sizes are sound")
    };
    let volumes: [(&str, Volume); 8] = [
        ("uniform grid", uniform.into()),
        ("1 level, one block", mesh(1, 128, AmrCentring::Cells).into()),
        ("1 level, blocks of 16", mesh(1, 16, AmrCentring::Cells).into()),
        ("1 level, blocks of 8", mesh(1, 8, AmrCentring::Cells).into()),
        ("3 levels, blocks of 16", mesh(3, 16, AmrCentring::Cells).into()),
        ("3 levels, blocks of 8", mesh(3, 8, AmrCentring::Cells).into()),
        ("1 level, points, blocks of 16", mesh(1, 16, AmrCentring::Points).into()),
        ("3 levels, points, blocks of 16", mesh(3, 16, AmrCentring::Points).into()),
    ];
    let points = vec![ControlPoint::new(0.0, [0.2, 0.4, 1.0], 0.001), ControlPoint::new(1.0, [1.0, 0.7, 0.2], 0.01)];
    let transfer = TransferFunction::new(points, OpacityRule::Power, step).expect("it is one");
    let view = View::new(Camera::framing((DVec3::ZERO, DVec3::ONE), 35.0, 25.0, Some(40.0)), [192; 2]);
    let control = Control::default().with_threads(1);
    let caster = RayCaster { empty_space: EmptySpace::None, ..RayCaster::exact(0.5) };
    let mut first = None;
    for (name, volume) in volumes {
        let mut prepared = caster.prepare(&Scene::new(volume, transfer.clone()), &control).expect("it can draw this");
        let mut best = f64::INFINITY;
        let mut samples = 0;
        for _ in 0..3 {
            let begin = Instant::now();
            let rendered = prepared.render(&view, &control).expect("it is drawn");
            best = best.min(begin.elapsed().as_secs_f64());
            samples = rendered.stats.counts.samples;
        }
        let each = best / samples as f64 * 1e9;
        let beside = each / *first.get_or_insert(each);
        println!("{name:<32} {:7.1} ms, {samples:9} samples, {each:6.1} ns each, {beside:4.2} times", best * 1e3);
    }
}
