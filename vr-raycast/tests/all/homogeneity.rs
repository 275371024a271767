//! Long steps where the medium is nearly the same: what they may cost, and what they save.

use crate::common::*;
use proptest::prelude::*;
use vr_core::phantom::{self, sample};
use vr_core::*;
use vr_physics::check::strategies;
use vr_raycast::{CompositingOrder, EmptySpace, RayCaster, Rule, Step, Traversal, Vector};

fn short(step: f64) -> RayCaster {
    // Leaping takes steps away, too: of what long steps gain, nothing is left to it.
    RayCaster { order: CompositingOrder::WHOLE_RAY, empty_space: EmptySpace::None, ..RayCaster::uniform(step) }
}

fn long(step: f64, error: f64) -> RayCaster {
    RayCaster { step: Step::Homogeneous { step, error }, empty_space: EmptySpace::Auto, ..short(step) }
}

/// Steps by variance.
fn by_means(step: f64, error: f64) -> RayCaster {
    RayCaster { step: Step::Variance { step, error }, ..long(step, error) }
}

/// Largest RMSE of a component.
fn rmse(got: &Frame, want: &Frame) -> f64 {
    let pairs = || got.pixels().iter().zip(want.pixels());
    let square = |c: usize| pairs().map(|(a, b)| f64::from(a[c] - b[c]).powi(2)).sum::<f64>();
    (0..4).map(|c| (square(c) / pairs().count() as f64).sqrt()).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    /// Long steps err by `error` at most; short ones by what the same steps everywhere err by, on either side of a long one (twice that);
    /// and rounding in f32. A cut by opacity moves by what opacity is off: light is off by thrice the error of the ray that is not cut. Means of
    /// nodes err by `error` in the root mean square over a picture of parallel rays.
    #[test]
    fn long_steps_keep_their_bound(
        test in strategies::scene(),
        exponent in -4.0f64..-0.5,
        level in prop::option::of(0.1f64..0.99),
        shaded in any::<bool>(),
        by_variance in any::<bool>(),
        backwards in any::<bool>(),
        vector in prop::sample::select(vec![Vector::Auto, Vector::Baseline, Vector::Off]),
    ) {
        let shading = test.scene.shading.clone().map(|s| Shading { gradient_opacity: Vec::new(), ..(*s).clone() }.into());
        let level = level.filter(|_| !test.scene.transfer.has_emission());
        let over = Scene { compositing: Compositing::Over, shading: shading.filter(|_| shaded), ..test.scene };
        let cut = |level| Scene { compositing: Compositing::Accumulate { level }, ..over.clone() };
        let scene = level.map_or(over.clone(), cut);
        let mut view = test.view;
        if by_variance {
            view.camera = Camera::framing(scene.volume.bounds(), 33.0 + 100.0 * exponent, 21.0, None);
        }
        // Samples (and a B-spline's coefficients) are f32: a ramp narrower than their rounding is met by chance, and differently by each step.
        let widths = scene.transfer.points().windows(2).map(|w| (w[1].value - w[0].value, w[0].value.abs().max(w[1].value.abs())));
        prop_assume!(widths.into_iter().all(|(width, value)| width == 0.0 || width > 1e-5 * value));
        // So is a jump that all of the field lies on.
        let (low, high) = scene.volume.value_range().unwrap_or_default();
        let off = |value: f64| (low - value).abs().max((high - value).abs());
        let jumps = scene.transfer.segments().windows(2).filter(|w| w[0].end != w[1].start).map(|w| w[1].from);
        prop_assume!(jumps.into_iter().all(|jump| off(jump) > 1e-5 * jump.abs()));
        let (step, error) = (1.0 / 16.0, 10f64.powf(exponent));
        let want = truth(&scene, &view);
        let whole = level.map(|_| truth(&over, &view));
        // Of several lengths: one alone may happen to have a sample on the better side of every jump.
        let lengths = [1.0, 0.93, 0.86, 0.79, 0.71].map(|part| part * step);
        let errors = lengths.map(|step| {
            let error = max_error(&render(&short(step), &scene, &view).frame, &want);
            whole.as_ref().map_or(error, |whole| {
                error.max(3.0 * max_error(&render(&short(step), &over, &view).frame, whole))
            })
        });
        let uniform = errors.into_iter().fold(0.0, f64::max);
        let order = if backwards && level.is_none() { CompositingOrder::BackToFront } else { CompositingOrder::WHOLE_RAY };
        let found = if by_variance {
            rmse(&render(&RayCaster { order, vector, ..by_means(step, error) }, &scene, &view).frame, &want)
        } else {
            max_error(&render(&RayCaster { order, vector, ..long(step, error) }, &scene, &view).frame, &want)
        };
        // A jump of the medium within a short step, or a wall, moves with the steps.
        prop_assume!(uniform < 0.02);
        prop_assert!(found <= error + 2.0 * uniform + 1e-4, "{found} > {error} + 2·{uniform}");
    }
}

