//! The bound of [`Step::ErrorBound`]: no component of a pixel is further from the truth than asked for.

use crate::common;

use std::sync::Arc;

use crate::common::{down, homogeneous, oblique, random, transfer, volume};
use glam::DVec3;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, RngSeed, TestRunner};
use vr_core::*;
use vr_physics::check::FixedLayer;
use vr_physics::check::strategies::Kind;
use vr_physics::check::{TestScene, strategies};
use vr_physics::{Certainty, Reference, cases};
use vr_raycast::{CompositingOrder, Precision, RayCaster, Rule, Step, Traversal, Vector};

const ERRORS: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5];

fn promising(error: f64) -> RayCaster {
    RayCaster { step: Step::ErrorBound(error), ..RayCaster::default() }
}

/// Comparison of a picture with the correct one.
#[derive(Debug)]
struct Judged {
    /// The largest error, relative to max(1, largest magnitude), of pixels of which the truth is known to a tenth of what is asked for.
    worst: f64,
    /// Pixels further off than asked for.
    beyond: u64,
    /// Pixels whose correct value is not known that well.
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
        // The uncertainty of the reference does not count against the caster.
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

/// Any scene of those that there are bounds for, without shading.
fn bounded(test: TestScene, pick: usize) -> TestScene {
    let filter = if pick.is_multiple_of(4) { Filter::Nearest } else { Filter::Trilinear };
    let compositing = match test.scene.compositing {
        accumulate @ Compositing::Accumulate { .. } => accumulate,
        _ => Compositing::Over,
    };
    let scene = Scene { compositing, shading: None, ..test.scene.with_filter(filter) };
    TestScene { scene, ..test }
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
    // Hardly any random ray touches a wall within the last bits.
    assert!(drawn > 900 && unbounded <= 2, "{unbounded} unbounded of {pixels} in {drawn} pictures");
}

/// Light that is reflected: by any filter that there is a bound for, both sources of normals, any lights, blunt and sharp highlights.
#[test]
fn random_shaded_scenes() {
    let wild = scenes(13, 60, strategies::scene()).into_iter().enumerate();
    let tame = scenes(14, 40, strategies::tame_scene()).into_iter().map(|test| (1, test));
    let (mut pixels, mut unbounded, mut drawn, mut ratio) = (0, 0, 0, [0.0f64; 5]);
    for (i, test) in wild.chain(tame) {
        let shaded = |gradient: GradientMethod| {
            let own = test
                .scene
                .shading
                .as_deref()
                .cloned()
                .unwrap_or_else(|| Shading { power: [0.5, 1.0, 2.5, 20.0, 150.0][i % 5], ..Shading::default() });
            let shading = Arc::new(Shading { gradient, gradient_opacity: Vec::new(), ..own });
            let TestScene { scene, view, .. } = bounded(test.clone(), i);
            (Scene { shading: Some(shading), ..scene }, view)
        };
        let (scene, view) =
            shaded(if i % 3 == 0 { GradientMethod::Analytic } else { GradientMethod::CentralDifferences });
        for (i, error) in ERRORS.into_iter().enumerate() {
            let Some(j) = judge(&promising(error), &scene, &view, error) else { continue };
            assert!(j.beyond <= j.counts.unbounded, "{error:e}: {j:?}\n{scene:?}\n{view:?}");
            drawn += 1;
            pixels += j.counts.rays;
            unbounded += j.counts.unbounded.saturating_sub(j.unknown);
            ratio[i] = ratio[i].max(j.worst / error);
        }
    }
    println!("{drawn} pictures, {pixels} rays, {unbounded} unbounded, worst error by promise {ratio:.2?}");
    // Rays in a face between two gradients of the filter have no certain normal for the reference either.
    assert!(drawn > 400 && unbounded == 0, "{unbounded} unbounded of {pixels} in {drawn} pictures");
}

/// Sums over the pictures of random scenes, under three bounds.
#[derive(Debug, Default)]
struct Tally {
    drawn: u64,
    rays: u64,
    unbounded: u64,
    unknown: u64,
    /// Largest error under each bound, in units of it.
    worst: [f64; 3],
}

impl Tally {
    /// Draws a scene under three bounds.
    fn add(&mut self, errors: [f64; 3], scene: &Scene, view: &View) {
        for (worst, error) in self.worst.iter_mut().zip(errors) {
            let Some(j) = judge(&promising(error), scene, view, error) else { continue };
            assert!(j.beyond <= j.counts.unbounded, "{error:e}: {j:?}\n{scene:?}\n{view:?}");
            self.drawn += 1;
            self.rays += j.counts.rays;
            self.unbounded += j.counts.unbounded;
            self.unknown += j.unknown;
            *worst = worst.max(j.worst / error);
        }
    }

