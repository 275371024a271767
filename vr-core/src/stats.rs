//! What a render did.

use std::time::{Duration, Instant};

/// Counts of the work along rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays that met the volume.
    pub rays: u64,
    /// Samples of the field (or cells solved, for an exact method).
    pub samples: u64,
    /// Samples that empty-space skipping saved.
    pub skipped: u64,
    /// Rays that ended early.
    pub terminated: u64,
    /// Rays whose error no bound within the promise was found for, where one was promised: the truth jumps there, or nearly.
    pub unbounded: u64,
    /// Rays that a more precise kernel did again.
    pub repeated: u64,
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.samples += other.samples;
        self.skipped += other.skipped;
        self.terminated += other.terminated;
        self.unbounded += other.unbounded;
        self.repeated += other.repeated;
    }
}

/// Counts of a render, and the time of each of its stages.
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
