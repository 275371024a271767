//! The steps of a lattice in which something may be visible.

use std::ops::Range;

use vr_core::IndexRay;

use super::{Lattice, Vicinity};
use crate::leap::{EmptySpace, Leaper};

/// The steps of a ray's lattice in which something may be visible, as ranges that neither touch what was given out before nor are empty.
pub(crate) struct VisibleSteps<'a> {
    lattice: Lattice,
    source: Source<'a>,
    /// Steps before each range that are given out, too.
    before: u32,
    /// Steps from here on have not been given out.
    next: u32,
}

/// Who knows.
enum Source<'a> {
    /// Nobody: all steps.
    All,
    /// Intervals of the ray.
    Intervals { leaper: &'a dyn Leaper, ray: IndexRay, from: f64 },
    /// The vicinity flag.
    Vicinity(Vicinity<'a>),
}

impl<'a> VisibleSteps<'a> {
    /// Of a ray, from a step on; with each range, also `before` steps that precede it.
    pub(crate) fn new(
        lattice: Lattice,
        first: u32,
        before: u32,
        ray: &IndexRay,
        empty_space: Option<&'a EmptySpace>,
    ) -> Self {
        let intervals = |leaper| Source::Intervals { leaper, ray: *ray, from: lattice.begin(first) };
        let source = match empty_space {
            None => Source::All,
            Some(EmptySpace::Leaper(leaper)) => intervals(leaper.as_ref()),
            Some(EmptySpace::Octree(octree)) => intervals(octree.as_ref()),
            Some(EmptySpace::Vicinity(flags)) => Source::Vicinity(Vicinity::new(flags, lattice, ray, first)),
        };
        Self { lattice, source, before, next: first }
    }

    /// The next range; `None` behind the last one.
    pub(crate) fn next(&mut self) -> Option<Range<u32>> {
        loop {
            let range = match &mut self.source {
                Source::All => self.next..self.lattice.count,
                Source::Intervals { leaper, ray, from } => {
                    let (begin, end) = leaper.next(ray, *from)?;
                    *from = end;
                    self.lattice.steps_in(begin, end)
                }
                Source::Vicinity(vicinity) => vicinity.next()?,
            };
            let first = range.start.saturating_sub(self.before).max(self.next);
            if first < range.end {
                self.next = range.end;
                return Some(first..range.end);
            }
            // An interval within a step that was given out already; or the end, where all are.
            if matches!(self.source, Source::All) {
                return None;
            }
        }
    }
}
