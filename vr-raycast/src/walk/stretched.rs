//! Steps as long as the stretches of a ray allow.

use vr_core::IndexRay;
use vr_core::field::Stretch;

use super::cut::{SLIVER, cut_steps};
use super::{Lattice, ListedWalk};

/// Rule that the steps of a ray follow through a field that knows its stretches.
pub(crate) struct StretchSteps<'a> {
    /// World length of a step on a stretch.
    pub(crate) length: &'a dyn Fn(&Stretch) -> f64,
    /// True if anything in a range of values can be seen.
    pub(crate) shows: &'a dyn Fn([f32; 2]) -> bool,
    /// Number of steps before what is visible that are walked, too.
    pub(crate) before: usize,
    pub(crate) backwards: bool,
}

/// Begins a walk along a ray whose stretches, in its own distances, are given: in steps of the length that each stretch asks for, that end where vacuum
/// begins, without those in which nothing can be seen; returns the number of these, too.
///
/// Stretches of one length of steps that touch have one lattice of them: they lie where they lie if all is seen.
pub(crate) fn stretched_walk(ray: &IndexRay, stretches: &[Stretch], rule: &StretchSteps<'_>) -> (ListedWalk, u64) {
    let mut steps: Vec<(f64, f64)> = Vec::new();
    let (mut seen, mut before) = (Vec::new(), None::<&Stretch>);
    for run in stretches.chunk_by(|a, b| (rule.length)(a) == (rule.length)(b) && a.touches(b)) {
        let (first, last) = (&run[0], &run[run.len() - 1]);
        let step = (rule.length)(first);
        // An end of the field is one of the ray's part, if only rounding keeps them apart.
        let is_at = |a: f64, b: f64| (a - b).abs() <= SLIVER * step;
        let from = if is_at(first.from, ray.start) { ray.start } else { first.from.max(ray.start) };
        let to = if is_at(last.to, ray.end) { ray.end } else { last.to.min(ray.end) };
        let is_behind_vacuum = before.map_or(from > ray.start, |before| !before.touches(first));
        before = Some(last);
        if from >= to {
            continue;
        }
        let begin = steps.len();
        let jumps = if is_behind_vacuum { &[from][..] } else { &[] };
        cut_steps(&Lattice::new(from, to, step), jumps, &mut steps);
        mark_seen(&steps, begin, run, rule, &mut seen);
    }
    let skipped = seen.iter().filter(|seen| !**seen).count() as u64;
    (ListedWalk::over_seen(steps, seen, rule.backwards), skipped)
}

/// Appends whether something can be seen in each step from number `begin` on, or in one of the steps behind it that ask for it.
fn mark_seen(steps: &[(f64, f64)], begin: usize, run: &[Stretch], rule: &StretchSteps<'_>, seen: &mut Vec<bool>) {
    let mut shown = run.iter().filter(|stretch| (rule.shows)(stretch.range)).peekable();
    for &(from, length) in &steps[begin..] {
        while shown.next_if(|stretch| stretch.to < from).is_some() {}
        seen.push(shown.peek().is_some_and(|stretch| stretch.from <= from + length));
    }
    // What comes before is walked, too.
    let mut left = 0;
    for seen in seen[begin..].iter_mut().rev() {
        left = if *seen { rule.before } else { left };
        if !*seen && left > 0 {
            (*seen, left) = (true, left - 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::run::Steps;

    fn walked(stretches: &[(f64, f64, f64, f32)], before: usize) -> (Vec<(f64, f64)>, u64) {
        let ray = IndexRay { origin: DVec3::ZERO, direction: DVec3::X, start: 0.0, end: 8.0, offset: 0.0 };
        let stretches: Vec<Stretch> = stretches
            .iter()
            .map(|&(from, to, spacing, value)| Stretch { from, to, spacing, range: [0.0, value] })
            .collect();
        let shows = |range: [f32; 2]| range[1] > 0.0;
        let length = |stretch: &Stretch| 0.5 * stretch.spacing;
        let rule = StretchSteps { length: &length, shows: &shows, before, backwards: false };
        let (mut walk, skipped) = stretched_walk(&ray, &stretches, &rule);
        let (mut steps, mut all) = (Steps::new(), Vec::new());
        while walk.next(&mut steps) {
            all.extend((0..steps.len).map(|k| (steps.begin[k], steps.length[k])));
        }
        (all, skipped)
    }

    #[test]
    fn steps_follow_the_spacing_and_leave_out_what_is_not_seen() {
        let (all, skipped) = walked(&[(0.0, 1.0, 1.0, 1.0), (1.0, 5.0, 4.0, 1.0), (5.0, 8.0, 1.0, 1.0)], 0);
        assert_eq!(all[..4], [(0.0, 0.5), (0.5, 0.5), (1.0, 2.0), (3.0, 2.0)]);
        assert_eq!((all.len(), skipped), (10, 0));
        // The same lattice where a part of it cannot be seen.
        let dark = [(0.0, 1.2, 1.0, 1.0), (1.2, 3.2, 1.0, 0.0), (3.2, 8.0, 1.0, 1.0)];
        let (all, skipped) = walked(&dark, 0);
        assert_eq!((all[2], all[3], skipped), ((1.0, 0.5), (3.0, 0.5), 3));
        let (all, skipped) = walked(&dark, 1);
        assert_eq!((all[3], skipped), ((2.5, 0.5), 2));
        // Behind vacuum comes a short step.
        let (all, _) = walked(&[(1.0, 2.0, 1.0, 1.0), (4.0, 8.0, 1.0, 1.0)], 0);
        let begins: Vec<f64> = all.iter().map(|s| s.0).collect();
        assert_eq!(begins[..6], [1.0, 1.0005, 1.5, 4.0, 4.0005, 4.5]);
        assert_eq!(walked(&[], 0), (vec![], 0));
    }
}
