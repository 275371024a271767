//! Tables of the time that the choice of rays saves, and of how far it changes the picture.
//!
//! `cargo bench -p vr-raycast --bench screen` times single pictures. With `-- --table` it prints the tables of `docs/figures/vr-raycast.md`
//! instead: pictures of 512×512 at a step of one voxel, against every pixel's rays in the same run.
//!
//! The real scan is `nrrd/tooth.raw` of the directory `VR_TEST_DATA`; without it, its rows are left out.

use std::path::Path;

use criterion::{BenchmarkId, Criterion};
use vr_core::phantom::{self, Phantom};
use vr_core::{
    Calibration, Camera, Control, ControlPoint, Frame, OpacityRule, Placement, Renderer, Scene, TransferFunction,
    UniformGrid, View,
};
use vr_raycast::{Connectivity, ImageSampling, RayCaster, Step};

fn of_phantom(name: &str, n: usize) -> Scene {
    let phantom: Box<dyn Phantom> = phantom::by_name(name).expect("a known phantom");
    phantom::sampled_scene::<u8>(&*phantom, n, 1.0).expect("a valid size")
}

/// The tooth: 103×94×161 samples of 16 bits, big endian, 0 to 1300; air below 400, dentine about 800, enamel above 1000.
fn of_tooth(opacity: f64) -> Option<Scene> {
    let path = Path::new(&std::env::var_os("VR_TEST_DATA")?).join("nrrd/tooth.raw");
    let bytes = std::fs::read(path).ok()?;
    let samples: Vec<u16> = bytes.chunks_exact(2).map(|b| u16::from_be_bytes([b[0], b[1]])).collect();
    let placement = Placement::from_spacing([1.0; 3]).expect("valid spacing");
    let grid = UniformGrid::new([103, 94, 161], samples, placement, Calibration::default()).ok()?;
    let points = vec![
        ControlPoint::new(500.0, [0.9, 0.7, 0.5], 0.0),
        ControlPoint::new(700.0, [0.9, 0.7, 0.5], opacity),
        ControlPoint::new(1000.0, [1.0, 1.0, 0.9], opacity),
    ];
    Some(Scene::new(grid.into(), TransferFunction::new(points, OpacityRule::Power, 1.0).expect("valid points")))
}

fn scenes(n: usize) -> Vec<(&'static str, Scene)> {
    let mut scenes = vec![("dense fog", of_phantom("fog", n)), ("sparse blobs", of_phantom("blobs", n))];
    scenes.extend(of_tooth(0.95).map(|scene| ("tooth, opaque", scene)));
    scenes.extend(of_tooth(0.02).map(|scene| ("tooth, translucent", scene)));
    scenes
}

fn view(scene: &Scene, size: u32, azimuth: f64, fov: Option<f64>) -> View {
    View::new(Camera::framing(scene.volume.bounds(), 20.0, 15.0, fov).orbit(azimuth, 0.0), [size; 2])
}

fn caster(screen: ImageSampling) -> RayCaster {
    RayCaster { image_sampling: screen, step: Step::Uniform(1.0), ..RayCaster::uniform(0.2) }
}

const SCREENS: [(&str, ImageSampling); 6] = [
    ("every-pixel", ImageSampling::EveryPixel),
    ("adaptive", ImageSampling::Adaptive { threshold: 0.05 }),
    ("coherent", ImageSampling::Coherent),
    ("template-discrete", ImageSampling::Template { connectivity: Connectivity::Discrete }),
    ("template-continuous", ImageSampling::Template { connectivity: Connectivity::Continuous }),
    ("template-faces", ImageSampling::Template { connectivity: Connectivity::Faces }),
];

/// Processor time of this process in user mode, in seconds: wall-clock time says more of what else the machine does. Linux only.
fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").expect("Linux");
    // The name, in parentheses, may hold blanks; user time is the 14th field, in hundredths of a second.
    let rest = stat.rsplit(')').next().expect("a name");
    rest.split_whitespace().nth(11).and_then(|t| t.parse::<f64>().ok()).expect("a number") / 100.0
}

/// Totals over some pictures.
struct Taken {
    seconds: f64,
    /// Part of `seconds` spent on the projection of the coherent screen; wall-clock time.
    projection: f64,
    samples: u64,
    frames: Vec<Frame>,
}

