//! Steps that are known by their numbers.

use std::ops::Range;

use crate::run::Steps;

/// Steps of a ray from its begin to its end, each known by its number.
pub(crate) trait StepSequence {
    /// Returns the numbers of all steps; there is at least one.
    fn numbers(&self) -> Range<u32>;

    /// Returns the distance at which a step begins.
    fn begin(&self, number: u32) -> f64;

    /// Appends steps to a run.
    fn push(&self, numbers: Range<u32>, steps: &mut Steps);

    /// Returns the steps that an interval of the ray touches.
    fn steps_in(&self, begin: f64, end: f64) -> Range<u32>;
}
