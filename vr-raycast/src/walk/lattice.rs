//! Lattice of steps of equal length, and a shorter one at the end.

use std::ops::Range;

use super::{StepSequence, VisibleSteps};
use crate::run::{RUN, Steps};

/// Part of a ray cut into steps of one length, from where it enters on; the last one takes the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lattice {
    pub(crate) start: f64,
    pub(crate) length: f64,
    pub(crate) count: u32,
    /// Length of the last step: above 0, at most `length`.
    pub(crate) last: f64,
}

/// Fraction of a ray's length below which a last step is rounding and falls to the one before.
const SLIVER: f64 = 1e-12;

/// Largest number of steps on a ray: they are numbered in 32 bits.
const MAX_STEPS: f64 = u32::MAX as f64;

impl Lattice {
    /// Cuts the interval, which must not be empty.
    pub(crate) fn new(start: f64, end: f64, length: f64) -> Self {
        let chord = end - start;
        let sliver = SLIVER * chord;
        let count = ((chord - sliver) / length).ceil().clamp(1.0, MAX_STEPS);
        let rest = chord - (count - 1.0) * length;
        // Whole up to rounding: whole, so that the table's entry serves and the picture does not depend on the last bit.
        let last = if rest + sliver >= length { length } else { rest };
        Self { start, length, count: count as u32, last }
    }

    /// Returns the distance at which step `k` begins; for `k` = count, a whole step beyond the last.
    pub(crate) fn begin(&self, k: u32) -> f64 {
        self.start + f64::from(k) * self.length
    }

    /// Returns the length of step `k`.
    pub(crate) fn length_of(&self, k: u32) -> f64 {
        if k + 1 == self.count { self.last } else { self.length }
    }
}

impl StepSequence for Lattice {
    fn numbers(&self) -> Range<u32> {
        0..self.count
    }

    fn begin(&self, number: u32) -> f64 {
        Self::begin(self, number)
    }

    fn push(&self, numbers: Range<u32>, steps: &mut Steps) {
        for k in numbers {
            steps.push(self.begin(k), self.length_of(k), k);
        }
    }

    fn steps_in(&self, begin: f64, end: f64) -> Range<u32> {
        // `as` saturates: what rounding carries below 0 is 0.
        let step = |s: f64| ((s - self.start) / self.length) as u32;
        step(begin)..step(end).saturating_add(1).min(self.count)
    }
}

/// Walk over the steps of a sequence in which something may be visible.
///
/// Runs begin at every 32nd step of the sequence, whatever is left out: sums are rounded run by run, and so a picture does not change
/// by a bit where invisible steps are dropped. Runs of which nothing is left are passed over.
pub(crate) struct SequenceWalk<'a, S> {
    sequence: S,
    order: WalkOrder<'a, S>,
    /// Number of steps before the walk's place that it has left out.
    skipped: u64,
}

/// Order in which runs are walked.
enum WalkOrder<'a, S> {
    Forwards {
        visible: VisibleSteps<'a, S>,
        /// Part of the last range asked for that is not walked yet.
        ahead: Range<u32>,
        /// Step that the walk has reached.
        at: u32,
    },
    Backwards {
        /// Ranges that are not walked yet, in order along the ray.
        left: Vec<Range<u32>>,
    },
}

impl<'a, S: StepSequence> SequenceWalk<'a, S> {
    /// Begins a walk from front to back, or from the far end.
    pub(crate) fn new(sequence: S, mut visible: VisibleSteps<'a, S>, backwards: bool) -> Self {
        let all = sequence.numbers();
        if backwards {
            let left: Vec<_> = std::iter::from_fn(|| visible.next()).collect();
            let walked = left.iter().map(|r| u64::from(r.end - r.start)).sum::<u64>();
            // All of the ray is walked, and so all that is not is skipped.
            let skipped = u64::from(all.end - all.start) - walked;
            return Self { sequence, order: WalkOrder::Backwards { left }, skipped };
        }
        Self { sequence, order: WalkOrder::Forwards { visible, ahead: 0..0, at: all.start }, skipped: 0 }
    }

    /// Returns the number of steps left out so far.
    pub(crate) fn skipped(&self) -> u64 {
        self.skipped
    }

