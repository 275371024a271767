//! Gain and cost of leaping over empty space in the plain engine, as tables: processor time of whole frames, each beside the plain walk in
//! the same run, the best of several interleaved rounds.
//!
//! `cargo bench -p vr-raycast --bench leaping`. With VR_TEST_DATA set, also on a real scan (bonsai, 256³). The step is one voxel: with
//! shorter ones, sampling weighs more, and what is saved of it, too.

use std::io::Read;
use std::path::Path;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use vr_core::phantom::{self, Blobs, Fog, Phantom, TRANSFER_UNIT_DISTANCE};
use vr_core::*;
use vr_raycast::{EmptySpace, RayCaster, Step, Vector};

/// Time that this program's threads have spent on processors: what other programs do meanwhile does not count (but for what they do to
/// caches). Where the system does not tell, wall-clock time.
fn processor_time() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    let wall = START.elapsed();
    let of_task = |task: std::io::Result<std::fs::DirEntry>| -> Option<u64> {
        let text = std::fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        text.split(' ').next()?.parse().ok()
    };
    let tasks = std::fs::read_dir("/proc/self/task").ok();
    let sum = tasks.and_then(|tasks| tasks.map(of_task).sum::<Option<u64>>());
    sum.map_or(wall, Duration::from_nanos)
}

const ROUNDS: usize = 5;
const LEAPINGS: [(&str, EmptySpace); 7] = [
    ("none", EmptySpace::None),
    ("octree", EmptySpace::Octree),
    ("pyramid", EmptySpace::Pyramid),
    ("exact cloud", EmptySpace::ExactCloud),
    ("chessboard cloud", EmptySpace::ChessboardCloud),
    ("boxes", EmptySpace::Boxes),
    ("polyhedron", EmptySpace::Polyhedron),
];

/// A phantom as `n`³ bytes; opacities as they are meant, whatever the size.
fn scene_of(phantom: &impl Phantom, n: usize) -> Scene {
    let grid = phantom::sample::<u8>(phantom, [n; 3]).expect("a valid size");
    let points = phantom.transfer_points();
    Scene::new(
        grid.into(),
        TransferFunction::new(points, OpacityRule::Power, TRANSFER_UNIT_DISTANCE).expect("valid points"),
    )
}

/// The real scan, if there is one.
fn bonsai() -> Option<Volume> {
    let path = Path::new(&std::env::var_os("VR_TEST_DATA")?).join("nifti/bonsai.nii.gz");
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(std::fs::File::open(path).ok()?).read_to_end(&mut bytes).ok()?;
    // A NIfTI-1 header and four bytes, then 256³ bytes.
    let samples = bytes.split_off(352);
    let placement = Placement::from_spacing([1.0; 3]).ok()?;
    Some(UniformGrid::new([256; 3], samples, placement, Calibration::default()).ok()?.into())
}

fn scan_scene(volume: &Volume, opacities: [f64; 3]) -> Scene {
    let [a, b, c] = opacities;
    let points = vec![
        ControlPoint::new(20.0, [0.2, 0.1, 0.0], 0.0),
        ControlPoint::new(40.0, [0.3, 0.6, 0.2], a),
        ControlPoint::new(120.0, [0.7, 0.5, 0.3], b),
        ControlPoint::new(255.0, [1.0, 1.0, 0.9], c),
    ];
    Scene::new(volume.clone(), TransferFunction::new(points, OpacityRule::Power, 1.0).expect("valid points"))
}

/// The casters: every structure, and coarse steps.
fn casters(step: f64) -> Vec<(&'static str, RayCaster)> {
    let of = |(name, leaping)| {
        (
            name,
            RayCaster {
                step: Step::Uniform(step),
                empty_space: leaping,
                vector: Vector::Off,
                ..RayCaster::uniform(0.2)
            },
        )
    };
    let coarse = RayCaster {
        step: Step::Vicinity { coarse: 8.0, fine: step },
        empty_space: EmptySpace::None,
        ..RayCaster::uniform(0.2)
    };
    LEAPINGS.map(of).into_iter().chain([("vicinity 8", coarse)]).collect()
}

