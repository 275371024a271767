//! Time of pictures by packets of sixteen rays beside that of the plain engine, on one thread:
//! `cargo run --release -p vr-raycast --example packet_time [case|all] [both|packets|plain] [phantom] [voxels an edge] [size] [repeats] [filter] [u8|u16|f32]`.
//!
//! Both engines draw in turn, so that a busy machine is as busy for the one as for the other; each counts with its best time.
use std::sync::Arc;
use std::time::Instant;

use vr_core::phantom::{self, sample};
use vr_core::*;
use vr_raycast::{RayCaster, Rule, Step, Vector};

/// A thing to draw: its name, the change to the scene, and the caster.
type Case = (&'static str, fn(&mut Scene), RayCaster);

fn shade(scene: &mut Scene) {
    scene.shading = Some(Arc::new(Shading::default()));
}

fn shade_analytic(scene: &mut Scene) {
    scene.shading = Some(Arc::new(Shading { gradient: GradientMethod::Analytic, ..Shading::default() }));
}

fn modulate(scene: &mut Scene) {
    let shading = Shading { gradient_opacity: vec![(0.0, 0.2), (0.5, 2.0)], ..Shading::default() };
    scene.shading = Some(Arc::new(shading));
}

/// Makes every thousandth voxel a missing one.
fn pierce(scene: &mut Scene) {
    let grid = scene.volume.grid().unwrap();
    let [nx, ny, nz] = grid.dims();
    let place = |i: usize| [i % nx, i / nx % ny, i / (nx * ny)].map(|x| x as f64);
    let value =
        |i: usize| if i.is_multiple_of(997) { f64::NAN } else { grid.calibration().value(grid.stored_at(place(i))) };
    let samples: Vec<f32> = (0..nx * ny * nz).map(|i| value(i) as f32).collect();
    let filter = grid.filter();
    let grid = UniformGrid::new([nx, ny, nz], samples, *grid.placement(), Calibration::default()).unwrap();
    scene.volume = Volume::from(grid).with_filter(filter);
}

fn color(scene: &mut Scene) {
    let grid = scene.volume.grid().unwrap();
    let channel = |c: usize| (0..grid.dims().iter().product()).map(|i: usize| ((i >> (4 * c)) * 4096) as u16).collect();
    let colors = ColorGrid::new((**grid).clone(), [channel(0), channel(1), channel(2)]).unwrap();
    scene.volume = Volume::Color(Arc::new(colors));
}

/// Gives the transfer function two rows by gradient: a tenth of its opacity where the field is flat, and all of it where it is steep.
fn by_rows(scene: &mut Scene) {
    let transfer = &scene.transfer;
    let thin = |p: &ControlPoint| ControlPoint { opacity: 0.1 * p.opacity, ..*p };
    let rows = vec![
        (0.0, transfer.points().iter().map(thin).collect()),
        (0.5, transfer.points().iter().map(|p| ControlPoint { opacity: p.opacity.min(0.99), ..*p }).collect()),
    ];
    let rows = TransferFunction::of_rows(rows, transfer.rule(), transfer.unit_distance()).unwrap();
    scene.transfer = Arc::new(rows);
}

fn accumulate(scene: &mut Scene) {
    scene.compositing = Compositing::Accumulate { level: 0.9 };
}

fn cases() -> Vec<Case> {
    let (uniform, local) =
        (RayCaster::uniform(0.5), RayCaster { step: Step::Local { error: 1e-3 }, ..RayCaster::uniform(0.5) });
    let rule = |rule| RayCaster { rule, ..RayCaster::uniform(0.5) };
    let local_rule = |rule| RayCaster { rule, ..local.clone() };
    // In steps of which the long ones err by a thousandth.
    let homogeneous = RayCaster { step: Step::Homogeneous { step: 0.5, error: 1e-3 }, ..RayCaster::default() };
    let variance = RayCaster { step: Step::Variance { step: 0.5, error: 1e-3 }, ..RayCaster::default() };
    let (local_linear, local_quadratic) = (local_rule(Rule::Linear), local_rule(Rule::Quadratic));
    vec![
        ("over", |_| (), uniform.clone()),
        ("over-shaded", shade, uniform.clone()),
        ("over-local", |_| (), local.clone()),
        ("accumulate", accumulate, uniform.clone()),
        (
            "accumulate-shaded",
            |scene| {
                accumulate(scene);
                shade(scene);
            },
            uniform,
        ),
        ("accumulate-local", accumulate, local.clone()),
        ("linear", |_| (), rule(Rule::Linear)),
        ("linear-shaded", shade, rule(Rule::Linear)),
        ("quadratic", |_| (), rule(Rule::Quadratic)),
        ("quadratic-shaded", shade, rule(Rule::Quadratic)),
        ("linear-local", |_| (), local_linear.clone()),
        ("linear-local-shaded", shade, local_linear.clone()),
        ("quadratic-local", |_| (), local_quadratic.clone()),
        ("quadratic-local-shaded", shade, local_quadratic),
        ("rows", by_rows, RayCaster::uniform(0.5)),
        (
            "rows-shaded",
            |scene| {
                by_rows(scene);
                shade(scene);
            },
            RayCaster::uniform(0.5),
        ),
        ("rows-local", by_rows, local.clone()),
        ("homogeneity", |_| (), homogeneous.clone()),
        ("homogeneity-shaded", shade, homogeneous.clone()),
        ("homogeneity-accumulate", accumulate, homogeneous),
        ("variance", |_| (), variance.clone()),
        ("variance-shaded", shade, variance),
        ("linear-gradient-opacity", modulate, rule(Rule::Linear)),
        ("quadratic-gradient-opacity", modulate, rule(Rule::Quadratic)),
        ("linear-local-gradient-opacity", modulate, local_linear.clone()),
        ("linear-holes", pierce, rule(Rule::Linear)),
        ("quadratic-holes", pierce, rule(Rule::Quadratic)),
        ("linear-local-holes", pierce, local_linear),
        ("over-shaded-analytic", shade_analytic, RayCaster::uniform(0.5)),
        ("maximum", |scene| scene.compositing = Compositing::Maximum, RayCaster::uniform(0.5)),
        ("colors", color, RayCaster::uniform(0.5)),
        (
            "colors-shaded",
            |scene| {
                color(scene);
                shade(scene);
            },
            RayCaster::uniform(0.5),
        ),
    ]
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let arg = |i: usize, or: &str| args.get(i).cloned().unwrap_or_else(|| or.to_owned());
    let number = |i: usize, or: &str| arg(i, or).parse::<usize>().unwrap();
    let (case, who, name) = (arg(0, "all"), arg(1, "both"), arg(2, "fog"));
    let (n, size, repeats) = (number(3, "128"), number(4, "512") as u32, number(5, "5"));
    let control = Control::default().with_threads(1);
    let phantom = phantom::by_name(&name).unwrap();
    let filter = Filter::from_name(&arg(6, "trilinear")).unwrap();
    let volume = match &*arg(7, "u8") {
        "u16" => Volume::from(sample::<u16>(&*phantom, [n; 3]).unwrap()),
        "f32" => Volume::from(sample::<f32>(&*phantom, [n; 3]).unwrap()),
        _ => Volume::from(sample::<u8>(&*phantom, [n; 3]).unwrap()),
    };
    let volume = volume.with_filter(filter);
    let points = phantom.transfer_points();
    let transfer = TransferFunction::new(points, OpacityRule::Power, phantom::TRANSFER_UNIT_DISTANCE).unwrap();
    let plain = Scene::new(volume, transfer);
    let view = View::new(Camera::framing(plain.volume.bounds(), 33.0, 21.0, None), [size, size]);
    for (name, change, caster) in cases().into_iter().filter(|(name, ..)| case == "all" || *name == case) {
        let mut scene = plain.clone();
        change(&mut scene);
        let engines = [("packets", caster.vector), ("plain", Vector::Off)];
        let mut engines: Vec<_> = engines
            .into_iter()
            .filter(|(engine, _)| who == "both" || who == *engine)
            .map(|(engine, vector)| {
                let caster = RayCaster { vector, ..caster.clone() };
                (engine, caster.prepare(&scene, &control).unwrap(), f64::INFINITY, None)
            })
            .collect();
        for _ in 0..repeats {
            for (_, prepared, best, last) in &mut engines {
                let start = Instant::now();
                let rendered = prepared.render(&view, &control).unwrap();
                *best = best.min(start.elapsed().as_secs_f64());
                *last = Some(rendered);
            }
        }
        for (engine, _, best, last) in &engines {
            println!(
                "{name} {engine}: {:.1} ms, {:?} samples",
                1e3 * best,
                last.as_ref().unwrap().stats.counts.samples
            );
        }
        if let [(_, _, a, Some(x)), (_, _, b, Some(y))] = &engines[..] {
            let pairs = x.frame.pixels().as_flattened().iter().zip(y.frame.pixels().as_flattened());
            let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            println!("{name}: {:.2} times as fast, off by {off:.1e} at most", b / a);
        }
    }
}
