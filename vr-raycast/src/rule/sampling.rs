//! Samples of a run at several points of each step.

use vr_core::Real;

use super::cubic::Cubic;
use super::profile::{Profile, Shape};
use crate::chord::Chord;
use crate::run::{RUN, Run};

/// Largest number of points of a run, and the last one of the run before.
const POINTS: usize = 4 * RUN + 1;

/// Points at which the field is sampled, and its values there.
#[derive(Clone, Debug)]
pub(crate) struct Points<R> {
    len: usize,
    position: [[R; POINTS]; 3],
    value: [R; POINTS],
    /// Last point of the run before, and the value there.
    before: ([R; 3], R),
}

impl<R: Real> Points<R> {
    pub(crate) fn new() -> Self {
        // No point lies at NaN.
        let before = ([R::NAN; 3], R::NAN);
        Self { len: 0, position: [[R::ZERO; POINTS]; 3], value: [R::ZERO; POINTS], before }
    }

    /// Adds a point; returns its number.
    fn push(&mut self, [x, y, z]: [R; 3]) -> usize {
        (self.position[0][self.len], self.position[1][self.len], self.position[2][self.len]) = (x, y, z);
        self.len += 1;
        self.len - 1
    }

    fn position_of(&self, i: usize) -> [R; 3] {
        [self.position[0][i], self.position[1][i], self.position[2][i]]
    }
}

impl Shape {
    /// Returns the positions of the samples in a step, as fractions of its length.
    pub(super) fn fractions(self) -> &'static [f64] {
        match self {
            Self::Point => &[0.5],
            Self::Line => &[0.0, 1.0],
            Self::Parabola => &[0.0, 0.5, 1.0],
            Self::Cubic => &Cubic::NODES,
        }
    }
}

impl<R: Real> Profile<R> {
    /// Samples a placed run at the points that the shape needs; returns the number of samples.
    ///
    /// A step that begins where the one before ends shares the sample there: where both are the same point in the kernel's precision,
    /// so that nothing depends on what was sampled before.
    pub(crate) fn sample(&self, chord: &Chord<'_>, run: &mut Run<R>) -> u64 {
        if self.shape == Shape::Point {
            chord.sample(run);
            return run.len() as u64;
        }
        let fractions = self.shape.fractions();
        let mut number = [[0usize; RUN]; 4];
        run.points.len = 0;
        // Number 0 is the last point of the run before.
        let before = run.points.before;
        let first = run.points.push(before.0);
        debug_assert_eq!(first, 0);
        let mut last = 0;
        for j in 0..run.len() {
            for (slot, &fraction) in fractions.iter().enumerate() {
                let position = chord.position(run.steps.begin[j] + fraction * run.steps.length[j]);
                let shared = slot == 0 && run.points.position_of(last) == position;
                last = if shared { last } else { run.points.push(position) };
                number[slot][j] = last;
            }
        }
        let Points { len, position, value, .. } = &mut run.points;
        chord.values(position.each_ref().map(|p| &p[1..*len]), &mut value[1..*len]);
        value[0] = before.1;
        for (values, numbers) in run.profile.iter_mut().zip(&number).take(fractions.len()) {
            for (value, &i) in values.iter_mut().zip(numbers).take(run.steps.len) {
                *value = run.points.value[i];
            }
        }
        run.points.before = (run.points.position_of(last), run.points.value[last]);
        run.points.len as u64 - 1
    }
}
