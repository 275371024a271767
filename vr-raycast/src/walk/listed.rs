//! List of steps that are found one after the other before the first is taken.

use crate::run::{RUN, Steps};

/// Walk over the steps of a list, in runs of 32 from its beginning on, whichever end the walk begins at.
#[derive(Clone, Debug)]
pub(crate) struct ListedWalk {
    /// Begin and length of every step, in world distance.
    steps: Vec<(f64, f64)>,
    /// Index-space positions of the samples, where they do not lie on the ray.
    places: Option<Vec<[f64; 3]>>,
    /// True for the steps that are walked; empty if all are.
    seen: Vec<bool>,
    /// Runs not yet walked.
    runs: std::ops::Range<usize>,
    /// Run that was walked last.
    run: usize,
    backwards: bool,
}

impl ListedWalk {
    /// Begins a walk from step `first`, before which nothing is visible, to the end; or from the far end back to it.
    pub(crate) fn new(steps: Vec<(f64, f64)>, places: Option<Vec<[f64; 3]>>, first: u32, backwards: bool) -> Self {
        let runs = first as usize / RUN..steps.len().div_ceil(RUN);
        Self { steps, places, seen: Vec::new(), runs, run: 0, backwards }
    }

    /// Begins a walk over the steps that are `seen`, one flag for each. Runs begin at every 32nd of all steps, as if all were walked: sums are rounded run by
    /// run.
    pub(crate) fn over_seen(steps: Vec<(f64, f64)>, seen: Vec<bool>, backwards: bool) -> Self {
        Self { seen, ..Self::new(steps, None, 0, backwards) }
    }

    /// Fills the next run; returns false if all are walked.
    pub(crate) fn next(&mut self, steps: &mut Steps) -> bool {
        steps.len = 0;
        while steps.len == 0 {
            let next = if self.backwards { self.runs.next_back() } else { self.runs.next() };
            let Some(run) = next else { return false };
            self.run = run;
            for k in self.numbers().filter(|&k| self.seen.get(k) != Some(&false)) {
                let (begin, length) = self.steps[k];
                steps.push(begin, length, k as u32);
            }
        }
        true
    }

    /// Returns the positions of the samples of the last run, if they are not on the ray.
    pub(crate) fn places(&self) -> Option<&[[f64; 3]]> {
        self.places.as_ref().map(|places| &places[self.numbers()])
    }

    fn numbers(&self) -> std::ops::Range<usize> {
        self.run * RUN..((self.run + 1) * RUN).min(self.steps.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walks_every_step_once_both_ways() {
        let list: Vec<(f64, f64)> = (0..70).map(|i| (f64::from(i), 1.0)).collect();
        let places: Vec<[f64; 3]> = (0..70).map(|i| [f64::from(i); 3]).collect();
        for backwards in [false, true] {
            let mut walk = ListedWalk::new(list.clone(), Some(places.clone()), 0, backwards);
            let (mut steps, mut runs) = (Steps::new(), Vec::new());
            while walk.next(&mut steps) {
                assert!(walk.places().unwrap().iter().zip(steps.begin).all(|(p, s)| p[0] == s));
                runs.push(steps.number[..steps.len].to_vec());
            }
            if backwards {
                runs.reverse();
            }
            assert_eq!(runs.concat(), (0..70).collect::<Vec<_>>());
        }
        let (mut walk, mut steps) = (ListedWalk::new(list, None, 40, false), Steps::new());
        assert!(walk.next(&mut steps) && walk.places().is_none());
        assert_eq!(steps.number[0], 32);
    }
}