    /// Checks that enough was drawn, and that hardly any ray was without a bound where the reference is certain.
    fn check(&self, name: &str, least: u64) {
        println!("{name}: {self:.2?}");
        assert!(self.drawn >= least && self.unbounded <= self.unknown + 1 + self.rays / 500, "{name}: {self:?}");
    }
}

/// Light that is gathered, whatever a scene asks for.
fn gathered(compositing: Compositing) -> Compositing {
    match compositing {
        accumulate @ Compositing::Accumulate { .. } => accumulate,
        _ => Compositing::Over,
    }
}

/// Filters of four taps per axis: lit by gradients of either kind or not, and picked.
#[test]
fn random_scenes_of_wider_filters() {
    let wild = scenes(18, 60, strategies::scene()).into_iter().enumerate();
    let tame = scenes(19, 40, strategies::tame_scene()).into_iter().enumerate();
    let mut tally = Tally::default();
    for (i, TestScene { scene, view, .. }) in wild.chain(tame) {
        let gradient = [GradientMethod::CentralDifferences, GradientMethod::Analytic][i / 3 % 2];
        let shading = Shading { gradient, power: 12.0, ..Shading::default() };
        let picked = [Compositing::Maximum, Compositing::Minimum, Compositing::Average][i % 3];
        let compositing = if i / 6 % 4 == 3 { picked } else { gathered(scene.compositing) };
        let shading = (i % 2 == 0 && compositing.integrates_light()).then(|| Arc::new(shading));
        let filter = [Filter::BSpline, Filter::CatmullRom, Filter::Gaussian][i % 3];
        let scene = Scene { compositing, shading, ..scene.with_filter(filter) };
        tally.add([1e-2, 1e-3, 1e-5], &scene, &view);
    }
    tally.check("wider filters", 250);
}

/// Opacity that follows the gradient: by factors that rise, fall and are 0, lit or not, under every filter.
#[test]
fn random_scenes_by_gradient() {
    let wild = scenes(20, 60, strategies::scene()).into_iter().enumerate();
    let tame = scenes(21, 60, strategies::tame_scene()).into_iter().enumerate();
    let mut next = random(22);
    let mut tally = Tally::default();
    for (i, TestScene { scene, view, .. }) in wild.chain(tame) {
        let Volume::Grid(grid) = &scene.volume else { panic!("the strategies draw grids") };
        let (low, high) = grid.value_stats().range.unwrap_or_default();
        // As steep as some of the field is.
        let steepest =
            f64::from(high - low).max(1.0) * grid.calibration().slope.abs() / grid.placement().spacing().min_element();
        let mut magnitude = 0.0;
        let factors = (0..1 + i % 4).map(|k| {
            magnitude += (0.01 + next()) * steepest * 0.5;
            (if k == 0 && i % 2 == 0 { 0.0 } else { magnitude }, if next() < 0.3 { 0.0 } else { 1.5 * next() })
        });
        let gradient_opacity: Vec<(f64, f64)> = factors.collect();
        let gradient = [GradientMethod::CentralDifferences, GradientMethod::Analytic][i / 2 % 2];
        let own = if i % 3 == 0 { Shading::flat() } else { Shading { power: 9.0, ..Shading::default() } };
        let shading = Some(Arc::new(Shading { gradient, gradient_opacity, ..own }));
        let compositing = gathered(scene.compositing);
        let filter =
            [Filter::Trilinear, Filter::Nearest, Filter::Trilinear, Filter::CatmullRom, Filter::BSpline][i % 5];
        let scene = Scene { compositing, shading, ..scene.with_filter(filter) };
        tally.add([1e-2, 1e-3, 1e-4], &scene, &view);
    }
    tally.check("opacity by the gradient", 300);
}

/// A medium that is opaque but where the gradient is 0, which it is up to the middle: a wall begins where the gradient does, and no ray looks for that place for ever.
#[test]
fn walls_where_the_gradient_begins() {
    let slope = |_: f64, _: f64, z: f64| 0.1 * (z - 4.0).max(0.0);
    for (filter, gradient) in [
        (Filter::Trilinear, GradientMethod::CentralDifferences),
        (Filter::Nearest, GradientMethod::CentralDifferences),
        (Filter::CatmullRom, GradientMethod::Analytic),
    ] {
        let opaque = transfer(&[(0.0, [0.9, 0.2, 0.4], 1.0)], 1.0);
        let shading = Shading { gradient, gradient_opacity: vec![(0.0, 0.0), (1.0, 1.0)], ..Shading::flat() };
        let scene = Scene { shading: Some(Arc::new(shading)), ..Scene::new(volume([9; 3], slope), opaque) };
        let scene = scene.with_filter(filter);
        let view = oblique(&scene, 12);
        for error in [1e-2, 1e-4] {
            let j = judge(&promising(error), &scene, &view, error).unwrap();
            assert!(j.beyond <= j.counts.unbounded && j.counts.rays > 50, "{filter} {error:e}: {j:?}");
            assert!(j.counts.unbounded <= j.unknown, "{filter} {error:e}: {j:?}");
            assert!(j.counts.samples < 3000 * j.counts.rays, "{filter} {error:e}: {j:?}");
        }
    }
}

/// Transfer functions with rows by the gradient.
#[test]
fn random_scenes_of_rows() {
    let mut tally = Tally::default();
    for TestScene { scene, view, .. } in scenes(27, 150, strategies::gradient_row_scene()) {
        tally.add([1e-2, 1e-3, 1e-4], &scene, &view);
    }
    tally.check("rows", 400);
}

/// Volumes that are no grids, by the polynomials that they give along a ray: every operator, jumps, walls, shading, opacity by the gradient.
#[test]
fn random_scenes_of_other_volumes() {
    let kinds = Kind::OF_OTHER_VOLUMES.map(|kind| (kind.name(), scenes(23, 60, kind.scenes())));
    let points = [
        ("points", scenes(24, 40, strategies::point_scene())),
        ("shaded points", scenes(25, 25, strategies::shaded_point_scene())),
        ("means and colours of points", scenes(26, 40, strategies::tame_mixed_point_scene())),
    ];
    for (name, tests) in kinds.into_iter().chain(points) {
        let mut tally = Tally::default();
        for TestScene { scene, view, .. } in tests {
            tally.add([1e-2, 1e-3, 1e-4], &scene, &view);
        }
        tally.check(name, 20);
    }
}

/// Voxels with colours of their own: every operator, jumps, walls, missing voxels, labels, shading, opacity by the gradient, emission, every filter.
#[test]
fn random_scenes_of_colored_voxels() {
    let mut tally = Tally::default();
    for TestScene { scene, view, .. } in scenes(28, 350, strategies::colored_grid_scene()) {
        tally.add([1e-2, 1e-3, 1e-5], &scene, &view);
    }
    tally.check("coloured voxels", 1000);
}

/// Emissions up to a level of opacity: light does not go with opacity, so that the place of the cut matters.
#[test]
fn random_scenes_of_cut_emission() {
    let mut tally = Tally::default();
    let mut next = random(31);
    for TestScene { scene, view, .. } in scenes(30, 150, Kind::Emission.scenes()) {
        let scene = Scene { compositing: Compositing::Accumulate { level: 0.02 + 0.9 * next() }, ..scene };
        tally.add([1e-2, 1e-3, 1e-5], &scene, &view);
    }
    tally.check("emission up to a level", 450);
}

/// Light that is reflected where the field is flat but for a few samples, as scans in bytes are: gradients go to 0 on the way into most cells.
#[test]
fn shaded_flat_fields() {
    let mut next = random(16);
    let (mut rays, mut steps, mut worst) = (0, 0, [0.0f64; 3]);
    for i in 0..40 {
        let share = 0.05 + 0.3 * next();
        let samples: Vec<f64> =
            (0..7 * 6 * 5).map(|_| if next() < share { (1.0 + 3.0 * next()).floor() } else { 0.0 }).collect();
        let volume = volume([7, 6, 5], |x, y, z| samples[(x + 7.0 * (y + 6.0 * z)) as usize]);
        let look = transfer(&[(0.0, [0.9, 0.5, 0.2], 0.1), (1.0, [0.2, 0.9, 0.4], 0.5), (3.0, [1.0; 3], 0.2)], 1.0);
        let gradient = [GradientMethod::CentralDifferences, GradientMethod::Analytic][i % 2];
        let shading = Shading { gradient, power: [1.0, 12.0, 80.0][i % 3], ..Shading::default() };
        let scene = Scene { shading: Some(Arc::new(shading)), ..Scene::new(volume, look) };
        let fov = (i % 4 == 0).then_some(40.0);
        let camera = Camera::framing(scene.bounds(), 360.0 * next(), 160.0 * next() - 80.0, fov);
        let view = View::new(camera, [7, 7]);
        for (k, error) in [1e-2, 1e-3, 1e-4].into_iter().enumerate() {
            let j = judge(&promising(error), &scene, &view, error).unwrap();
            assert_eq!((j.beyond, j.counts.unbounded), (0, 0), "{i}, {error:e}: {j:?}");
            worst[k] = worst[k].max(j.worst / error);
            (rays, steps) = (rays + j.counts.rays, steps + j.counts.samples);
        }
    }
    println!("{} steps a ray, worst error by promise {worst:.2?}", steps / rays);
    // Where a gradient's direction near 0 was left unknown, it took 1100.
    assert!(worst[0] > 0.01 && steps < 400 * rays, "{steps} steps of {rays} rays");
}

/// Values that are picked: known to rounding, so that every promise is kept unless the value is at a jump.
#[test]
fn random_picks() {
    let (mut drawn, mut unbounded, mut unknown, mut worst) = (0, 0, 0, 0.0f64);
    for (i, test) in scenes(15, 120, strategies::scene()).into_iter().enumerate() {
        let compositing = [Compositing::Maximum, Compositing::Minimum, Compositing::Average][i % 3];
        let TestScene { scene, view, .. } = bounded(test, i);
        let scene = Scene { compositing, ..scene };
        for error in [1e-2, 1e-5] {
            let Some(j) = judge(&promising(error), &scene, &view, error) else { continue };
            assert!(j.beyond <= j.counts.unbounded, "{error:e}: {j:?}\n{scene:?}\n{view:?}");
            drawn += 1;
            (unbounded, unknown) = (unbounded + j.counts.unbounded, unknown + j.unknown);
            worst = worst.max(j.worst);
        }
    }
    println!("{drawn} pictures, {unbounded} unbounded, {unknown} unknown, worst error {worst:.1e}");
    assert!(drawn > 200 && unbounded <= unknown && worst < 1e-6, "{drawn} {unbounded} {unknown} {worst:e}");
}

/// The first place where a value is reached, lit or not: known to rounding, but where the field only touches it.
#[test]
fn random_first_places() {
    let (mut drawn, mut rays, mut unbounded, mut unknown, mut worst) = (0, 0, 0, 0, [0.0f64; 2]);
    for (i, test) in scenes(17, 160, strategies::scene()).into_iter().enumerate() {
        let shading = test.scene.shading.as_deref().cloned().unwrap_or_default();
        let gradient = [GradientMethod::CentralDifferences, GradientMethod::Analytic][i / 2 % 2];
        let shading = Shading { gradient, gradient_opacity: Vec::new(), ..shading };
        let TestScene { scene, view, .. } = bounded(test, i);
        let Volume::Grid(grid) = &scene.volume else { panic!("the strategies draw grids") };
        let (low, high) = grid.value_stats().range.unwrap_or_default();
        let share = [0.5, 0.1, 0.9, 0.0, 0.33][i % 5];
        let threshold = grid.calibration().value(f64::from(low) + share * (f64::from(high) - f64::from(low)));
        let shading = (i % 2 == 1).then(|| Arc::new(shading));
        let scene = Scene { compositing: Compositing::First { threshold }, shading, ..scene };
        for (k, error) in [1e-2, 1e-5].into_iter().enumerate() {
            let Some(j) = judge(&promising(error), &scene, &view, error) else { continue };
            assert!(j.beyond <= j.counts.unbounded, "{error:e}: {j:?}\n{scene:?}\n{view:?}");
            drawn += 1;
            (rays, unbounded, unknown) = (rays + j.counts.rays, unbounded + j.counts.unbounded, unknown + j.unknown);
            worst[k] = worst[k].max(j.worst);
        }
    }
    println!("{drawn} pictures, {rays} rays, {unbounded} unbounded, {unknown} unknown, worst error {worst:?}");
    assert!(
        drawn > 200 && unbounded <= unknown + rays / 500 && worst[1] < 1e-5,
        "{drawn} {rays} {unbounded} {unknown} {worst:?}"
    );
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
                    assert_eq!((j.beyond, j.unknown, j.counts.unbounded), (0, 0, 0), "{} {error:e}: {j:?}", case.name);
                }
            }
        }
    }
}

