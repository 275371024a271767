//! Bounds of the error on random scenes of a few voxels, with transfer functions that are made to break them.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use glam::DVec3;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, RngSeed, TestRunner};
use vr_core::{Camera, Control, ControlPoint, Filter, OpacityRule, Projection, Scene, TransferFunction, View, Volume};
use vr_physics::check::TestScene;

use crate::Error;
use crate::bounds::{BOUNDS, Solved, Tally};
use crate::fields;

/// Pixels along each side of a picture.
const SIDE: u32 = 6;

/// Largest number of attempts at making a scene smaller that breaks its promise.
const SHRINK_STEPS: usize = 2000;

/// Number of scenes that are drawn at once.
const JOBS: u64 = 16;

/// Sums by the look of the transfer function, under each bound.
type Tallies = BTreeMap<Look, [Tally; 3]>;

/// Look of a transfer function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Look {
    /// Jumps, of opacity and colour.
    Jumps,
    /// Triangles 10⁻⁵ to 10⁻³ of the range wide.
    Spikes,
    /// Ramps 10⁻⁴ to 10⁻¹ of the range wide.
    Ramps,
    /// Jumps and ramps up to plateaus of opacity 1.
    Walls,
    /// Any of these.
    Mixed,
    /// Any of these but for walls, 10 to 1000 times as deep.
    Dense,
}

impl Look {
    const ALL: [Self; 6] = [Self::Jumps, Self::Spikes, Self::Ramps, Self::Walls, Self::Mixed, Self::Dense];

    fn name(self) -> &'static str {
        match self {
            Self::Jumps => "jumps",
            Self::Spikes => "spikes of 1e-5 to 1e-3",
            Self::Ramps => "ramps of 1e-4 to 1e-1",
            Self::Walls => "opaque walls",
            Self::Mixed => "all of these",
            Self::Dense => "10 to 1000 times as dense",
        }
    }
}

/// One change of opacity and colour on the way up the values.
#[derive(Clone, Copy, Debug)]
enum Change {
    Jump(f64),
    Spike { width: f64, peak: f64 },
    Ramp { width: f64, to: f64 },
}

/// A change, the way to it from the one before, and the colour behind it.
type Step = (f64, Change, [f64; 3]);

fn ten_to(exponents: Range<f64>) -> impl Strategy<Value = f64> {
    exponents.prop_map(|e| libm::pow(10.0, e))
}

fn steps(look: Look) -> impl Strategy<Value = Vec<Step>> {
    let opacity = || prop_oneof![1 => Just(0.0), 3 => 0.0..1.0, 1 => 0.99..0.999_999];
    let jump = opacity().prop_map(Change::Jump).boxed();
    let spike = (ten_to(-5.0..-3.0), 0.3..0.999_999).prop_map(|(width, peak)| Change::Spike { width, peak }).boxed();
    let ramp = (ten_to(-4.0..-1.0), opacity()).prop_map(|(width, to)| Change::Ramp { width, to }).boxed();
    let wall =
        prop_oneof![Just(Change::Jump(1.0)), ten_to(-4.0..-1.0).prop_map(|width| Change::Ramp { width, to: 1.0 }),]
            .boxed();
    let change = match look {
        Look::Jumps => jump,
        Look::Spikes => spike,
        Look::Ramps => ramp,
        Look::Walls => prop_oneof![2 => wall, 1 => jump, 1 => ramp].boxed(),
        Look::Mixed => prop_oneof![jump, spike, ramp, wall].boxed(),
        Look::Dense => prop_oneof![jump, spike, ramp].boxed(),
    };
    let channel = || prop_oneof![3 => 0.0..1.0, 1 => 0.0..8.0];
    vec((0.02..0.4, change, [channel(), channel(), channel()]), 1..=4)
}

