//! Bounds of the error on random scenes of every kind of volume, look and operator.

use std::ops::Range;
use std::sync::Arc;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, RngSeed, TestRunner};
use vr_core::{Compositing, Control, ControlPoint, GradientMethod, Scene, Shading, TransferFunction, Volume};
use vr_physics::check::TestScene;
use vr_physics::check::strategies::{self, Kind};

use crate::Error;
use crate::bounds::{BOUNDS, Solved, Tally};

/// Scenes of one kind, by name.
type Drawn = (&'static str, BoxedStrategy<TestScene>);

/// Rows of a transfer function by the gradient, made of that of a scene: the share of its opacity, the turn of its colours and the way to the next magnitude.
type Row = (f64, usize, f64);

/// Returns scenes whose transfer function has two to four rows.
fn with_rows() -> impl Strategy<Value = TestScene> {
    let share = prop_oneof![1 => Just(0.0), 2 => 0.0..1.0];
    let rows = vec((share, 0..3usize, 0.01..1.0), 2..=4);
    let shading = prop_oneof![
        Just(None),
        prop_oneof![Just(GradientMethod::Analytic), Just(GradientMethod::CentralDifferences)].prop_map(Some)
    ];
    let parts = (strategies::scene(), strategies::filter(), rows, shading, any::<bool>());
    parts.prop_filter_map("walls of rows", |(test, filter, rows, gradient, from_flat)| {
        let transfer = by_gradient(&test.scene, &rows, from_flat)?;
        let shading = gradient.map(|gradient| Arc::new(Shading { gradient, ..Shading::default() }));
        let compositing = match test.scene.compositing {
            accumulate @ Compositing::Accumulate { .. } => accumulate,
            _ => Compositing::Over,
        };
        let TestScene { scene, view } = test;
        let scene = Scene { transfer: Arc::new(transfer), shading, compositing, ..scene.with_filter(filter) };
        Some(TestScene { scene, view })
    })
}

fn by_gradient(scene: &Scene, rows: &[Row], from_flat: bool) -> Option<TransferFunction> {
    let Volume::Grid(grid) = &scene.volume else { return None };
    let (low, high) = grid.value_stats().range.unwrap_or_default();
    let spacing = grid.placement().spacing().min_element();
    let steepest = (f64::from(high) - f64::from(low)).max(1.0) * grid.calibration().slope.abs() / spacing;
    let mut magnitude = if from_flat { 0.0 } else { 0.1 * steepest };
    let rows = rows.iter().map(|&(share, turn, gap)| {
        let points = scene.transfer.points().iter().map(|p| {
            let color = std::array::from_fn(|c| p.color[(c + turn) % 3]);
            ControlPoint { opacity: (p.opacity * share).min(0.999), color, ..*p }
        });
        let row = (magnitude, points.collect());
        magnitude += gap * 0.5 * steepest;
        row
    });
    TransferFunction::of_rows(rows.collect(), scene.transfer.rule(), scene.transfer.unit_distance()).ok()
}

fn all() -> Vec<Drawn> {
    let kinds = Kind::ALL.into_iter().chain(Kind::OF_OTHER_VOLUMES).map(|kind| (kind.name(), kind.scenes()));
    kinds
        .chain([
            ("rows by gradient", with_rows().boxed()),
            ("points", strategies::point_scene().boxed()),
            ("shaded points", strategies::shaded_point_scene().boxed()),
            ("means of points", strategies::tame_mixed_point_scene().boxed()),
        ])
        .collect()
}

/// Draws scenes of some seeds of every kind under each bound, and prints the table.
pub fn count(seeds: Range<u64>) -> Result<(), Error> {
    let all = all();
    println!("seeds {} to {} of each of {} kinds of scenes", seeds.start, seeds.end, all.len());
    println!("\n| scenes | bound | {} |", Tally::HEADING);
    let mut sums: [Tally; 3] = Default::default();
    for (name, scenes) in &all {
        let mut tallies: [Tally; 3] = Default::default();
        for seed in seeds.clone() {
            draw((name, seed), scenes, &mut tallies)?;
        }
        for ((tally, sum), bound) in tallies.iter().zip(&mut sums).zip(BOUNDS) {
            println!("| {name} | {bound} | {} |", tally.row());
            sum.join(tally);
        }
    }
    for (sum, bound) in sums.iter().zip(BOUNDS) {
        println!("| all | {bound} | {} |", sum.row());
    }
    Ok(())
}

/// Draws a scene under each bound, and adds it up.
fn draw((name, seed): (&str, u64), scenes: &BoxedStrategy<TestScene>, tallies: &mut [Tally; 3]) -> Result<(), Error> {
    let config = Config {
        rng_algorithm: RngAlgorithm::ChaCha,
        rng_seed: RngSeed::Fixed(seed),
        failure_persistence: None,
        ..Config::default()
    };
    let tree = scenes.new_tree(&mut TestRunner::new(config)).map_err(|e| e.message().to_owned())?;
    let (TestScene { scene, view }, control) = (tree.current(), Control::default());
    let [width, height] = view.size;
    let pixels = (0..width * height).map(|i| [i % width, i / width]).collect();
    let solved = Solved::new(&scene, &view, pixels, &control)?;
    for (tally, bound) in tallies.iter_mut().zip(BOUNDS) {
        let judged = solved.judge(bound, &scene, &view, &control)?;
        if let Some(judged) = judged.filter(|judged| judged.breaks_its_promise()) {
            println!("{name}, seed {seed}: max-error {bound}: {judged:?}");
        }
        tally.add(judged);
    }
    Ok(())
}