    /// Fills the next run; returns false if all are walked.
    pub(crate) fn next(&mut self, steps: &mut Steps) -> bool {
        steps.len = 0;
        let Self { sequence, order, skipped } = self;
        match order {
            WalkOrder::Forwards { visible, ahead, at } => {
                let mut end_of_run = None;
                loop {
                    if ahead.start >= ahead.end {
                        let Some(range) = visible.next() else {
                            let end = sequence.numbers().end;
                            *skipped += u64::from(end - *at);
                            *at = end;
                            break;
                        };
                        *ahead = range;
                    }
                    let end_of_run =
                        *end_of_run.get_or_insert((ahead.start / RUN as u32 + 1).saturating_mul(RUN as u32));
                    if ahead.start >= end_of_run {
                        break;
                    }
                    *skipped += u64::from(ahead.start - *at);
                    *at = ahead.end.min(end_of_run);
                    sequence.push(ahead.start..*at, steps);
                    ahead.start = *at;
                }
            }
            WalkOrder::Backwards { left } => {
                if let Some(last) = left.last() {
                    let begin_of_run = (last.end - 1) / RUN as u32 * RUN as u32;
                    let inside = left.partition_point(|range| range.end <= begin_of_run);
                    for range in &left[inside..] {
                        sequence.push(range.start.max(begin_of_run)..range.end, steps);
                    }
                    let reaches_on = left[inside].start < begin_of_run;
                    left[inside].end = begin_of_run;
                    left.truncate(inside + usize::from(reaches_on));
                }
            }
        }
        steps.len > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::leap::{ExactCloud, Leaper, VisibleBlocks};
    use glam::DVec3;
    use proptest::prelude::*;
    use vr_core::IndexRay;

    #[test]
    fn the_last_step_is_what_is_left() {
        let s = Lattice::new(-1.0, 1.3, 0.5);
        assert_eq!(s.count, 5);
        assert!((s.last - 0.3).abs() < 1e-15);
        assert_eq!(Lattice::new(0.0, 0.2, 0.5), Lattice { start: 0.0, length: 0.5, count: 1, last: 0.2 });
    }

    #[test]
    fn whole_numbers_of_steps_survive_rounding() {
        for n in [1, 3, 7, 1000, 4096] {
            for length in [0.1, 1.0 / 3.0, 1e-20, 1e20] {
                let end = f64::from(n) * length;
                for end in [end.next_down(), end, end.next_up()] {
                    let s = Lattice::new(0.0, end, length);
                    assert_eq!((s.count, s.last), (n, length), "{n} of {length}");
                }
            }
        }
    }

    /// Walks a ray of one cell per world unit, in a volume of one block per cell, each visible or not.
    fn walked(
        lattice: Lattice,
        first: u32,
        before: u32,
        visible: Option<&[bool]>,
        backwards: bool,
    ) -> (Vec<Vec<u32>>, u64) {
        let ray = IndexRay {
            origin: DVec3::new(0.0, 0.5, 0.5),
            direction: DVec3::X,
            start: lattice.start,
            end: lattice.begin(lattice.count - 1) + lattice.last,
            offset: 0.0,
        };
        let cloud = visible.map(|visible| {
            let blocks = VisibleBlocks::from_fn([visible.len() + 1, 2, 2], 1, |[x, _, _]| visible[x]);
            ExactCloud::new(&blocks)
        });
        let visible = VisibleSteps::new(lattice, first, before, &ray, cloud.as_ref().map(|cloud| cloud as &dyn Leaper));
        let (mut walk, mut steps, mut runs) =
            (SequenceWalk::new(lattice, visible, backwards), Steps::new(), Vec::new());
        while walk.next(&mut steps) {
            runs.push(steps.number[..steps.len].to_vec());
        }
        if backwards {
            runs.reverse();
        }
        (runs, walk.skipped())
    }

    #[test]
    fn walks_every_step_once_both_ways() {
        let lattice = Lattice::new(0.0, 70.5, 1.0);
        for backwards in [false, true] {
            let (runs, skipped) = walked(lattice, 0, 0, None, backwards);
            assert_eq!(runs.concat(), (0..71).collect::<Vec<_>>());
            assert!(runs.iter().all(|r| r[0] % RUN as u32 == 0) && skipped == 0);
        }
        // Runs end where they do, whatever step is the first.
        let (runs, skipped) = walked(lattice, 40, 0, None, false);
        assert_eq!((runs[0][0], runs[1][0], skipped), (40, 64, 40));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

        /// Steps that touch a visible cell are walked, once and in order, and all others (but for rounding at their ends) are skipped; none
        /// shares a run with steps of another run of the lattice.
        #[test]
        fn drops_what_touches_nothing_visible(
            visible in prop::collection::vec(prop::bool::weighted(0.1), 2..90),
            step in 0.1f64..3.0,
            before in 0u32..2,
            first in 0u32..40,
            backwards in any::<bool>(),
        ) {
            let n = visible.len();
            let lattice = Lattice::new(0.0, n as f64, step);
            let first = first.min(lattice.count - 1);
            let (runs, skipped) = walked(lattice, first, before, Some(&visible), backwards);
            let all = runs.concat();
            prop_assert!(all.windows(2).all(|w| w[0] < w[1]));
            prop_assert_eq!(skipped + all.len() as u64, u64::from(lattice.count));
            for run in &runs {
                prop_assert_eq!(run[0] / RUN as u32, run[run.len() - 1] / RUN as u32);
            }
            prop_assert!(runs.windows(2).all(|w| w[0][0] / RUN as u32 != w[1][0] / RUN as u32));
            let touches = |k: u32, margin: f64| {
                let (begin, end) = (lattice.begin(k) - margin, lattice.begin(k) + lattice.length_of(k) + margin);
                (begin.max(0.0) as usize..=(end as usize).min(n - 1)).any(|x| visible[x])
            };
            for k in first..lattice.count {
                let walked = all.binary_search(&k).is_ok();
                let wanted = |margin: f64| {
                    (k..=(k + before).min(lattice.count - 1)).any(|k| touches(k, margin))
                };
                prop_assert!(walked || !wanted(0.0), "step {} is missing", k);
                // The beam's reach.
                prop_assert!(!walked || wanted(1e-3), "step {} is walked in vain", k);
            }
        }
    }
}
