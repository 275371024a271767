//! Time of a sample in some volumes beside that in a uniform grid of the same dims.

use std::sync::Arc;
use std::time::Instant;

use glam::{DMat3, DVec3};
use vr_core::{
    Calibration, Camera, Control, ControlPoint, OpacityRule, Placement, Renderer, Scene, Shading, TransferFunction,
    UniformGrid, View, Volume,
};
use vr_raycast::{CompositingOrder, EmptySpace, RayCaster};

/// Finest cells along the edge of the unit cube: the fourth argument of the program, 128 if it is not given. Pictures have half as many pixels again.
pub fn side() -> usize {
    std::env::args().nth(4).and_then(|n| n.parse().ok()).unwrap_or(128)
}

/// Value that all volumes sample.
pub fn value(p: DVec3) -> f32 {
    (0.5 + 0.5 * (9.0 * p.x).sin() * (7.0 * p.y).cos() * (5.0 * p.z).sin()) as f32
}

/// Prints the time of a sample in the plain engine and in packets, of volumes whose names hold the first argument of the program; a uniform grid comes first.
/// The second argument, `plain`, `packets`, `shaded` or `all`, leaves ways of drawing out; the third is the number of frames, of which the fastest counts, the fourth [`side`].
pub fn print(volumes: Vec<(&str, Volume)>) {
    let side = side();
    let step = 1.0 / side as f64;
    let at = |i: usize| DVec3::new((i % side) as f64, (i / side % side) as f64, (i / (side * side)) as f64);
    let samples: Vec<f32> = (0..side.pow(3)).map(|i| value((at(i) + 0.5) * step)).collect();
    let placement =
        Placement::new(DVec3::splat(0.5 * step), DMat3::from_diagonal(DVec3::splat(step))).expect("it is one");
    let uniform = UniformGrid::new([side; 3], samples, placement, Calibration::default()).expect("it is one");
    let points = vec![ControlPoint::new(0.0, [0.2, 0.4, 1.0], 0.001), ControlPoint::new(1.0, [1.0, 0.7, 0.2], 0.01)];
    let transfer = TransferFunction::new(points, OpacityRule::Power, step).expect("it is one");
    let view =
        View::new(Camera::framing((DVec3::ZERO, DVec3::ONE), 35.0, 25.0, Some(40.0)), [(side * 3 / 2) as u32; 2]);
    let control = Control::default().with_threads(1);
    let plain = RayCaster { empty_space: EmptySpace::None, ..RayCaster::exact(0.5) };
    let packets =
        RayCaster { empty_space: EmptySpace::None, order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.5) };
    let shaded = |scene: &Scene| Scene { shading: Some(Arc::new(Shading::default())), ..scene.clone() };
    // Times of a sample in the uniform grid.
    let mut first = [None; 3];
    let only = std::env::args().nth(1);
    let kind = std::env::args().nth(2);
    let frames = std::env::args().nth(3).and_then(|n| n.parse().ok()).unwrap_or(5);
    println!("{:<32} {:>10}  {:^22} {:^22} {:^22}", "ns a sample", "samples", "plain", "packets", "packets, shaded");
    let is_asked = |name: &str| only.as_ref().is_none_or(|only| name.contains(only));
    let volumes = volumes.into_iter().filter(|(name, _)| is_asked(name));
    for (name, volume) in std::iter::once(("uniform grid", uniform.into())).chain(volumes) {
        let scene = Scene::new(volume, transfer.clone());
        let mut line = String::new();
        let mut taken = 0;
        for (i, (caster, scene)) in
            [(&plain, scene.clone()), (&packets, scene.clone()), (&packets, shaded(&scene))].into_iter().enumerate()
        {
            if kind.as_ref().is_some_and(|kind| kind != "all" && *kind != ["plain", "packets", "shaded"][i]) {
                continue;
            }
            let mut prepared = caster.prepare(&scene, &control).expect("it can draw this");
            let mut best = f64::INFINITY;
            for _ in 0..frames {
                let begin = Instant::now();
                let rendered = prepared.render(&view, &control).expect("it is drawn");
                best = best.min(begin.elapsed().as_secs_f64());
                taken = rendered.stats.counts.samples;
            }
            let each = best / taken as f64 * 1e9;
            let beside = each / *first[i].get_or_insert(each);
            line += &format!("  {each:7.1}, {beside:4.2} times");
        }
        println!("{name:<32} {taken:10}{line}");
    }
}
