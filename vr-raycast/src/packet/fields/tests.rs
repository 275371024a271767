//! Comparison of packets under all filters, with gradients of both kinds and with colours, with the plain engine.

use std::sync::Arc;

use proptest::prelude::*;
use vr_core::{
    ColorGrid, Compositing, Control, Filter, GradientMethod, Light, Rendered, Renderer, Scene, Shading, View, Volume,
};

use crate::caster::{CompositingOrder, EmptySpace, RayCaster, Rule, Step};
use crate::engine::Engine;
use crate::packet::compared::{plain, row_by_row, same};
use crate::packet::random_scenes::{factors, scenes, steps, sums};
use crate::prepared::PreparedCaster;
use crate::tracer::RaySample;

/// Largest difference of the engines: positions differ by some units in the last place of f32, which the steepest ramps turn into ten times as much opacity
/// at each of some dozen samples. The filters of four taps an axis rise up to 1.6 times as steeply as the trilinear one, and the Gaussian's exponentials
/// differ by 10⁻⁷.
const TWO_ENGINES: f32 = 6e-5;

/// Largest difference of shaded pictures: the direction of a small gradient is set by rounding, and so is what a surface there reflects.
const TWO_SHADINGS: f32 = 2e-3;

/// Largest difference in steps that follow the data: where a ray grazes an edge of blocks, f32 and f64 may see different ones.
const TWO_WALKS: f32 = 0.02;

fn filters() -> impl Strategy<Value = Filter> {
    prop::sample::select(Filter::ALL.to_vec())
}

/// The scene's volume with a colour at each voxel.
fn with_colors(scene: Scene, seed: u64) -> Scene {
    let grid = scene.volume.grid().unwrap();
    let mut state = seed;
    let channel = |state: &mut u64| {
        let next = |_| {
            *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (*state >> 48) as u16
        };
        (0..grid.dims().iter().product::<usize>()).map(next).collect::<Vec<_>>()
    };
    let channels = [channel(&mut state), channel(&mut state), channel(&mut state)];
    let colors = ColorGrid::new((**grid).clone(), channels).unwrap();
    Scene { volume: Volume::Color(Arc::new(colors)), ..scene }
}

fn shaded(scene: Scene, gradient: GradientMethod, gradient_opacity: Vec<(f64, f64)>) -> Scene {
    let shading = Shading { gradient, gradient_opacity, ..Shading::default() };
    Scene { shading: Some(Arc::new(shading)), lights: vec![Light::default()], ..scene }
}

/// The picture by packets; `None` where they do not draw it.
fn packets(caster: &RayCaster, scene: &Scene, view: &View) -> Option<Rendered> {
    let control = Control::default();
    let prepared = PreparedCaster::new(caster.clone(), scene, &control).unwrap();
    if !matches!(prepared.engine, Engine::Packets(..) | Engine::Picks(..)) {
        return None;
    }
    Some(caster.prepare(scene, &control).unwrap().render(view, &control).unwrap())
}

