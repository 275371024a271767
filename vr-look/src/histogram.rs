//! Histogram of the values.

use vr_core::parallel::collect;
use vr_core::{GridVolume, Voxel, with_grid};

use crate::survey::Survey;

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
}

impl Survey {
    /// Histogram of what was sampled, for volumes that are no grids; of NaN and of values outside of the range nothing is counted.
    ///
    /// # Panics
    /// Panics if there are no bins.
    pub fn histogram(&self, range: (f64, f64), bins: usize) -> Histogram {
        let mut counts = vec![0; bins];
        let width = range.1 - range.0;
        for &value in self.lattice.values.iter().filter(|v| (range.0..=range.1).contains(*v)) {
            let place = if width > 0.0 { (value - range.0) / width } else { 0.0 };
            counts[((place * bins as f64) as usize).min(bins - 1)] += 1;
        }
        Histogram { range, counts }
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
    fn samples_of_a_survey_lie_where_the_voxels_do() {
        let blobs = vr_core::phantom::by_name("blobs").unwrap();
        let volume = vr_core::Volume::from(vr_core::phantom::sample::<f32>(&*blobs, [24; 3]).unwrap());
        let of_voxels = Histogram::of(volume.grid().unwrap(), 16).unwrap();
        // So small a grid is sampled at every voxel.
        assert_eq!(Survey::of(&volume).histogram(of_voxels.range, 16).counts, of_voxels.counts);
        let part = Survey::of(&volume).histogram((of_voxels.range.0, of_voxels.range.0), 3);
        assert!(part.counts[0] > 0 && part.counts[1..] == [0, 0]);
    }
}
