//! Bounds of the error on random scenes of every kind of volume, look and operator.

use std::ops::Range;

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, RngSeed, TestRunner};
use vr_core::Control;
use vr_physics::check::TestScene;
use vr_physics::check::strategies::{self, Kind};

use crate::Error;
use crate::bounds::{BOUNDS, Solved, Tally};

/// Scenes of one kind, by name.
type Drawn = (&'static str, BoxedStrategy<TestScene>);

fn all() -> Vec<Drawn> {
    let kinds = Kind::ALL.into_iter().chain(Kind::OF_OTHER_VOLUMES).map(|kind| (kind.name(), kind.scenes()));
    kinds
        .chain([
            ("rows by gradient", strategies::gradient_row_scene().boxed()),
            ("coloured voxels", strategies::colored_grid_scene().boxed()),
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
