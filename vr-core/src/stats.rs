//! Statistics of a render.

use std::time::Duration;

use crate::clock::Instant;

/// Counts of the work along rays.
///
/// # Examples
/// ```
/// use vr_core::Counts;
///
/// let mut all = Counts::default();
/// for (rays, samples) in [(256, 9000), (10, 300)] {
///     all += Counts { rays, samples, ..Counts::default() };
/// }
/// assert_eq!((all.rays, all.samples), (266, 9300));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Rays that met the volume.
    pub rays: u64,
    /// Samples of the field (or cells solved, for an exact method).
    pub samples: u64,
    /// Samples that empty-space skipping saved.
    pub skipped: u64,
    /// Rays that ended early.
    pub terminated: u64,
    /// Rays for whose error no bound within the promise was found, where one was promised: the correct pixel jumps there, or nearly.
    pub unbounded: u64,
    /// Largest bound that was found for one of those, in units of max(1, the picture's largest magnitude); infinite where one has none at
    /// all, 0 where there are no such rays.
    pub max_unbounded: f64,
    /// Rays that a more precise kernel did again.
    pub repeated: u64,
}

impl Counts {
    /// Counts a ray whose error is not within the promise, and the bound that was found for it; NaN counts as infinite.
    pub fn count_unbounded(&mut self, bound: f64) {
        self.unbounded += 1;
        // Not `max` alone, which takes the other number for NaN.
        self.max_unbounded = self.max_unbounded.max(if bound.is_nan() { f64::INFINITY } else { bound });
    }
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.samples += other.samples;
        self.skipped += other.skipped;
        self.terminated += other.terminated;
        self.unbounded += other.unbounded;
        self.max_unbounded = self.max_unbounded.max(other.max_unbounded);
        self.repeated += other.repeated;
    }
}

/// Counts of a render, and the time of each of its stages.
///
/// # Examples
/// ```
/// use vr_core::RenderStats;
///
/// let mut stats = RenderStats::default();
/// let sum: u64 = stats.time("sum", || (1..=100).sum());
/// assert_eq!((sum, stats.stages[0].0), (5050, "sum"));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderStats {
    /// The work done.
    pub counts: Counts,
    /// Name and wall-clock time of each stage, in order.
    pub stages: Vec<(&'static str, Duration)>,
}

impl RenderStats {
    /// Runs a stage and notes its time.
    pub fn time<T>(&mut self, stage: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.stages.push((stage, start.elapsed()));
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_bound_of_all_parts_is_kept() {
        let mut all = Counts::default();
        for bounds in [&[0.5, 0.25][..], &[], &[0.75]] {
            let mut part = Counts::default();
            bounds.iter().for_each(|&bound| part.count_unbounded(bound));
            all += part;
        }
        assert_eq!((all.unbounded, all.max_unbounded), (3, 0.75));
        all.count_unbounded(f64::NAN);
        all += Counts::default();
        assert_eq!((all.unbounded, all.max_unbounded), (4, f64::INFINITY));
    }
}