#[test]
fn a_homogeneous_volume_is_one_step() {
    let scene = Scene::new(volume([33; 3], |_, _, _| 0.5), homogeneous(0.01));
    let view = oblique(&scene, 16);
    let picture = render(&long(0.2, 1e-3), &scene, &view);
    assert_eq!(picture.stats.counts.samples, picture.stats.counts.rays);
    assert!(max_error(&picture.frame, &truth(&scene, &view)) < 1e-6);
}

#[test]
fn vacuum_is_not_averaged_away() {
    // One missing sample: eight cells of vacuum in the middle of a constant field.
    let scene = Scene::new(
        volume([33; 3], |x, y, z| if (x, y, z) == (16.0, 16.0, 16.0) { f64::NAN } else { 0.5 }),
        homogeneous(0.02),
    );
    let view = down(15.3, 16.4);
    let (got, _) = pixel(&long(0.01, 1e-1), &scene, &view);
    let tau = -(30.0 * 0.98f64.ln());
    let want = 1.0 - (-tau).exp();
    assert_close(got, [want; 4], 1e-4, "30 of 32 cells");
}

#[test]
fn phantoms_within_their_bound_in_fewer_steps() {
    for (name, size, gain_of_coarse, gain_of_fine) in
        [("fog", 128, 3.0, 1.0), ("blobs", 64, 4.0, 4.0), ("shells", 64, 1.5, 1.5)]
    {
        let phantom = phantom::by_name(name).unwrap();
        let grid = sample::<u8>(&*phantom, [size; 3]).unwrap();
        let points = phantom.transfer_points();
        let transfer = TransferFunction::new(points, OpacityRule::Power, phantom::TRANSFER_UNIT_DISTANCE).unwrap();
        let scene = Scene::new(grid.into(), transfer);
        let view = oblique(&scene, 24);
        let want = truth(&scene, &view);
        let plain = render(&short(0.5), &scene, &view);
        let own = max_error(&plain.frame, &want);
        for (error, least_gain) in [(0.5, gain_of_coarse), (0.05, gain_of_fine), (0.005, gain_of_fine)] {
            let picture = render(&long(0.5, error), &scene, &view);
            let found = max_error(&picture.frame, &want);
            let gain = plain.stats.counts.samples as f64 / picture.stats.counts.samples as f64;
            println!(
                "{name} homogeneity {error}: error {found:.1e} (all short: {own:.1e}), {gain:.1} times fewer steps"
            );
            assert!(found <= error + 2.0 * own + 1e-4, "{name} {error}: {found}");
            assert!(gain >= least_gain, "{name} {error}: {gain}");
        }
    }
}

/// From either end the same steps are taken, and the same sum is rounded otherwise. By the plain engine: packets, from the front alone, round places where
/// steps end.
#[test]
fn from_the_back_the_steps_are_the_same() {
    let phantom = phantom::by_name("blobs").unwrap();
    let grid = sample::<u8>(&*phantom, [48; 3]).unwrap();
    let points = phantom.transfer_points();
    let transfer = TransferFunction::new(points, OpacityRule::Power, phantom::TRANSFER_UNIT_DISTANCE).unwrap();
    let scene = Scene::new(grid.into(), transfer);
    let view = oblique(&scene, 24);
    for caster in [long(0.5, 0.05), by_means(0.5, 0.05)] {
        let caster = RayCaster { vector: Vector::Off, ..caster };
        let front = render(&caster, &scene, &view);
        let back = render(&RayCaster { order: CompositingOrder::BackToFront, ..caster }, &scene, &view);
        assert_eq!(front.stats.counts.samples, back.stats.counts.samples);
        // Runs of 32 steps are summed in f32.
        assert!(max_error(&back.frame, &front.frame) <= 1e-6);
    }
}