fn run(caster: &RayCaster, scene: &Scene, views: &[View]) -> Taken {
    let control = Control::default().with_threads(1);
    let mut prepared = caster.prepare(scene, &control).expect("a scene that it can draw");
    let start = processor_seconds();
    let mut taken = Taken { seconds: 0.0, projection: 0.0, samples: 0, frames: Vec::new() };
    for view in views {
        let rendered = prepared.render(view, &control).expect("a view that it can draw");
        let stages = rendered.stats.stages.iter().filter(|(name, _)| *name == "projection");
        taken.projection += stages.map(|(_, time)| time.as_secs_f64()).sum::<f64>();
        taken.samples += rendered.stats.counts.samples;
        taken.frames.push(rendered.frame);
    }
    taken.seconds = processor_seconds() - start;
    taken
}

/// Largest difference and root of the mean square, over all components.
fn difference(got: &Frame, want: &Frame) -> (f64, f64) {
    let pairs = got.pixels().iter().flatten().zip(want.pixels().iter().flatten());
    let differences: Vec<f64> = pairs.map(|(a, b)| f64::from(a - b).abs()).collect();
    let square: f64 = differences.iter().map(|d| d * d).sum();
    (differences.iter().copied().fold(0.0, f64::max), (square / differences.len() as f64).sqrt())
}

fn tables() {
    let n = std::env::var("VR_BENCH_SIZE").map_or(128, |n| n.parse().expect("a number"));
    println!(
        "| scene ({n}³; tooth 103×94×161) | turntable | every pixel, ms | coherent, ms | of it projection | gain | samples left |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (name, scene) in scenes(n) {
        for degrees in [10.0, 1.0] {
            let views: Vec<View> = (0..36).map(|k| view(&scene, 512, degrees * f64::from(k), None)).collect();
            let plain = run(&caster(ImageSampling::EveryPixel), &scene, &views);
            let coherent = run(&caster(ImageSampling::Coherent), &scene, &views);
            assert_eq!(coherent.frames, plain.frames, "{name}: the same pictures");
            println!(
                "| {name} | 36 × {degrees}° | {:.0} | {:.0} | {:.1} | {:.2} | {:.0} % |",
                plain.seconds / 36.0 * 1e3,
                coherent.seconds / 36.0 * 1e3,
                coherent.projection / 36.0 * 1e3,
                plain.seconds / coherent.seconds,
                100.0 * coherent.samples as f64 / plain.samples as f64
            );
        }
    }
    println!("\n| scene | screen | ms a frame | gain | largest change | RMS change |");
    println!("|---|---|---|---|---|---|");
    for (name, scene) in scenes(n) {
        let views: Vec<View> = (0..12).map(|k| view(&scene, 512, 25.0 * f64::from(k), None)).collect();
        let plain = run(&caster(ImageSampling::EveryPixel), &scene, &views);
        println!("| {name} | every-pixel | {:.0} | 1 | | |", plain.seconds / 12.0 * 1e3);
        let mut all: Vec<(String, ImageSampling)> = SCREENS[2..].iter().map(|(n, s)| ((*n).to_owned(), *s)).collect();
        for threshold in [0.02, 0.08, 0.3] {
            all.push((format!("adaptive {threshold}"), ImageSampling::Adaptive { threshold }));
        }
        for (screen_name, screen) in all {
            let taken = run(&caster(screen), &scene, &views);
            let changes = taken.frames.iter().zip(&plain.frames).map(|(got, want)| difference(got, want));
            let (largest, rms) = changes.fold((0.0, 0.0), |a: (f64, f64), b| (a.0.max(b.0), a.1.max(b.1)));
            println!(
                "| {name} | {screen_name} | {:.0} | {:.2} | {largest:.1e} | {rms:.1e} |",
                taken.seconds / 12.0 * 1e3,
                plain.seconds / taken.seconds
            );
        }
    }
}

fn pictures(c: &mut Criterion) {
    let mut group = c.benchmark_group("screen");
    group.sample_size(10).warm_up_time(std::time::Duration::from_millis(300));
    group.measurement_time(std::time::Duration::from_secs(1));
    let control = Control::default().with_threads(1);
    for (scene_name, scene) in scenes(64) {
        let view = view(&scene, 256, 0.0, None);
        for (name, screen) in SCREENS {
            let mut prepared = caster(screen).prepare(&scene, &control).expect("a scene that it can draw");
            // The first picture is where the coherent screen learns from.
            prepared.render(&view, &control).expect("a valid view");
            group.bench_function(BenchmarkId::new(name, scene_name), |b| {
                b.iter(|| prepared.render(&view, &control).expect("a valid view"));
            });
        }
    }
}

fn main() {
    if std::env::args().any(|a| a == "--table") {
        tables();
    } else {
        let mut criterion = Criterion::default().configure_from_args();
        pictures(&mut criterion);
        criterion.final_summary();
    }
}