fn transfer(steps: &[Step], first: (f64, f64), unit_distance: f64, rule: OpacityRule) -> TransferFunction {
    let (mut value, mut opacity) = first;
    let mut color = [0.5; 3];
    let mut points = vec![ControlPoint::new(value - 1.0, color, opacity)];
    for &(gap, change, behind) in steps {
        value += gap;
        points.push(ControlPoint::new(value, color, opacity));
        match change {
            Change::Jump(to) => (opacity, color) = (to, behind),
            Change::Spike { width, peak } => {
                points.push(ControlPoint::new(value + 0.5 * width, behind, peak));
                value += width;
            }
            Change::Ramp { width, to } => {
                value += width;
                (opacity, color) = (to, behind);
            }
        }
        points.push(ControlPoint::new(value, color, opacity));
    }
    TransferFunction::new(points, rule, unit_distance).expect("values rise, and opacities are from 0 to 1")
}

/// Place of a camera: outside at angles, or inside at fractions of the box.
#[derive(Clone, Copy, Debug)]
enum Place {
    Outside { azimuth: f64, elevation: f64, zoom: f64 },
    Inside { eye: [f64; 3], target: [f64; 3] },
}

fn camera(volume: &Volume, place: Place, fov: Option<f64>) -> Camera {
    let (low, high) = volume.bounds();
    match place {
        Place::Outside { azimuth, elevation, zoom } => {
            let mut camera = Camera::framing((low, high), azimuth, elevation, fov);
            match &mut camera.projection {
                Projection::Orthographic { height } => *height *= zoom,
                Projection::Perspective { fov } => *fov *= zoom,
            }
            camera
        }
        Place::Inside { eye, target } => {
            let at = |p: [f64; 3]| low + (high - low) * DVec3::from(p);
            let projection = match fov {
                Some(fov) => Projection::Perspective { fov },
                None => Projection::Orthographic { height: 0.7 * (high - low).length() },
            };
            // Upright is no way that the camera looks, nearly surely.
            Camera { eye: at(eye), target: at(target), up: DVec3::new(0.31, 1.0, 0.17), projection }
        }
    }
}

/// Scenes with the looks of their transfer functions.
fn scenes() -> impl Strategy<Value = (Look, TestScene)> {
    let within = || 0.05..0.95;
    let place = prop_oneof![
        3 => (0.0..360.0, -85.0..85.0, 0.3..1.0)
            .prop_map(|(azimuth, elevation, zoom)| Place::Outside { azimuth, elevation, zoom }),
        1 => ([within(), within(), within()], [1.0..2.0, -1.0..0.0, 1.0..2.0])
            .prop_map(|(eye, target)| Place::Inside { eye, target }),
    ];
    let fov = proptest::option::of(20.0..90.0);
    let look = prop::sample::select(Look::ALL.to_vec()).prop_flat_map(|look| {
        let depth = if look == Look::Dense { ten_to(-3.0..-1.0).boxed() } else { ten_to(-1.0..1.0).boxed() };
        (Just(look), steps(look), depth)
    });
    let first = (-0.2..0.4, prop_oneof![2 => Just(0.0), 1 => 0.0..0.3]);
    let filter = prop_oneof![3 => Just(Filter::Trilinear), 1 => Just(Filter::Nearest)];
    let rule = prop_oneof![Just(OpacityRule::Power), Just(OpacityRule::Extinction)];
    (fields::volumes(), look, first, (place, fov), filter, rule).prop_map(
        |((_, volume), (look, steps, depth), first, (place, fov), filter, rule)| {
            let transfer = transfer(&steps, first, depth * volume.mean_spacing(), rule);
            let view = View::new(camera(&volume, place, fov), [SIDE; 2]);
            (look, TestScene { scene: Scene::new(volume.with_filter(filter), transfer), view })
        },
    )
}

fn solve(test: &TestScene, control: &Control) -> Result<Solved, Error> {
    let pixels = (0..SIDE * SIDE).map(|i| [i % SIDE, i / SIDE]).collect();
    Ok(Solved::new(&test.scene, &test.view, pixels, control)?)
}

