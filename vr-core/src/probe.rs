//! Record of a renderer's work on one pixel, step by step.

use crate::optics::add_up_to_level;

/// Record of a renderer's steps along the ray through a pixel's centre: the first thing to look at where a pixel is wrong.
///
/// Every kind of renderer composites steps, each of some light and some transparency: samples of a ray, slices, the voxels of a sheared
/// slice, footprints of splats. Here they are, front to back, in the numbers that the renderer itself worked with.
///
/// # Examples
/// ```
/// use vr_core::{Probe, ProbedStep};
///
/// let step = |begin, light| {
///     ProbedStep { begin, length: 1.0, samples: Vec::new(), transparency: 0.5, light: [light; 3] }
/// };
/// let steps = vec![step(4.0, 0.2), step(5.0, 0.8)];
/// let probe = Probe { rgba: [0.6, 0.6, 0.6, 0.75], depth: 5.0, own_kernel: true, ended_early: false, steps };
/// let [.., behind] = probe.running(1.0)[..] else { unreachable!() };
/// assert!((behind[0] - 0.6).abs() < 1e-15 && behind[3] == 0.75);
/// assert_eq!(probe.steps[0].end(), probe.steps[1].begin);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Result of the ray: premultiplied linear RGBA, as in a [`Frame`](crate::Frame).
    pub rgba: [f32; 4],
    /// World distance along the ray to what is seen; +∞ where there is nothing.
    pub depth: f32,
    /// True where the kernel that drew the ray is the one that draws frames: `rgba` is the frame's pixel then, bit for bit. False where
    /// it is another one (frames may be drawn by vector code) that draws the same to rounding.
    pub own_kernel: bool,
    /// True if steps behind the last one were left out, for they could not be seen any more.
    pub ended_early: bool,
    /// Steps, front to back. Between two of them there may be a gap, in which the renderer knew that nothing can be seen.
    pub steps: Vec<ProbedStep>,
}

/// One step of a ray.
///
/// # Examples
/// ```
/// use vr_core::ProbedStep;
///
/// let step = ProbedStep { begin: 4.0, length: 0.5, samples: Vec::new(), transparency: 0.25, light: [0.0; 3] };
/// assert_eq!(step.end(), 4.5);
/// assert!((step.depth() - 4f64.ln()).abs() < 1e-15);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ProbedStep {
    /// World distance along the ray at which it begins.
    pub begin: f64,
    /// World length; 0 for a single point that was looked at.
    pub length: f64,
    /// Samples of the field for it, front to back: at least one, or several by rules that follow the field through the step.
    pub samples: Vec<ProbedSample>,
    /// Transparency θ, in [0, 1]; 1 where the compositing picks a value and integrates no light.
    pub transparency: f64,
    /// Light b that it sends out at its front, shaded; none where the compositing integrates no light.
    pub light: [f64; 3],
}

/// One sample of the field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbedSample {
    /// World distance along the ray.
    pub at: f64,
    /// Index-space position as the renderer used it, in its own precision. It need not lie on the ray.
    pub index: [f64; 3],
    /// The calibrated value; NaN in vacuum.
    pub value: f64,
}

impl ProbedStep {
    /// World distance along the ray at which it ends.
    pub fn end(&self) -> f64 {
        self.begin + self.length
    }

    /// Optical depth −ln θ; +∞ where it is opaque.
    pub fn depth(&self) -> f64 {
        -libm::log(self.transparency)
    }
}

impl Probe {
    /// Premultiplied RGBA behind each step, summed in f64: C ← C + (1 − A)·b, A ← A + (1 − A)·(1 − θ).
    ///
    /// If A reaches `level` inside a step, only the step's part before it counts, with light in proportion to it, and nothing behind
    /// ([`Compositing::Accumulate`](crate::Compositing::Accumulate)); `level` is 1 under over. The renderer's own sum differs by its rounding.
    pub fn running(&self, level: f64) -> Vec<[f64; 4]> {
        let (mut rgba, mut reached) = ([0.0; 4], false);
        let sums = self.steps.iter().map(|step| {
            let [r, g, b] = step.light;
            reached = reached || add_up_to_level(&mut rgba, [r, g, b, 1.0 - step.transparency], level);
            rgba
        });
        sums.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn probe(steps: &[(f64, f64)]) -> Probe {
        let step = |(k, &(transparency, light)): (usize, &(f64, f64))| ProbedStep {
            begin: k as f64,
            length: 1.0,
            samples: Vec::new(),
            transparency,
            light: [light, 0.0, 2.0 * light],
        };
        let steps = steps.iter().enumerate().map(step).collect();
        Probe { rgba: [0.0; 4], depth: f32::INFINITY, own_kernel: true, ended_early: false, steps }
    }

    #[test]
    fn light_is_dimmed_by_what_is_before_it() {
        let sums = probe(&[(0.5, 1.0), (0.25, 1.0), (0.0, 8.0), (0.5, 1.0)]).running(1.0);
        let want = [[1.0, 0.0, 2.0, 0.5], [1.5, 0.0, 3.0, 0.875], [2.5, 0.0, 5.0, 1.0], [2.5, 0.0, 5.0, 1.0]];
        assert_eq!(sums, want);
        assert_eq!(probe(&[(0.5, 1.0)]).steps[0].end(), 1.0);
        assert_eq!(probe(&[(0.0, 1.0)]).steps[0].depth(), f64::INFINITY);
    }

    #[test]
    fn a_level_cuts_the_step_that_reaches_it() {
        let sums = probe(&[(1.0, 0.0), (0.5, 1.0), (0.5, 1.0), (0.5, 1.0)]).running(0.625);
        let want = [[0.0; 4], [1.0, 0.0, 2.0, 0.5], [1.25, 0.0, 2.5, 0.625], [1.25, 0.0, 2.5, 0.625]];
        assert_eq!(sums, want);
    }
}
