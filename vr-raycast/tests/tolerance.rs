//! The promise of [`Step::Tolerance`]: no component of a pixel is further from the truth than asked for.

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, RngSeed, TestRunner};
use vr_core::*;
use vr_physics::check::{TestScene, strategies};
use vr_physics::{Certainty, Reference, cases};
use vr_raycast::{RayCaster, Step};

const ERRORS: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5];

fn promising(error: f64) -> RayCaster {
    RayCaster { step: Step::Tolerance(error), ..RayCaster::default() }
}

/// How a picture compares with the truth.
#[derive(Debug)]
struct Judged {
    /// The largest error, relative to max(1, largest magnitude), of pixels of which the truth is known to a tenth of what is asked for.
    worst: f64,
    /// Pixels further off than asked for.
    beyond: u64,
    /// Pixels of which nobody knows the truth that well.
    unknown: u64,
    counts: Counts,
}

/// `None` if the caster says that it has no bound for such scenes.
fn judge(caster: &RayCaster, scene: &Scene, view: &View, error: f64) -> Option<Judged> {
    let control = Control::default();
    let rendered = match caster.prepare(scene, &control) {
        Err(RenderError::Unsupported { .. }) => return None,
        prepared => prepared.unwrap().render(view, &control).unwrap(),
    };
    let truth = Reference::new(0.02 * error).solve(scene, view, &Model::Canonical, &control).unwrap();
    let peak = truth.pixels.iter().flat_map(|p| p.rgba).fold(1.0, |m: f64, x| m.max(x.abs()));
    let mut judged = Judged { worst: 0.0, beyond: 0, unknown: 0, counts: rendered.stats.counts };
    for (got, want) in rendered.frame.pixels().iter().zip(&truth.pixels) {
        let Certainty::Bound(uncertain) = want.certainty else { panic!("the reference has a bound") };
        if uncertain > 0.1 * error * peak {
            judged.unknown += 1;
            continue;
        }
        let off = (0..4).map(|c| (f64::from(got[c]) - want.rgba[c]).abs()).fold(0.0, f64::max) / peak;
        assert!(off.is_finite(), "{got:?}");
        // What the truth may be off by is nobody's fault.
        if off > error + uncertain / peak {
            judged.beyond += 1;
        } else {
            judged.worst = judged.worst.max(off);
        }
    }
    Some(judged)
}

fn scenes(seed: u64, count: usize, strategy: impl Strategy<Value = TestScene>) -> Vec<TestScene> {
    let rng_seed = RngSeed::Fixed(seed);
    let config =
        Config { rng_algorithm: RngAlgorithm::ChaCha, rng_seed, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new(config);
    (0..count).map(|_| strategy.new_tree(&mut runner).unwrap().current()).collect()
}

/// Any scene of those that there are bounds for.
fn bounded(test: TestScene, pick: usize) -> TestScene {
    let filter = if pick.is_multiple_of(4) { Filter::Nearest } else { Filter::Trilinear };
    let compositing = match test.scene.compositing {
        accumulate @ Compositing::Accumulate { .. } => accumulate,
        _ => Compositing::Over,
    };
    TestScene { scene: Scene { filter, compositing, shading: None, ..test.scene }, ..test }
}

#[test]
fn random_scenes() {
    let wild = scenes(11, 150, strategies::scene()).into_iter().enumerate().map(|(i, t)| bounded(t, i));
    let tame = scenes(12, 60, strategies::tame_scene()).into_iter().enumerate().map(|(i, t)| bounded(t, 4 * i + 1));
    let (mut pixels, mut unbounded, mut drawn, mut ratio) = (0, 0, 0, [0.0f64; 5]);
    for test in wild.chain(tame) {
        for (i, error) in ERRORS.into_iter().enumerate() {
            let Some(j) = judge(&promising(error), &test.scene, &test.view, error) else { continue };
            assert!(j.beyond <= j.counts.unbounded, "{error:e}: {j:?}\n{test:?}");
            drawn += 1;
            pixels += j.counts.rays;
            unbounded += j.counts.unbounded;
            ratio[i] = ratio[i].max(j.worst / error);
        }
    }
    println!("{drawn} pictures, {pixels} rays, {unbounded} unbounded, worst error by promise {ratio:.2?}");
}

#[test]
fn hard_cases() {
    for case in cases::all() {
        for error in ERRORS {
            match judge(&promising(error), &case.scene, &case.view, error) {
                None => println!("{:<18} {error:e} unsupported", case.name),
                Some(j) => {
                    println!(
                        "{:<18} {error:e} worst {:.1e} beyond {} unknown {} unbounded {} repeated {} of {} rays, {} steps a ray",
                        case.name,
                        j.worst,
                        j.beyond,
                        j.unknown,
                        j.counts.unbounded,
                        j.counts.repeated,
                        j.counts.rays,
                        j.counts.samples / j.counts.rays.max(1)
                    );
                    assert!(j.beyond <= j.counts.unbounded, "{}: {j:?}", case.name);
                }
            }
        }
    }
}