/// True if a picture of the scene breaks its promise under one of the bounds.
fn breaks(test: &TestScene, control: &Control) -> Result<bool, Error> {
    let solved = solve(test, control)?;
    for bound in BOUNDS {
        let judged = solved.judge(bound, &test.scene, &test.view, control)?;
        if judged.is_some_and(|judged| judged.breaks_its_promise()) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Draws the scenes of some seeds under each bound, and prints the tables.
pub fn count(seeds: Range<u64>, out: &Path) -> Result<(), Error> {
    println!(
        "seeds {} to {}: grids of 2 to 8 voxels a side (noise, constant blocks, sheets of one voxel, waves), f32 and u8, trilinear and nearest; \
         orthographic and perspective, a quarter from inside; pictures of {SIDE}x{SIDE} pixels",
        seeds.start, seeds.end
    );
    // Several scenes at once: a picture of a few pixels is over before a second thread has begun.
    let share = |job: u64| seeds.clone().filter(move |seed| seed % JOBS == job);
    let tallies = std::thread::scope(|scope| {
        let jobs: Vec<_> =
            (0..JOBS).map(|job| scope.spawn(move || survey(share(job), out).map_err(|e| e.to_string()))).collect();
        let mut all = Tallies::new();
        for job in jobs {
            for (look, own) in job.join().expect("no job panics")? {
                let sums = all.entry(look).or_default();
                sums.iter_mut().zip(&own).for_each(|(sum, own)| sum.join(own));
            }
        }
        Ok::<_, Error>(all)
    })?;
    println!("\n| transfer function | bound | {} |", Tally::HEADING);
    for (look, own) in &tallies {
        for (tally, bound) in own.iter().zip(BOUNDS) {
            println!("| {} | {bound} | {} |", look.name(), tally.row());
        }
    }
    println!("\nPictures, in percent, by their largest error in tenths of the bound; the last column is beyond it");
    for (i, bound) in BOUNDS.into_iter().enumerate() {
        let mut all = Tally::default();
        tallies.values().for_each(|own| all.join(&own[i]));
        println!("| all | {bound} | {} |", all.row());
        println!("| {bound} | {} |", all.distribution());
    }
    Ok(())
}

/// Draws the scenes of some seeds under each bound.
fn survey(seeds: impl Iterator<Item = u64>, out: &Path) -> Result<Tallies, Error> {
    let control = Control::default().with_threads(1);
    let strategy = scenes();
    let mut tallies = Tallies::new();
    for seed in seeds {
        let config = Config {
            rng_algorithm: RngAlgorithm::ChaCha,
            rng_seed: RngSeed::Fixed(seed),
            failure_persistence: None,
            ..Config::default()
        };
        let mut tree = strategy.new_tree(&mut TestRunner::new(config)).map_err(|e| e.message().to_owned())?;
        let (look, test) = tree.current();
        let solved = solve(&test, &control)?;
        let mut broken = None;
        for (tally, bound) in tallies.entry(look).or_default().iter_mut().zip(BOUNDS) {
            let judged = solved.judge(bound, &test.scene, &test.view, &control)?;
            if let Some(judged) = judged.filter(|judged| judged.breaks_its_promise()) {
                broken = Some(format!("max-error {bound}: {judged:?}"));
            }
            tally.add(judged);
        }
        let Some(reason) = broken else { continue };
        println!("seed {seed}, {}: {reason}", look.name());
        let mut smallest = test;
        for _ in 0..SHRINK_STEPS {
            let smaller = tree.current().1;
            let goes_on = if breaks(&smaller, &control)? {
                smallest = smaller;
                tree.simplify()
            } else {
                tree.complicate()
            };
            if !goes_on {
                break;
            }
        }
        std::fs::create_dir_all(out)?;
        let path = out.join(format!("scene-{seed}.toml"));
        std::fs::write(&path, format!("# seed {seed}: {reason}\n{}\n", smallest.scene_file()?))?;
        println!("  the smallest like it is {}", path.display());
    }
    Ok(tallies)
}
