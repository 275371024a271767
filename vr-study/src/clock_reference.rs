//! Clock reference: the speed of the machine at the moment.
//!
//! Others use the machine, too, and processors change their clocks: the same frame may take twice as long a second later. A small
//! computation that is always the same, done right before and right after what is timed, tells by how much.

use std::time::{Duration, Instant};

use vr_core::image_order::in_parallel;
use vr_core::{Control, RenderError};

/// Number of values looked up by each piece of work: a third of a millisecond in all on two cores.
const LOOKUPS: usize = 30_000;
/// Number of values of the table: they fit into any second-level cache.
const TABLE: usize = 1 << 14;
/// Number of runs of which the shortest counts, since some are interrupted.
const REPEATS: usize = 3;

/// Computation like that of a renderer: values of a table, interpolated and composited.
pub(crate) struct ClockReference {
    table: Vec<f32>,
}

impl ClockReference {
    pub(crate) fn new() -> Self {
        Self { table: (0..TABLE).map(|i| (i % 251) as f32 / 251.0).collect() }
    }

    /// Times the computation now, on all threads.
    pub(crate) fn take(&self, control: &Control) -> Result<Duration, RenderError> {
        let mut shortest = Duration::MAX;
        for _ in 0..REPEATS {
            let start = Instant::now();
            let pieces = 2 * control.threads() as u32;
            let sums = in_parallel(control, pieces, |piece| self.march(piece))?;
            std::hint::black_box(sums);
            shortest = shortest.min(start.elapsed());
        }
        Ok(shortest)
    }

    fn march(&self, piece: u32) -> f32 {
        let (mut clear, mut light) = (1.0f32, 0.0f32);
        let mut at = piece.wrapping_mul(7919);
        for _ in 0..LOOKUPS {
            // A step of a few hundred values, as from slice to slice.
            at = at.wrapping_add(389);
            let i = at as usize % (TABLE - 1);
            let t = (at >> 14 & 15) as f32 / 16.0;
            let value = self.table[i] + t * (self.table[i + 1] - self.table[i]);
            let alpha = value * 1e-4;
            light += clear * alpha * value;
            clear *= 1.0 - alpha;
        }
        light
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_takes_a_moment_and_gives_the_same() {
        let clock_reference = ClockReference::new();
        assert!(clock_reference.take(&Control::default()).unwrap() > Duration::ZERO);
        assert_eq!(clock_reference.march(3), ClockReference::new().march(3));
        assert!(clock_reference.march(0) > 0.0);
    }
}
