//! Run: the buffer through which a few dozen steps of a ray go from pass to pass.

use vr_core::{IndexRay, Real};

use crate::rule::Points;

/// Number of steps in a run: enough to spread the passes' dispatch thin; few enough that all of a run stays in the first-level cache
/// and that its sum in the kernel's precision keeps its digits.
pub(crate) const RUN: usize = 32;

/// Steps of a run, in order along the ray. Where one ends before the next begins, what lies between cannot be seen.
///
/// Only the first `len` entries mean anything, and there is at least one.
#[derive(Clone, Debug)]
pub(crate) struct Steps {
    pub(crate) len: usize,
    /// World distance along the ray at which each begins.
    pub(crate) begin: [f64; RUN],
    /// World length of each; above 0 but for a run that is a single point.
    pub(crate) length: [f64; RUN],
    /// Index of each on the ray's lattice of steps (or in the order of the walk, where there is no lattice).
    pub(crate) number: [u32; RUN],
}

impl Steps {
    pub(crate) fn new() -> Self {
        Self { len: 0, begin: [0.0; RUN], length: [0.0; RUN], number: [0; RUN] }
    }

    /// Appends a step.
    pub(crate) fn push(&mut self, begin: f64, length: f64, number: u32) {
        (self.begin[self.len], self.length[self.len], self.number[self.len]) = (begin, length, number);
        self.len += 1;
    }

    /// Makes the run a single point, of no length.
    pub(crate) fn set_point(&mut self, distance: f64) {
        self.len = 0;
        self.push(distance, 0.0, 0);
    }
}

/// Consecutive steps of one ray, with the results of the passes.
///
/// Each pass reads some of the arrays and fills others: steps, then positions, then values, then light, then (where something is
/// shaded) gradients. Only the first `steps.len` entries mean anything.
#[derive(Clone, Debug)]
pub(crate) struct Run<R> {
    pub(crate) steps: Steps,
    /// Place of a step's sample, as a fraction of the step.
    pub(crate) offset: f64,
    /// Index-space positions of the samples, axis by axis.
    pub(crate) position: [[R; RUN]; 3],
    /// Values of the field in stored units; NaN in vacuum.
    pub(crate) value: [R; RUN],
    /// Values at the points of a step, from front to back, where a rule samples it at several.
    pub(crate) profile: [[R; RUN]; 4],
    /// Positions of the points of the profile.
    pub(crate) points: Points<R>,
    /// Light (r, g, b) and opacity of each step.
    pub(crate) light: [[R; 4]; RUN],
    /// Colours of the places of the samples; white where the volume has none.
    pub(crate) color: [[R; 3]; RUN],
    /// Gradients per index step, filled only where a later pass needs them.
    pub(crate) gradient: [[R; 3]; RUN],
    /// Changes of the gradients over the steps, filled with them; 0 where none is followed.
    pub(crate) turn: [[R; 3]; RUN],
}

impl<R: Real> Run<R> {
    pub(crate) fn new() -> Self {
        Self {
            steps: Steps::new(),
            offset: 0.0,
            position: [[R::ZERO; RUN]; 3],
            value: [R::ZERO; RUN],
            profile: [[R::ZERO; RUN]; 4],
            points: Points::new(),
            light: [[R::ZERO; 4]; RUN],
            color: [[R::ONE; 3]; RUN],
            gradient: [[R::ZERO; 3]; RUN],
            turn: [[R::ZERO; 3]; RUN],
        }
    }

    /// Returns the number of steps in the run.
    pub(crate) fn len(&self) -> usize {
        self.steps.len
    }

    /// Returns the distance of a sample.
    pub(crate) fn distance(&self, j: usize) -> f64 {
        self.steps.begin[j] + self.offset * self.steps.length[j]
    }

    /// Takes over positions that do not lie on the ray.
    pub(crate) fn place_at(&mut self, places: &[[f64; 3]]) {
        for (j, place) in places.iter().enumerate() {
            for axis in 0..3 {
                self.position[axis][j] = R::from_f64(place[axis]);
            }
        }
    }

    /// Returns the position of a sample in the kernel's precision.
    #[inline(always)]
    pub(crate) fn position_of(&self, j: usize) -> [R; 3] {
        [self.position[0][j], self.position[1][j], self.position[2][j]]
    }

    /// Fills the positions of the samples, clamped into the box.
    ///
    /// Each is found in f64 and rounded once: errors do not add up along the ray. Rounding may carry a position past a face, and what
    /// lies there is not part of the field: hence the clamp.
    pub(crate) fn place(&mut self, ray: &IndexRay, dims: [usize; 3]) {
        let len = self.len();
        let (origin, direction) = (ray.origin.to_array(), ray.direction.to_array());
        for axis in 0..3 {
            let max_index = (dims[axis] - 1) as f64;
            for j in 0..len {
                let x = origin[axis] + direction[axis] * self.distance(j);
                self.position[axis][j] = R::from_f64(x.clamp(0.0, max_index));
            }
        }
    }
}
