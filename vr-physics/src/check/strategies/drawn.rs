//! Tests of strategies: values that a fixed seed draws, and what must hold of them.

use proptest::strategy::{Strategy, ValueTree};
use vr_core::{Control, Model};

use crate::check::{Effort, TestScene};
use crate::{Certainty, Reference, Solution};

/// Draws so many values.
pub(in crate::check) fn draw<T>(strategy: impl Strategy<Value = T>, n: usize) -> Vec<T> {
    let mut runner = Effort::default().runner();
    (0..n).map(|_| strategy.new_tree(&mut runner).unwrap().current()).collect()
}

/// Asserts that at least ten scenes have a feature.
pub(in crate::check) fn some(scenes: &[TestScene], what: &str, test: impl Fn(&TestScene) -> bool) {
    let n = scenes.iter().filter(|t| test(t)).count();
    assert!(n >= 10, "{what}: {n} of {}", scenes.len());
}

fn solve(t: &TestScene) -> Solution {
    Reference::default().solve(&t.scene, &t.view, &Model::Canonical, &Control::default()).unwrap()
}

/// Asserts that scenes are valid, and that the reference solves each with a proven bound.
pub(in crate::check) fn scenes_are_solved(scenes: &[TestScene]) {
    for t in scenes {
        t.scene.validate().unwrap();
        t.view.validate().unwrap();
        let solved = solve(t);
        assert!(solved.pixels.iter().all(|p| p.rgba.iter().all(|x| x.is_finite())), "{t:?}");
        assert!(matches!(solved.certainty(), Certainty::Bound(_)), "{t:?}");
    }
}

/// Asserts that the reference is certain of scenes to a part of their largest magnitude, and that more than half of them show something.
pub(in crate::check) fn tame_scenes_are_certain(scenes: &[TestScene], certainty: f64) {
    let mut visible = 0;
    for t in scenes {
        let solved = solve(t);
        let peak = solved.pixels.iter().flat_map(|p| p.rgba).fold(1.0, f64::max);
        assert!(solved.certainty().value() <= certainty * peak, "{:?} {t:?}", solved.certainty());
        visible += usize::from(solved.pixels.iter().any(|p| p.rgba.iter().any(|&x| x > 1e-3)));
    }
    assert!(2 * visible > scenes.len(), "{visible} of {}", scenes.len());
}
