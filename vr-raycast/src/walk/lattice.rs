//! Steps of equal length, and one shorter one at the end.

use crate::run::{RUN, Steps};

/// A ray's part cut into steps of one length, from where it enters on; the last one ends where the ray does and is as long as is left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lattice {
    pub(crate) start: f64,
    pub(crate) length: f64,
    pub(crate) count: u32,
    /// Length of the last step: above 0, at most `length`.
    pub(crate) last: f64,
}

/// Of a ray's length: a last step shorter than this is rounding, not a step, and falls to the one before.
const SLIVER: f64 = 1e-12;

/// Steps on a ray at most: the numbers of steps are 32-bit, and nobody waits for more.
const MOST_STEPS: f64 = u32::MAX as f64;

impl Lattice {
    /// Cuts the interval, which must not be empty.
    pub(crate) fn new(start: f64, end: f64, length: f64) -> Self {
        let chord = end - start;
        let sliver = SLIVER * chord;
        let count = ((chord - sliver) / length).ceil().clamp(1.0, MOST_STEPS);
        let rest = chord - (count - 1.0) * length;
        // Whole up to rounding: whole, so that the table's entry serves and the picture does not depend on the last bit.
        let last = if rest + sliver >= length { length } else { rest };
        Self { start, length, count: count as u32, last }
    }

    /// Where step `k` begins; `k` = count: a whole step beyond the last.
    pub(crate) fn begin(&self, k: u32) -> f64 {
        self.start + f64::from(k) * self.length
    }

    /// Length of step `k`.
    pub(crate) fn length_of(&self, k: u32) -> f64 {
        if k + 1 == self.count { self.last } else { self.length }
    }
}

/// Walks all steps of a lattice.
///
/// Runs begin at every 32nd step of the lattice, whatever is left out: sums are rounded run by run, and so a picture does not change
/// by a bit where invisible steps are dropped.
#[derive(Clone, Debug)]
pub(crate) struct LatticeWalk {
    lattice: Lattice,
    /// The first step.
    first: u32,
    /// Runs not yet walked.
    runs: std::ops::Range<u32>,
    backwards: bool,
}

impl LatticeWalk {
    /// From step `first` on, before which nothing is visible, to the end; or from the far end back to it.
    pub(crate) fn new(lattice: Lattice, first: u32, backwards: bool) -> Self {
        let end = if first < lattice.count { lattice.count.div_ceil(RUN as u32) } else { 0 };
        Self { lattice, first, runs: first / RUN as u32..end, backwards }
    }

    /// Fills the next run; false where all are walked.
    pub(crate) fn next(&mut self, steps: &mut Steps) -> bool {
        let Some(run) = (if self.backwards { self.runs.next_back() } else { self.runs.next() }) else { return false };
        let first = run * RUN as u32;
        steps.len = 0;
        for k in first.max(self.first)..(first + RUN as u32).min(self.lattice.count) {
            steps.push(self.lattice.begin(k), self.lattice.length_of(k), k);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn walks_every_step_once_both_ways() {
        let lattice = Lattice::new(0.0, 70.5, 1.0);
        for backwards in [false, true] {
            let (mut walk, mut steps, mut runs) = (LatticeWalk::new(lattice, 0, backwards), Steps::new(), Vec::new());
            while walk.next(&mut steps) {
                runs.push(steps.number[..steps.len].to_vec());
            }
            if backwards {
                runs.reverse();
            }
            assert_eq!(runs.concat(), (0..71).collect::<Vec<_>>());
            assert!(runs.iter().all(|r| r[0] % RUN as u32 == 0));
        }
        // Runs end at the same steps whatever the first one is.
        let (mut walk, mut steps) = (LatticeWalk::new(lattice, 40, false), Steps::new());
        assert!(walk.next(&mut steps));
        assert_eq!((steps.number[0], steps.number[steps.len - 1]), (40, 63));
        for first in [70, 71, u32::MAX] {
            let mut walk = LatticeWalk::new(lattice, first, false);
            assert_eq!(walk.next(&mut steps), first == 70);
        }
    }
}
