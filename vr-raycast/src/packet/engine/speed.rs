//! Nanoseconds per sample, for development.
/// Time that this thread has run, in ns: others use the machine, too.
fn now() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux");
    text.split(' ').next().and_then(|n| n.parse().ok()).expect("a number")
}

use super::*;
use vr_core::phantom::{self, Fog, Phantom, Quantize};
use vr_core::{Camera, Control, ControlPoint, OpacityRule, Renderer, TransferFunction, UniformGrid, Volume};

pub(super) fn spots_of(view: &View) -> Vec<Spot> {
    let [w, h] = view.size;
    let mut spots = Vec::new();
    for by in 0..h.div_ceil(4) {
        for bx in 0..w.div_ceil(4) {
            for y in by * 4..(by * 4 + 4).min(h) {
                for x in bx * 4..(bx * 4 + 4).min(w) {
                    spots.push(Spot { pixel: (y * w + x) as usize, x: f64::from(x) + 0.5, y: f64::from(y) + 0.5 });
                }
            }
        }
    }
    spots
}

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

fn time(name: &str, scene: &Scene, edges: &[Option<usize>]) {
    let control = Control::default().with_threads(1);
    control.run(|| time_here(&control, name, scene, edges));
}

fn time_here(control: &Control, name: &str, scene: &Scene, edges: &[Option<usize>]) {
    let caster = RayCaster { step: 1.0, order: Order::WHOLE_RAY, ..RayCaster::default() };
    let size: u32 = std::env::var("SIZE").ok().and_then(|s| s.parse().ok()).unwrap_or(512);
    let view = View::new(Camera::framing(scene.volume.bounds(), 30.0, 20.0, None), [size, size]);
    let small = View::new(view.camera, [64, 64]);
    let mut prepared = caster.prepare(scene, control).unwrap();
    let mut plain = f64::INFINITY;
    for _ in 0..3 {
        let t = now();
        let n = prepared.render(&small, control).unwrap().stats.counts.samples;
        plain = plain.min((now() - t) / n as f64);
    }
    let volume = scene.volume.uniform().unwrap();
    let best = Level::new();
    let mut engine = PacketEngine::new(&caster, scene, volume, best).unwrap();
    let rays = Rays::new(&view).unwrap();
    let spots = spots_of(&view);
    for &edge in edges {
        engine.distances = edge.and_then(|e| PacketEngine::distances(volume, &engine.table, e));
        let mut levels = vec![best];
        if std::env::var("LEVELS").is_ok() { levels.extend([best.as_avx2().map(Level::Avx2), best.as_sse2().map(Level::Sse2)].into_iter().flatten()); }
        for level in levels {
            engine.level = level;
            let frame = PacketFrame { engine: &engine, volume, rays: &rays, view: &view };
            let (mut t0, mut n) = (f64::INFINITY, 0);
            for _ in 0..4 {
                let mut values = Vec::new();
                let mut counts = Counts::default();
                let t = now();
                for tile in spots.chunks(256) {
                    frame.trace(tile, None, &mut values, &mut counts);
                }
                t0 = t0.min((now() - t));
                n = counts.samples;
            }
            println!("{name:24} edge {edge:?} {:10} {:7.1} ms {:6.2} M samples {:6.2} ns/sample, plain {plain:6.2}, ratio {:.2}",
                format!("{level:?}").chars().take(6).collect::<String>(), t0 * 1e-6, n as f64 * 1e-6, t0 / n as f64, plain * n as f64 / t0);
        }
    }
}

#[test]
#[ignore = "timing"]
fn fog_speed() {
    for n in [256usize, 512] {
        if std::env::var("N").is_ok_and(|v| v != n.to_string()) { continue; }
        time(&format!("fog u8 {n}"), &fog::<u8>(n), &[None]);
        if std::env::var("U8").is_ok() { continue; }
        time(&format!("fog u16 {n}"), &fog::<u16>(n), &[None]);
        time(&format!("fog f32 {n}"), &fog::<f32>(n), &[None]);
    }
}

#[test]
#[ignore = "timing"]
fn empty_speed() {
    let mut scene = fog::<u8>(64);
    let points = vec![ControlPoint::new(0.0, [0.1, 0.3, 1.0], 0.0)];
    scene.transfer = Arc::new(TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap());
    time("empty", &scene, &[None, Some(8)]);
    scene = fog::<u8>(64);
    let points = vec![ControlPoint::new(0.0, [0.1, 0.3, 1.0], 1.0)];
    scene.transfer = Arc::new(TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap());
    time("wall", &scene, &[None, Some(8)]);
}