/// A layer behind the volume is dimmed by it, and may be brighter than anything in it.
#[test]
fn layers_and_clips() {
    let scene = Scene::new(
        volume([9; 3], |x, y, z| 0.5 + 0.4 * (0.7 * x + 0.3 * y).sin() * (0.5 * z).cos()),
        transfer(&[(0.1, [0.1, 0.9, 0.4], 0.05), (0.5, [0.9, 0.2, 0.1], 0.6), (0.9, [0.0, 0.5, 1.0], 0.2)], 2.0),
    );
    let mut view = oblique(&scene, 12);
    let depth = |i: u32| if i.is_multiple_of(5) { f32::INFINITY } else { 16.0 + (i % 12) as f32 };
    let scene = FixedLayer::new(&view, |i| ([3.0, 0.5, 0.1], depth(i))).among(&scene);
    view.clip.planes.push(Plane { normal: DVec3::new(1.0, 0.4, 0.2), offset: 4.3 });
    for error in ERRORS {
        let j = judge(&promising(error), &scene, &view, error).unwrap();
        assert_eq!((j.beyond, j.unknown, j.counts.unbounded), (0, 0, 0), "{error:e}: {j:?}");
    }
}

/// Labels with walls among them: the field reaches a wall's value exactly at the samples, so that walls begin at faces of cells.
#[test]
fn labels() {
    let dims = [13; 3];
    let label = |x: usize, y: usize, z: usize| (((x / 3) * 7 + (y / 4) * 3 + (z / 3) * 5) % 5) as u8;
    let samples: Vec<u8> = (0..13 * 13 * 13).map(|i| label(i % 13, i / 13 % 13, i / 169)).collect();
    let placement = Placement::from_spacing([1.0, 0.8, 1.3]).unwrap();
    let grid = UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap();
    let points = [
        (1.0, [0.0; 3], 0.0),
        (1.0, [0.2, 0.9, 0.3], 0.1),
        (2.0, [0.2, 0.9, 0.3], 0.1),
        (2.0, [0.9, 0.3, 0.3], 0.4),
        (4.0, [0.9, 0.3, 0.3], 0.4),
        (4.0, [0.3, 0.3, 0.9], 1.0),
    ];
    for filter in [Filter::Nearest, Filter::Trilinear] {
        let scene = Scene::new(grid.clone().into(), transfer(&points, 1.0)).with_filter(filter);
        let view = oblique(&scene, 24);
        for error in ERRORS {
            let j = judge(&promising(error), &scene, &view, error).unwrap();
            // The samples at the far faces of the box are a layer of their own: where they are 4, a ray touches a wall for no length.
            assert!(j.beyond == 0 && j.counts.unbounded <= j.unknown && j.unknown < 4, "{filter} {error:e}: {j:?}");
            assert!(filter == Filter::Trilinear || j.unknown == 0);
        }
    }
}