/// White noise about a constant: ranges see the outliers, the variance what they amount to. The whole volume is one node then.
fn noise(x: f64, y: f64, z: f64) -> f64 {
    let mut h = (x as u64 * 73_856_093) ^ (y as u64 * 19_349_663) ^ (z as u64 * 83_492_791);
    h = (h ^ h >> 13).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    0.5 + 0.1 * ((h >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
}

#[test]
fn noise_is_crossed_at_its_mean_within_the_rmse() {
    let scene =
        Scene::new(volume([33; 3], noise), transfer(&[(0.0, [0.2, 0.9, 0.4], 0.0), (1.0, [0.4, 0.9, 0.2], 0.01)], 1.0));
    let view = oblique(&scene, 24);
    let want = truth(&scene, &view);
    let ranges = render(&long(0.5, 0.1), &scene, &view);
    for (error, least_gain) in [(0.1, 8.0), (0.01, 1.0)] {
        let means = render(&by_means(0.5, error), &scene, &view);
        let gain = ranges.stats.counts.samples as f64 / means.stats.counts.samples as f64;
        let found = rmse(&means.frame, &want);
        println!("noise, rms {error}: RMSE {found:.1e}, {gain:.1} times fewer steps than by ranges at 0.1");
        assert!(found <= error, "{found}");
        assert!(gain >= least_gain, "{gain}");
    }
}

/// Jumps of the transfer function have no slope: a node that they cut is crossed by its range alone, and a thin wall in a wide constant stays.
#[test]
fn a_jump_is_not_averaged_away() {
    let field = |x: f64, _: f64, _: f64| if x == 16.0 { 1.0 } else { 0.1 };
    let steps = [(0.0, [1.0; 3], 0.0), (0.5, [1.0; 3], 0.0), (0.5, [1.0; 3], 0.6), (1.0, [1.0; 3], 0.6)];
    let scene = Scene::new(volume([33; 3], field), transfer(&steps, 1.0));
    for (caster, name) in [(long(1.0 / 32.0, 0.05), "ranges"), (by_means(1.0 / 32.0, 0.05), "variance")] {
        let view = oblique(&scene, 16);
        let found = max_error(&render(&caster, &scene, &view).frame, &truth(&scene, &view));
        assert!(found <= 0.05 + 0.03, "{name}: {found}");
    }
}

#[test]
fn shaded_and_cut_pictures_within_their_bound() {
    let phantom = phantom::by_name("blobs").unwrap();
    let grid = sample::<u8>(&*phantom, [64; 3]).unwrap();
    let points = phantom.transfer_points();
    let transfer = TransferFunction::new(points, OpacityRule::Power, phantom::TRANSFER_UNIT_DISTANCE).unwrap();
    let plain = Scene { shading: Some(Default::default()), ..Scene::new(grid.into(), transfer) };
    for compositing in [Compositing::Over, Compositing::Accumulate { level: 0.6 }] {
        let scene = Scene { compositing, ..plain.clone() };
        let view = oblique(&scene, 24);
        let want = truth(&scene, &view);
        let short = render(&short(0.25), &scene, &view);
        let own = max_error(&short.frame, &want);
        for (error, caster) in [0.2, 0.02].into_iter().flat_map(|e| [(e, long(0.25, e)), (e, by_means(0.25, e))]) {
            let picture = render(&caster, &scene, &view);
            let found = max_error(&picture.frame, &want);
            let gain = short.stats.counts.samples as f64 / picture.stats.counts.samples as f64;
            println!(
                "{compositing:?} {:?}: error {found:.1e} (all short: {own:.1e}), {gain:.1} times fewer steps",
                caster.step
            );
            assert!(found <= error + 2.0 * own + 1e-4, "{found}");
            assert!(gain >= 2.0, "{gain}");
        }
    }
}

#[test]
fn a_changed_transfer_function_is_taken_over() {
    let field = |x: f64, y: f64, z: f64| 0.5 + 0.4 * (0.2 * x).sin() * (0.15 * y).cos() + 0.1 * (0.1 * z).sin();
    let (volume, control) = (volume([33; 3], field), Control::default());
    let scene = |alpha: f64| {
        let points = [(0.0, [0.2, 0.9, 0.1], 0.01), (1.0, [0.3, 0.1, 0.9], alpha)];
        Scene::new(volume.clone(), transfer(&points, 1.0))
    };
    let view = oblique(&scene(0.1), 16);
    let mut prepared = long(0.5, 0.3).prepare(&scene(0.1), &control).unwrap();
    prepared.update(&scene(0.02), &control).unwrap();
    let fresh = render(&long(0.5, 0.3), &scene(0.02), &view);
    let updated = prepared.render(&view, &control).unwrap();
    assert_eq!(updated.frame, fresh.frame);
    assert_eq!(updated.stats.counts, fresh.stats.counts);
}

#[test]
fn what_has_no_bound_is_refused() {
    let scene = Scene::new(volume([5; 3], |x, _, _| x / 4.0), homogeneous(0.1));
    let refuses = |caster: &RayCaster, scene: &Scene| {
        matches!(caster.prepare(scene, &Control::default()), Err(RenderError::Unsupported { .. }))
    };
    let caster = RayCaster { step: Step::Homogeneous { step: 0.5, error: 0.01 }, ..RayCaster::default() };
    assert!(!refuses(&caster, &scene));
    assert!(refuses(&caster, &Scene { compositing: Compositing::Maximum, ..scene.clone() }));
    assert!(!refuses(&caster, &Scene { shading: Some(Default::default()), ..scene.clone() }));
    assert!(!refuses(&caster, &Scene { compositing: Compositing::Accumulate { level: 0.5 }, ..scene.clone() }));
    let by_gradient = Shading { gradient_opacity: vec![(0.0, 0.0), (1.0, 1.0)], ..Shading::default() };
    assert!(refuses(&caster, &Scene { shading: Some(by_gradient.into()), ..scene.clone() }));
    assert!(refuses(&RayCaster { rule: Rule::Left, ..caster.clone() }, &scene));
    let cells = RayCaster { traversal: Traversal::Cells, ..caster };
    assert!(matches!(cells.prepare(&scene, &Control::default()), Err(RenderError::Option(_))));
    for (step, error) in [(0.0, 0.1), (0.5, 0.0), (0.5, f64::NAN), (0.5, 2.0)] {
        let caster = RayCaster { step: Step::Homogeneous { step, error }, ..RayCaster::default() };
        assert!(matches!(caster.prepare(&scene, &Control::default()), Err(RenderError::Option(_))), "{step} {error}");
    }
}
