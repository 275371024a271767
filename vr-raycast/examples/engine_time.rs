//! Time of pictures by packets of sixteen rays beside that of the plain engine, of volumes that are no uniform grids, on one thread, in seconds of a processor:
//! `cargo run --release -p vr-raycast --example engine_time [part of a volume's name|all] [part of a look's name|all] [size] [repeats] [thousands of points] [cells along an edge]`.
//!
//! Both engines draw in turn; each counts with its best time.

mod processor_time;

use std::sync::Arc;

use glam::DVec3;
use vr_core::amr::{AmrCentring, AmrGrid, AmrSampling};
use vr_core::labels::{LabelMap, LabelStyle, LabelledGrid};
use vr_core::rectilinear::{Centering, RectilinearGrid};
use vr_core::*;
use vr_raycast::{RayCaster, Vector};

use processor_time::processor_seconds;

/// Waves over the unit cube, between 0 and 1.
fn wave(p: DVec3) -> f32 {
    (0.5 + 0.5 * (9.0 * p.x).sin() * (7.0 * p.y).cos() * (5.0 * p.z).sin()) as f32
}

/// A grid over the unit cube whose cells grow by a twentieth from both ends to the middle.
fn rectilinear(side: usize) -> Volume {
    let mut places = vec![0.0];
    (0..side - 1).for_each(|k| places.push(places[k] + 1.05f64.powi(k.min(side - 2 - k) as i32)));
    let places: Vec<f64> = places.iter().map(|p| p / places[side - 1]).collect();
    let mut values = Vec::with_capacity(side.pow(3));
    for &z in &places {
        for &y in &places {
            values.extend(places.iter().map(|&x| wave(DVec3::new(x, y, z))));
        }
    }
    let axes = [places.clone(), places.clone(), places];
    Volume::Rectilinear(Arc::new(RectilinearGrid::new(axes, values, Centering::Points).expect("places rise")))
}

/// A grid over the unit cube with labels, which are drawn as `transfer` says under the first: the volume as it is, tinted, solid, and hidden.
fn labelled(side: usize, transfer: &TransferFunction) -> (Volume, TransferFunction) {
    let at = |i: usize| DVec3::from_array([i % side, i / side % side, i / side / side].map(|k| k as f64)) / side as f64;
    let placement = Placement::from_spacing([1.0 / side as f64; 3]).expect("edges are positive");
    let of = |samples: Vec<f32>| UniformGrid::new([side; 3], samples, placement, Calibration::default());
    let values = of((0..side.pow(3)).map(|i| wave(at(i))).collect()).expect("one for each voxel");
    // Shells around the middle, an eighth of the cube thick.
    let shell = |i: usize| ((8.0 * at(i).distance(DVec3::splat(0.5))) as usize).min(3) as f32;
    let labels = of((0..side.pow(3)).map(shell).collect()).expect("one for each voxel");
    let style = |label| match label {
        0 => LabelStyle::Solid { color: [1.0, 0.2, 0.1], opacity: 0.1 },
        1 => LabelStyle::Hidden,
        2 => LabelStyle::Tinted { color: [0.2, 1.0, 0.4], opacity: 0.5 },
        _ => LabelStyle::VOLUME,
    };
    let volume = Arc::new(GridVolume::new(values.into(), Filter::Trilinear));
    let map = Arc::new(LabelMap::new(&labels.into()).expect("whole numbers"));
    let field = LabelledGrid::new(volume, map, style).expect("both cover the cube");
    let transfer = field.transfer(transfer).expect("it is by value alone");
    (Volume::Field(Arc::new(field)), transfer)
}

/// A mesh over the unit cube in blocks of 16³ cells, of three levels, fine near the surface of a ball.
fn adaptive(side: usize) -> Volume {
    let sampling = AmrSampling {
        origin: DVec3::ZERO,
        edge: 64.0 / side as f64,
        blocks: [side / 64; 3],
        block_cells: [16; 3],
        ratios: vec![[2; 3]; 2],
        centring: AmrCentring::Cells,
    };
    let near = |low: DVec3, high: DVec3, _: usize| {
        ((0.5 * (low + high)).distance(DVec3::splat(0.5)) - 0.3).abs() < 0.6 * (high - low).length()
    };
    AmrGrid::refining(&sampling, wave, near).expect("sizes are sound").into()
}

