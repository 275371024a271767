//! A run: the buffer through which a few dozen samples of a ray go from pass to pass.

use vr_core::{IndexRay, Real};

/// Samples in a run. Enough to spread the passes' dispatch thin; few enough that all of a run stays in the first-level cache
/// (2 KiB in f32) and that its sum in the kernel's precision keeps its digits.
pub(crate) const RUN: usize = 32;

/// Consecutive samples of one ray.
///
/// Each pass of the pipeline reads some of the arrays and fills others: positions, then values, then light, then (where something
/// is shaded) gradients. Only the first `len` entries mean anything.
#[derive(Clone, Debug)]
pub(crate) struct Run<R> {
    pub(crate) len: usize,
    /// Distance at which the first sample's step begins.
    pub(crate) begin: f64,
    /// Length of every step but the last.
    pub(crate) step: f64,
    /// Length of the last step.
    pub(crate) last_step: f64,
    /// From a step's begin to its sample, as a fraction of the step.
    pub(crate) offset: f64,
    /// Index-space positions, axis by axis.
    pub(crate) position: [[R; RUN]; 3],
    /// The field in stored units; NaN in vacuum.
    pub(crate) value: [R; RUN],
    /// Light (r, g, b) and opacity of each step.
    pub(crate) light: [[R; 4]; RUN],
    /// Gradients per index step; only where a later pass asks for them.
    pub(crate) gradient: [[R; 3]; RUN],
}

impl<R: Real> Run<R> {
    pub(crate) fn new() -> Self {
        Self {
            len: 0,
            begin: 0.0,
            step: 0.0,
            last_step: 0.0,
            offset: 0.0,
            position: [[R::ZERO; RUN]; 3],
            value: [R::ZERO; RUN],
            light: [[R::ZERO; 4]; RUN],
            gradient: [[R::ZERO; 3]; RUN],
        }
    }

    /// Length of a sample's step.
    pub(crate) fn length(&self, j: usize) -> f64 {
        if j + 1 == self.len { self.last_step } else { self.step }
    }

    /// Distance at which a sample's step begins.
    pub(crate) fn begin_of(&self, j: usize) -> f64 {
        self.begin + j as f64 * self.step
    }

    /// Distance of a sample.
    pub(crate) fn distance(&self, j: usize) -> f64 {
        self.begin_of(j) + self.offset * self.length(j)
    }

    /// Position of a sample in the kernel's precision.
    #[inline(always)]
    pub(crate) fn position_of(&self, j: usize) -> [R; 3] {
        [self.position[0][j], self.position[1][j], self.position[2][j]]
    }

    /// Fills the positions of the samples, clamped into the box.
    ///
    /// The first one is found in f64 and rounded once, the others are whole multiples of a step from it: errors do not add up along
    /// the ray. Rounding may carry a position past a face, and what lies there is not part of the field: hence the clamp.
    pub(crate) fn place(&mut self, ray: &IndexRay, dims: [usize; 3]) {
        let first = ray.at(self.distance(0)).to_array();
        let last = ray.at(self.distance(self.len - 1)).to_array();
        let per_step = (ray.direction * self.step).to_array();
        for axis in 0..3 {
            let (origin, delta) = (R::from_f64(first[axis]), R::from_f64(per_step[axis]));
            let most = R::from_index(dims[axis] - 1);
            let inside = |x: R| x.max(R::ZERO).min(most);
            for (j, x) in self.position[axis][..self.len].iter_mut().enumerate() {
                *x = inside(origin + R::from_index(j) * delta);
            }
            self.position[axis][self.len - 1] = inside(R::from_f64(last[axis]));
        }
    }
}
