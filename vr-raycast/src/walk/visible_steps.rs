//! Steps of a sequence in which something may be visible.

use std::ops::Range;

use vr_core::IndexRay;

use super::StepSequence;
use crate::leap::Leaper;

/// Steps of a ray in which something may be visible, as ranges that are not empty and do not touch those given out before.
pub(crate) struct VisibleSteps<'a, S> {
    sequence: S,
    ray: IndexRay,
    /// Structure that finds visible intervals; `None` if all steps are visible.
    leaper: Option<&'a dyn Leaper>,
    /// World distance up to which `leaper` has been asked.
    from: f64,
    /// Number of steps before each range that are given out, too.
    before: u32,
    /// First step that has not been given out.
    next: u32,
}

impl<'a, S: StepSequence> VisibleSteps<'a, S> {
    /// Finds the visible steps of a ray, from step `first` on; with each range, also `before` steps that precede it.
    pub(crate) fn new(sequence: S, first: u32, before: u32, ray: &IndexRay, leaper: Option<&'a dyn Leaper>) -> Self {
        let from = sequence.begin(first);
        Self { sequence, ray: *ray, leaper, from, before, next: first }
    }

    /// Returns the next range; `None` behind the last one.
    pub(crate) fn next(&mut self) -> Option<Range<u32>> {
        let Some(leaper) = self.leaper else {
            let all = self.next..self.sequence.numbers().end;
            self.next = all.end;
            return Some(all).filter(|all| !all.is_empty());
        };
        loop {
            let (begin, end) = leaper.next(&self.ray, self.from)?;
            self.from = end;
            let range = self.sequence.steps_in(begin, end);
            let first = range.start.saturating_sub(self.before).max(self.next);
            // If not, an interval within a step that was given out already.
            if first < range.end {
                self.next = range.end;
                return Some(first..range.end);
            }
        }
    }
}