/// Volumes by name, each with its transfer function.
fn volumes(side: usize, count: usize) -> Vec<(&'static str, Volume, TransferFunction)> {
    let points = |name: &str| phantom::points_by_name(name, count).expect("it is one");
    let transfer_of = |name: &str| {
        let (control_points, unit) = phantom::point_transfer_function(name).expect("it is one");
        TransferFunction::new(control_points, OpacityRule::Power, unit).expect("it is one")
    };
    let color = |k: usize| [k % 3, k % 5, k % 7].map(|c| 0.4 + 0.1 * c as f32);
    let of_grid = vec![
        ControlPoint::new(0.2, [0.2, 0.4, 1.0], 0.0),
        ControlPoint::new(0.6, [1.0, 0.9, 0.6], 0.02),
        ControlPoint::new(1.0, [1.0, 0.7, 0.2], 0.1),
    ];
    let of_grid = TransferFunction::new(of_grid, OpacityRule::Power, 1.0 / side as f64).expect("it is one");
    let (labels, of_labels) = labelled(side, &of_grid);
    let mean = || points("turbulence").with_mixing(PointMixing::Mean).expect("weights are positive");
    let colored = |points: PointSet| points.with_colors((0..count).map(color).collect()).expect("they are colours");
    vec![
        ("rectilinear", rectilinear(side), of_grid.clone()),
        ("adaptive", adaptive(side), of_grid),
        ("labels", labels, of_labels),
        ("sums", points("turbulence").into(), transfer_of("turbulence")),
        ("means", mean().into(), transfer_of("turbulence")),
        ("coloured sums", colored(points("turbulence")).into(), transfer_of("turbulence")),
        ("coloured means", colored(mean()).into(), transfer_of("turbulence")),
        ("plummer", points("plummer").into(), transfer_of("plummer")),
    ]
}

/// Scenes of a volume by name. Steep is a field that goes through all of its values in a fifth of the volume.
fn looks(volume: &Volume, transfer: &TransferFunction) -> Vec<(&'static str, Scene)> {
    let ((low, high), (from, to)) = (volume.bounds(), volume.value_range().expect("it has values"));
    let steep = (to - from) / (0.2 * (high - low).max_element());
    let plain = Scene::new(volume.clone(), transfer.clone());
    let with = |shading: Shading| Scene { shading: Some(Arc::new(shading)), ..plain.clone() };
    let factors = |shading: Shading| Shading { gradient_opacity: vec![(0.0, 0.2), (steep, 2.0)], ..shading };
    let thin = |p: &ControlPoint| ControlPoint { opacity: 0.1 * p.opacity, ..*p };
    let rows = vec![(0.0, transfer.points().iter().map(thin).collect()), (steep, transfer.points().to_vec())];
    let rows = TransferFunction::of_rows(rows, transfer.rule(), transfer.unit_distance()).expect("they go together");
    let by_rows = Scene { transfer: Arc::new(rows), ..plain.clone() };
    let picking = |compositing: Compositing| Scene { compositing, ..plain.clone() };
    let first = Compositing::First { threshold: from + 0.7 * (to - from) };
    vec![
        ("maximum", picking(Compositing::Maximum)),
        ("minimum", picking(Compositing::Minimum)),
        ("average", picking(Compositing::Average)),
        ("first", picking(first)),
        ("first-lit", Scene { compositing: first, ..with(Shading::default()) }),
        ("shaded", with(Shading::default())),
        ("gradient-opacity", with(factors(Shading::flat()))),
        ("gradient-opacity-shaded", with(factors(Shading::default()))),
        ("rows-shaded", Scene { shading: Some(Arc::new(Shading::default())), ..by_rows.clone() }),
        ("rows", by_rows),
        ("unshaded", plain),
    ]
}

fn main() {
    let arg = |i: usize, or: &str| std::env::args().nth(i).unwrap_or_else(|| or.to_owned());
    let number = |i: usize, or: &str| arg(i, or).parse::<usize>().expect("a number");
    let (which, how) = (arg(1, "all"), arg(2, "all"));
    let (size, repeats, count, side) = (number(3, "160"), number(4, "2"), 1000 * number(5, "20"), number(6, "128"));
    let control = Control::default().with_threads(1);
    let is_asked = |asked: &str, name: &str| asked == "all" || name.contains(asked);
    for (name, volume, transfer) in volumes(side, count).into_iter().filter(|v| is_asked(&which, v.0)) {
        let view = View::new(Camera::framing(volume.bounds(), 33.0, 21.0, None), [size as u32; 2]);
        for (look, scene) in looks(&volume, &transfer).into_iter().filter(|l| is_asked(&how, l.0)) {
            // Codes of labels are not compared, nor told apart by gradients.
            let has_codes = scene.volume.field().is_some_and(|field| field.values_are_codes());
            if has_codes && (!scene.compositing.integrates_light() || scene.transfer.has_rows()) {
                continue;
            }
            let mut engines = [Vector::Auto, Vector::Off].map(|vector| {
                let caster = RayCaster { vector, ..RayCaster::uniform(0.5) };
                (caster.prepare(&scene, &control).expect("it can draw this"), f64::INFINITY, None)
            });
            for _ in 0..repeats {
                for (prepared, best, last) in &mut engines {
                    let start = processor_seconds();
                    let rendered = prepared.render(&view, &control).expect("it is drawn");
                    *best = best.min(processor_seconds() - start);
                    *last = Some(rendered.frame);
                }
            }
            let [(_, packets, Some(x)), (_, plain, Some(y))] = &engines else { unreachable!("both have drawn") };
            let pairs = x.pixels().as_flattened().iter().zip(y.pixels().as_flattened());
            let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            let ratio = plain / packets;
            let (packets, plain) = (1e3 * packets, 1e3 * plain);
            println!(
                "{name}, {look}: packets {packets:.1} ms, plain {plain:.1} ms, {ratio:.2} times as fast, off by {off:.1e} at most"
            );
        }
    }
}
