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

/// Returns a position, moved by a few roundings into the cell of another if it lies in that cell or on a face of it; as it is if it lies elsewhere.
fn inside_cell<R: Real>(position: [R; 3], other: [R; 3], dims: [usize; 3]) -> [R; 3] {
    let (mut moved, mut is_in_cell) = (position, true);
    for a in 0..3 {
        // Positions are rounded to the precision of the largest index, and distances to that of an eye far off.
        let rounding = R::from_f64((8.0 * R::ROUNDOFF).max(1e-10) * dims[a] as f64);
        let lower = R::from_index(other[a].to_index().min(dims[a] - 2));
        let upper = lower + R::ONE;
        is_in_cell &= position[a] >= lower - rounding && position[a] <= upper + rounding;
        moved[a] = position[a].max(lower + rounding).min(upper - rounding);
    }
    if is_in_cell { moved } else { position }
}

impl<R: Real> Profile<R> {
    /// Samples a placed run at the points that the shape needs; returns the number of samples.
    ///
    /// A step that begins where the one before ends shares the sample there: where both are the same point in the kernel's precision,
    /// so that nothing depends on what was sampled before. Beside missing voxels, a step that ends at the face of its cell ends [inside the
    /// cell](inside_cell): the face itself belongs to a hole behind it, too.
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
        let holed = chord.source.grid().filter(|grid| grid.vacuum_cells().is_some()).map(|grid| grid.dims());
        for j in 0..run.len() {
            let at = |fraction: f64| chord.position::<R>(run.steps.begin[j] + fraction * run.steps.length[j]);
            let middle = holed.map(|dims| (at(0.5), dims));
            for (slot, &fraction) in fractions.iter().enumerate() {
                let position =
                    middle.map_or_else(|| at(fraction), |(middle, dims)| inside_cell(at(fraction), middle, dims));
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