/// The largest difference of any component.
fn difference(a: &Frame, b: &Frame) -> f32 {
    let each = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    each.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn frames(name: &str, scene: &Scene, step: f64) {
    let control = Control::default().with_threads(1);
    let views: Vec<View> = [(30.0, 20.0), (75.0, -35.0)]
        .iter()
        .map(|&(azimuth, elevation)| {
            View::new(Camera::framing(scene.volume.bounds(), azimuth, elevation, None), [256, 256])
        })
        .collect();
    let casters = casters(step);
    let mut prepared: Vec<_> =
        casters.iter().map(|(_, caster)| caster.prepare(scene, &control).expect("a valid scene")).collect();
    let mut best = vec![Duration::MAX; casters.len()];
    let (mut counts, mut worst) = (vec![Counts::default(); casters.len()], vec![0f32; casters.len()]);
    for round in 0..ROUNDS {
        let mut plain: Vec<Frame> = Vec::new();
        for (i, prepared) in prepared.iter_mut().enumerate() {
            let start = processor_time();
            let pictures: Vec<_> =
                views.iter().map(|view| prepared.render(view, &control).expect("a valid view")).collect();
            best[i] = best[i].min(processor_time() - start);
            if round == 0 {
                for picture in &pictures {
                    counts[i] += picture.stats.counts;
                }
                if i == 0 {
                    plain = pictures.into_iter().map(|p| p.frame).collect();
                } else {
                    worst[i] = pictures.iter().zip(&plain).map(|(p, q)| difference(&p.frame, q)).fold(0.0, f32::max);
                }
            }
        }
    }
    for (i, (leaping, _)) in casters.iter().enumerate() {
        let gain = best[0].as_secs_f64() / best[i].as_secs_f64();
        let ms = best[i].as_secs_f64() * 1e3 / views.len() as f64;
        let samples = counts[i].samples as f64 / counts[0].samples as f64;
        println!("| {name} | {leaping} | {ms:.1} | {gain:.2} | {:.1} % | {} |", 100.0 * samples, worst[i]);
    }
}

/// Processor time, on one thread, that it takes to prepare a scene of `n`³ bytes and to change its transfer function.
fn updates(n: usize) {
    let scene = scene_of(&Blobs::default(), n);
    // Another function of the same kind: nothing is kept.
    let mut points = scene.transfer.points().to_vec();
    for point in &mut points {
        point.opacity *= 0.5;
    }
    let other = TransferFunction::new(points, scene.transfer.rule(), scene.transfer.unit_distance());
    let other = Scene { transfer: std::sync::Arc::new(other.expect("valid points")), ..scene.clone() };
    let control = Control::default().with_threads(1);
    let mut plain = Duration::ZERO;
    for (name, caster) in casters(0.2) {
        let fresh = Volume::from(scene.volume.grid().expect("it is one").values().clone());
        let fresh = Scene { volume: fresh, ..scene.clone() };
        let start = processor_time();
        drop(caster.prepare(&fresh, &control).expect("a valid scene"));
        let first = processor_time() - start;
        let mut prepared = caster.prepare(&scene, &control).expect("a valid scene");
        let mut best = Duration::MAX;
        for round in 0..4 * ROUNDS {
            let next = if round % 2 == 0 { &other } else { &scene };
            let start = processor_time();
            prepared.update(next, &control).expect("a valid scene");
            best = best.min(processor_time() - start);
        }
        if name == "none" {
            plain = best;
        }
        let [first, best, extra] = [first, best, best.saturating_sub(plain)].map(|t| t.as_secs_f64() * 1e3);
        println!("| {name} | {first:.0} | {best:.2} | {extra:.2} |");
    }
}

fn main() {
    let chosen = std::env::args().nth(1).filter(|a| !a.starts_with("--"));
    let wants = |part: &str| chosen.as_deref().is_none_or(|chosen| part.contains(chosen));
    println!("| scene | leaping | ms per frame | gain | samples | max change |\n|---|---|--:|--:|--:|--:|");
    for (name, step) in [("step 1", 1.0), ("step 0.2", 0.2)].into_iter().filter(|(name, _)| wants(name)) {
        frames(&format!("fog 256³, {name}"), &scene_of(&Fog::default(), 256), step);
        frames(&format!("blobs 256³, {name}"), &scene_of(&Blobs::default(), 256), step);
        match bonsai() {
            Some(scan) => {
                frames(&format!("bonsai opaque, {name}"), &scan_scene(&scan, [0.5, 0.8, 0.95]), step);
                frames(&format!("bonsai translucent, {name}"), &scan_scene(&scan, [0.01, 0.02, 0.05]), step);
            }
            None => eprintln!("no real scan: VR_TEST_DATA does not lead to nifti/bonsai.nii.gz"),
        }
    }
    if wants("update") {
        println!("\n| leaping | prepare ms | update ms | beyond the table |\n|---|--:|--:|--:|");
        updates(512);
    }
}
