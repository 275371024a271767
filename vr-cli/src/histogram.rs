//! Histogram of the values, and a drawing of it for a terminal.

use vr_core::parallel::collect;
use vr_core::{GridVolume, Voxel, with_grid};

use crate::number;

/// Histogram of equal bins from the smallest to the largest finite value of a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Calibrated values that the bins lie between.
    pub range: (f64, f64),
    /// Number of voxels in each bin.
    pub counts: Vec<u64>,
}

impl Histogram {
    /// Counts every voxel of a volume; `None` where none is finite.
    pub fn of(volume: &GridVolume, bins: usize) -> Option<Self> {
        let range = volume.value_range()?;
        let (low, high) = volume.value_stats().range?;
        let (low, high) = (f64::from(low), f64::from(high));
        let mut counts = with_grid!(volume.values(), g => counts(g.samples(), low, high, bins));
        if volume.calibration().slope < 0.0 {
            counts.reverse();
        }
        Some(Self { range, counts })
    }

    /// A histogram of the volume that values take up, from its shares in equal bins over their range. Whatever occurs at all counts.
    pub fn of_shares(range: [f64; 2], shares: &[f64]) -> Self {
        /// Number that the whole volume counts.
        const WHOLE: f64 = 1e6;
        Self { range: (range[0], range[1]), counts: shares.iter().map(|share| (share * WHOLE).ceil() as u64).collect() }
    }

    /// Draws the bins as columns, as high as the logarithm of their counts, above the ends of the range.
    pub fn draw(&self, rows: usize) -> String {
        /// Characters of columns, each an eighth of a row higher than the one before.
        const BLOCKS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
        let height = |count: u64| (1.0 + count as f64).ln();
        let max_height = self.counts.iter().copied().map(height).fold(0.0, f64::max);
        let eighths = |count: u64| {
            let exact = height(count) / max_height * (8 * rows) as f64;
            // Whatever occurs at all is seen.
            (exact.round() as usize).max(usize::from(count > 0))
        };
        let mut text = String::new();
        for row in (0..rows).rev() {
            let line: String = self.counts.iter().map(|&c| BLOCKS[eighths(c).saturating_sub(8 * row).min(8)]).collect();
            text += &format!("  {}\n", line.trim_end());
        }
        let (low, high) = (number::value(self.range.0), number::value(self.range.1));
        let gap = self.counts.len().saturating_sub(low.chars().count());
        text + &format!("  {low}{high:>gap$}\n")
    }
}

fn counts<T: Voxel>(samples: &[T], low: f64, high: f64, bins: usize) -> Vec<u64> {
    /// Voxels that a thread takes at once: some milliseconds of work.
    const PART: usize = 1 << 20;
    let scale = if high > low { bins as f64 / (high - low) } else { 0.0 };
    let parts: Vec<&[T]> = samples.chunks(PART).collect();
    let of_parts = collect(parts.len(), |part| {
        let mut counts = vec![0; bins];
        for sample in parts[part].iter().filter(|s| !s.is_missing()) {
            let bin = ((f64::from(sample.to_f32()) - low) * scale) as usize;
            counts[bin.min(bins - 1)] += 1;
        }
        counts
    });
    let mut counts = vec![0; bins];
    for (bin, count) in of_parts.iter().flat_map(|counts| counts.iter().enumerate()) {
        counts[bin] += count;
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_up_to_both_ends() {
        assert_eq!(counts(&[0u8, 1, 2, 3, 4, 5, 6, 7, 8], 0.0, 8.0, 4), [2, 2, 2, 3]);
        assert_eq!(counts(&[7u8; 5], 7.0, 7.0, 3), [5, 0, 0]);
        assert_eq!(counts(&[f32::NAN, 1.0], 1.0, 1.0, 1), [1]);
        let many: Vec<u8> = (0..3 << 20).map(|i| (i % 3) as u8).collect();
        assert_eq!(counts(&many, 0.0, 2.0, 3), [1 << 20; 3]);
    }

    #[test]
    fn draws_what_occurs_once_and_what_occurs_often() {
        let h = Histogram { range: (0.0, 255.0), counts: vec![1_000_000, 0, 1] };
        let drawing = h.draw(2);
        let lines: Vec<&str> = drawing.lines().collect();
        assert_eq!(lines, ["  █", "  █ ▁", "  0255"]);
    }
}