/// Checks that the engines draw the same. Where the field or its colours jump, rounding of positions may tell a sample either way: one pixel in a picture.
fn check(caster: &RayCaster, scene: &Scene, view: &View, tolerance: f32) -> Result<(), TestCaseError> {
    let Some(drawn) = packets(caster, scene, view) else { return Ok(()) };
    let plain = plain(caster, scene, view);
    prop_assert!(drawn.stats.counts.rays <= plain.stats.counts.rays);
    let depth = drawn.frame.depth().unwrap();
    let of =
        |s: vr_core::image_order::ImageSample| RaySample { rgba: drawn.frame.pixels()[s.pixel], depth: depth[s.pixel] };
    let mut samples: Vec<RaySample> = row_by_row(view).into_iter().map(of).collect();
    if scene.volume.filter() == Some(Filter::Nearest) {
        let off = |i: usize| {
            let pairs = samples[i].rgba.iter().zip(&plain.frame.pixels()[i]);
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
        };
        let worst = (0..samples.len()).max_by(|&a, &b| off(a).total_cmp(&off(b))).unwrap();
        samples[worst] = RaySample { rgba: plain.frame.pixels()[worst], depth: plain.frame.depth().unwrap()[worst] };
    }
    same(&samples, &plain, tolerance)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn filters_are_those_of_the_plain_engine((scene, view) in scenes(0.9), filter in filters(), step in 0.1f64..2.5, left in any::<bool>(), compositing in sums()) {
        let scene = Scene { compositing, ..scene }.with_filter(filter);
        let rule = if left { Rule::Left } else { Rule::Midpoint };
        let caster = RayCaster { rule, order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(step) };
        check(&caster, &scene, &view, TWO_ENGINES)?;
    }

    #[test]
    fn gradients_of_both_kinds_are_those_of_the_plain_engine((scene, view) in scenes(0.9), filter in filters(), step in 0.1f64..2.5, analytic in any::<bool>(), factors in factors(), compositing in sums()) {
        let gradient = if analytic { GradientMethod::Analytic } else { GradientMethod::CentralDifferences };
        let scene = shaded(Scene { compositing, ..scene }.with_filter(filter), gradient, factors);
        let caster = RayCaster { order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(step) };
        check(&caster, &scene, &view, TWO_SHADINGS)?;
    }

    #[test]
    fn colours_are_those_of_the_plain_engine((scene, view) in scenes(0.9), filter in filters(), seed in any::<u64>(), step in 0.1f64..2.5, shade in 0u32..3, factors in factors(), compositing in sums()) {
        let mut scene = with_colors(Scene { compositing, ..scene }.with_filter(filter), seed);
        if shade > 0 {
            let gradient = [GradientMethod::Analytic, GradientMethod::CentralDifferences][shade as usize - 1];
            scene = shaded(scene, gradient, factors);
        }
        let caster = RayCaster { order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(step) };
        check(&caster, &scene, &view, if shade > 0 { TWO_SHADINGS } else { TWO_ENGINES })?;
    }

    #[test]
    fn local_steps_are_those_of_the_plain_engine((scene, view) in scenes(0.9), filter in filters(), seed in prop::option::of(any::<u64>()), shade in 0usize..3, factors in factors(), error in 1e-4f64..1e-2, compositing in sums()) {
        let mut scene = Scene { compositing, ..scene }.with_filter(filter);
        if let Some(seed) = seed {
            scene = with_colors(scene, seed);
        }
        if shade > 0 {
            let gradient = [GradientMethod::Analytic, GradientMethod::CentralDifferences][shade - 1];
            scene = shaded(scene, gradient, factors);
        }
        let caster = RayCaster { step: Step::Local { error }, order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) };
        check(&caster, &scene, &view, TWO_WALKS)?;
    }

    /// By rules that integrate over all values of a step.
    #[test]
    fn integrals_are_those_of_the_plain_engine((scene, view) in scenes(0.9), filter in filters(), step in steps(), quadratic in any::<bool>(), is_shaded in any::<bool>(), factors in factors()) {
        prop_assume!(filter.is_continuous());
        let mut scene = scene.with_filter(filter);
        if is_shaded {
            scene = shaded(scene, GradientMethod::Analytic, factors);
        }
        let is_local = matches!(step, Step::Local { .. });
        // A parabola may leave the values of the blocks that it goes through: which ones are leaped over would show.
        let empty_space = if quadratic && !is_local { EmptySpace::None } else { EmptySpace::default() };
        let rule = if quadratic { Rule::Quadratic } else { Rule::Linear };
        let caster = RayCaster { rule, empty_space, step, order: CompositingOrder::WHOLE_RAY, ..RayCaster::uniform(0.2) };
        let tolerance = if is_local { TWO_WALKS } else if is_shaded { TWO_SHADINGS } else { TWO_ENGINES };
        check(&caster, &scene, &view, tolerance)?;
    }

    /// Under operators that pick a value, with colours and without.
    #[test]
    fn picks_are_those_of_the_plain_engine((scene, view) in scenes(0.9), filter in filters(), seed in prop::option::of(any::<u64>()), compositing in prop::sample::select(vec![Compositing::Minimum, Compositing::Maximum, Compositing::Average]), step in 0.1f64..2.5) {
        let mut scene = Scene { compositing, ..scene }.with_filter(filter);
        if let Some(seed) = seed {
            scene = with_colors(scene, seed);
        }
        check(&RayCaster::uniform(step), &scene, &view, TWO_ENGINES)?;
    }

    #[test]
    fn no_bit_depends_on_leaping((scene, view) in scenes(1.0), filter in filters(), seed in prop::option::of(any::<u64>()), step in 0.1f64..2.5, compositing in sums()) {
        let mut scene = shaded(Scene { compositing, ..scene }.with_filter(filter), GradientMethod::Analytic, Vec::new());
        if let Some(seed) = seed {
            scene = with_colors(scene, seed);
        }
        let caster = RayCaster::uniform(step);
        let Some(want) = packets(&caster, &scene, &view) else { return Ok(()) };
        let all = packets(&RayCaster { empty_space: EmptySpace::None, ..caster }, &scene, &view).unwrap();
        prop_assert!(want.stats.counts.samples <= all.stats.counts.samples);
        prop_assert_eq!(&all.frame, &want.frame);
    }
}