/// A field that only touches the value of a wall, at its largest samples, does not enter it. The caster proves that unless calibration
/// rounds; then it counts the rays as unbounded, and no others.
#[test]
fn what_has_no_bound_is_counted() {
    let points = [(0.0, [1.0, 0.5, 0.2], 0.1), (1.0, [1.0, 0.5, 0.2], 0.2), (1.0, [0.0, 1.0, 0.0], 1.0)];
    let scene = |slope: f64| {
        let layer = |z: f64| 1.0 - (z - 4.0).abs() / 8.0 - if z > 4.0 { 0.1 } else { 0.0 };
        let samples: Vec<f32> = (0..9 * 9 * 9).map(|i| (layer(f64::from(i / 81)) / slope) as f32).collect();
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid = UniformGrid::new([9; 3], samples, placement, Calibration { slope, intercept: 0.0 }).unwrap();
        Scene::new(grid.into(), transfer(&points, 1.0))
    };
    // Every ray crosses the plane in which the field is exactly 1.
    let view = oblique(&scene(1.0), 16);
    let known = judge(&promising(1e-3), &scene(1.0), &view, 1e-3).unwrap();
    assert_eq!((known.beyond, known.unknown, known.counts.unbounded), (0, 0, 0), "{known:?}");
    let render = |view: &View| common::render(&promising(1e-3), &scene(0.1), view);
    let through = render(&view);
    assert!(through.stats.counts.unbounded > 50, "{:?}", through.stats.counts);
    assert!(through.frame.pixels().iter().flatten().all(|x| x.is_finite()));
    // No ray does.
    let clip = Clip { planes: vec![Plane { normal: -DVec3::Z, offset: -3.999 }], ..Clip::default() };
    assert_eq!(render(&View { clip, ..view }).stats.counts.unbounded, 0);
}

#[test]
fn coarser_promises_take_fewer_steps() {
    let case = cases::by_name("marschner-lobb").unwrap();
    let steps = ERRORS.map(|e| common::render(&promising(e), &case.scene, &case.view).stats.counts);
    let double = |e| RayCaster { precision: Precision::F64, ..promising(e) };
    let steps_in_f64 = ERRORS.map(|e| common::render(&double(e), &case.scene, &case.view).stats.counts);
    assert!(steps_in_f64.windows(2).all(|w| w[0].samples < w[1].samples), "{steps_in_f64:?}");
    assert!(steps_in_f64.iter().all(|c| c.repeated == 0));
    assert!(steps[0].repeated == 0 && steps[4].repeated > 0, "{steps:?}");
}

#[test]
fn the_picture_does_not_depend_on_threads() {
    let case = cases::by_name("camera-inside").unwrap();
    let on = |threads| {
        let control = Control::default().with_threads(threads);
        promising(1e-5).prepare(&case.scene, &control).unwrap().render(&case.view, &control).unwrap().frame
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn what_asks_for_no_bound_is_refused() {
    let control = Control::default();
    let scene = Scene::new(volume([3; 3], |x, _, _| x / 2.0), homogeneous(0.1));
    // Below the floor.
    for error in [9e-7, 0.0, -1.0, f64::NAN, f64::INFINITY] {
        let Err(RenderError::Option(e)) = promising(error).prepare(&scene, &control) else { panic!("{error}") };
        let e = e.to_string();
        assert!(e.contains("max-error") && e.contains("1e-6"), "{e}");
    }
    assert!(promising(1e-6).prepare(&scene, &control).is_ok());
    // What the promise decides by itself.
    for caster in [
        RayCaster { rule: Rule::Left, ..promising(0.1) },
        RayCaster { traversal: Traversal::Cells, ..promising(0.1) },
        RayCaster { order: CompositingOrder::BackToFront, ..promising(0.1) },
        RayCaster { order: CompositingOrder::FrontToBack { termination: 0.5 }, ..promising(0.1) },
    ] {
        assert!(matches!(caster.prepare(&scene, &control), Err(RenderError::Option(_))), "{caster:?}");
    }
}

/// One ray, known in closed form: a slab behind a wall of missing samples.
#[test]
fn a_slab() {
    let field = |_: f64, _: f64, z: f64| if z > 6.0 { f64::NAN } else { 0.5 };
    let scene = Scene::new(volume([9; 3], field), homogeneous(0.1));
    let (got, _) = common::pixel(&promising(1e-6), &scene, &down(3.3, 4.4));
    common::assert_close(got, [1.0 - 0.9f64.powi(6); 4], 1e-6, "six of eight cells");
}

/// Packets draw what they have bounds for: nearly all rays of smooth media, and of a surface most.
#[test]
fn packets_draw_nearly_all_rays() {
    for (name, error, share) in [("fog", 4e-3, 0.01), ("fog", 1e-3, 0.01), ("blobs", 4e-3, 0.01), ("blobs", 1e-3, 0.05)]
    {
        let phantom = phantom::by_name(name).unwrap();
        let grid = phantom::sample::<u8>(&*phantom, [48; 3]).unwrap();
        let points = phantom.transfer_points();
        let transfer = TransferFunction::new(points, OpacityRule::Power, phantom::TRANSFER_UNIT_DISTANCE).unwrap();
        let scene = Scene::new(grid.into(), transfer);
        let view = View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, Some(30.0)), [48, 48]);
        let judged = judge(&promising(error), &scene, &view, error).unwrap();
        let counts = judged.counts;
        println!("{name} {error:e}: {} of {} rays repeated, worst {:.1e}", counts.repeated, counts.rays, judged.worst);
        assert_eq!((judged.beyond, counts.unbounded), (0, 0), "{judged:?}");
        assert!(counts.repeated as f64 <= share * counts.rays as f64, "{name} {error:e}: {counts:?}");
        // Each by itself: no packets, and the vectors of other machines.
        let plain = RayCaster { vector: Vector::Off, ..promising(error) };
        assert_eq!(common::render(&plain, &scene, &view).stats.counts.repeated, 0);
        let on = |vector| common::render(&RayCaster { vector, ..promising(error) }, &scene, &view).frame;
        assert!(on(Vector::Auto) == on(Vector::Baseline) && on(Vector::Auto) == on(Vector::Avx2), "{name} {error:e}");
    }
}
