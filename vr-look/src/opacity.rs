//! Share of each value that is shown, before the exposure: a number from 0 to 1 for each bin of a scale.

use crate::lattice::Lattice;
use crate::scale::{BINS, Scale};

/// Shares of opacity, and the place from which on values are shown.
pub(crate) struct Shares {
    pub of_bins: Vec<f64>,
    pub begin: f64,
}

/// Counts of samples, and the mean gradient magnitude, in each bin.
pub(crate) struct Histogram {
    counts: Vec<f64>,
    changes: Vec<f64>,
}

impl Histogram {
    pub fn new(lattice: &Lattice, scale: Scale) -> Self {
        let (mut counts, mut changes) = (vec![0.0; BINS], vec![0.0; BINS]);
        for (&value, &change) in lattice.values.iter().zip(&lattice.changes).filter(|(v, _)| !v.is_nan()) {
            let bin = scale.bin(value);
            counts[bin] += 1.0;
            changes[bin] += change;
        }
        Self { counts, changes }
    }

    /// The fullest bin: the background, where there is one.
    fn mode(&self) -> usize {
        (0..BINS).max_by(|&a, &b| self.counts[a].total_cmp(&self.counts[b]).then(b.cmp(&a))).unwrap_or(0)
    }

    /// The last bin of the lower of two classes that differ most (Otsu 1979: the largest variance between the two).
    fn threshold(&self) -> usize {
        let total: f64 = self.counts.iter().sum();
        let mean = self.counts.iter().enumerate().map(|(i, n)| i as f64 * n).sum::<f64>();
        let (mut below, mut moment, mut best) = (0.0, 0.0, (0.0, 0));
        for (i, n) in self.counts.iter().enumerate() {
            below += n;
            moment += i as f64 * n;
            let above = total - below;
            if below > 0.0 && above > 0.0 {
                let difference = moment / below - (mean - moment) / above;
                let variance = below * above * difference * difference;
                if variance > best.0 {
                    best = (variance, i);
                }
            }
        }
        best.1
    }

    /// The bin from which on values are the foreground: half-way from the background to the threshold, so that the outer half of a
    /// boundary's slope is shown, too.
    fn begin(&self) -> (f64, f64) {
        let (mode, threshold) = (self.mode() as f64, self.threshold() as f64);
        let begin = if mode < threshold { mode + 0.5 * (threshold - mode) } else { 0.5 * threshold };
        (begin, threshold)
    }

    /// Mean gradient magnitude at each bin, smoothed over neighbours, from 0 to 1 among those from `begin` on. Bins of a few samples count
    /// less.
    fn boundaries(&self, begin: usize) -> Vec<f64> {
        /// From so many samples on a bin's mean is sure.
        const SURE: f64 = 50.0;
        let sure: Vec<f64> = self.counts.iter().map(|n| n.min(SURE)).collect();
        let weighted: Vec<f64> = (0..BINS).map(|i| self.changes[i] / self.counts[i].max(1.0) * sure[i]).collect();
        let (sums, weights) = (smoothed(&weighted), smoothed(&sure));
        let means: Vec<f64> = sums.iter().zip(&weights).map(|(s, w)| s / w.max(1e-9)).collect();
        let largest = means[begin..].iter().fold(0.0, |a: f64, &b| a.max(b));
        means.iter().map(|m| if largest > 0.0 { (m / largest).min(1.0) } else { 1.0 }).collect()
    }

    /// Shares of a field with boundaries: they grow with the value and, the more, with the gradient there.
    pub fn of_boundaries(&self) -> Shares {
        let (begin, threshold) = self.begin();
        let boundaries = self.boundaries((begin as usize).min(BINS - 1));
        // Soft at the outside: full at half as far again as the threshold.
        let rise = 1.5 * (threshold - begin).max(1.0);
        let of_bins = (0..BINS).map(|i| {
            let above = i as f64 - begin;
            let up = (above / (BINS as f64 - begin).max(1.0)).clamp(0.0, 1.0);
            (above / rise).clamp(0.0, 1.0) * (0.1 + 0.9 * up) * (0.15 + 0.85 * boundaries[i] * boundaries[i])
        });
        Shares { of_bins: of_bins.collect(), begin: begin / BINS as f64 }
    }

    /// Shares of a field on a logarithmic scale: they grow with the place alone.
    pub fn of_tail(&self) -> Shares {
        let begin = self.begin().0.min(0.5 * BINS as f64) / BINS as f64;
        let of_bins = (0..BINS).map(|i| {
            let up = ((Scale::middle(i) - begin) / (1.0 - begin)).clamp(0.0, 1.0);
            up * up
        });
        Shares { of_bins: of_bins.collect(), begin }
    }

    /// Mean change of the field per voxel where it is shown, as a part of the scale.
    pub fn sharpness(&self, shares: &[f64], scale: Scale) -> f64 {
        let width = (scale.value(1.0) - scale.value(0.0)).abs();
        let sum: f64 = (0..BINS).map(|i| shares[i] * self.changes[i]).sum();
        let weight: f64 = (0..BINS).map(|i| shares[i] * self.counts[i]).sum();
        if weight > 0.0 && width > 0.0 { sum / weight / width } else { 0.0 }
    }
}

/// Shares of values of both signs: nothing at zero, which is in the middle, and more with the magnitude.
pub(crate) fn of_magnitude() -> Shares {
    /// Magnitudes below this part of the largest are clear.
    const CLEAR: f64 = 0.08;
    let of_bins = (0..BINS).map(|i| {
        let magnitude = (2.0 * Scale::middle(i) - 1.0).abs();
        libm::pow(((magnitude - CLEAR) / (1.0 - CLEAR)).max(0.0), 1.5)
    });
    Shares { of_bins: of_bins.collect(), begin: 0.0 }
}

/// Shares of opacities: as they are.
pub(crate) fn of_place() -> Shares {
    Shares { of_bins: (0..BINS).map(Scale::middle).collect(), begin: 0.0 }
}

/// Mean over neighbours with the weights of a Gaussian of four bins; the ends go on as they are.
fn smoothed(bins: &[f64]) -> Vec<f64> {
    const RADIUS: isize = 12;
    let weight = |d: isize| libm::exp(-0.5 * (d as f64 / 4.0) * (d as f64 / 4.0));
    let total: f64 = (-RADIUS..=RADIUS).map(weight).sum();
    let at = |i: isize| bins[i.clamp(0, bins.len() as isize - 1) as usize];
    (0..bins.len() as isize).map(|i| (-RADIUS..=RADIUS).map(|d| weight(d) * at(i + d)).sum::<f64>() / total).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn histogram(counts: impl Fn(usize) -> (f64, f64)) -> Histogram {
        let (counts, changes) = (0..BINS).map(counts).map(|(n, c)| (n, n * c)).unzip();
        Histogram { counts, changes }
    }

    #[test]
    fn background_is_clear_and_boundaries_are_not() {
        // Air in bins 0 to 9, tissue in 100 to 120, and what is between at their boundary.
        let scan = histogram(|i| match i {
            0..10 => (10_000.0, 0.1),
            100..=120 => (3_000.0, 0.5),
            10..100 => (20.0, 30.0),
            _ => (0.0, 0.0),
        });
        assert!((10..100).contains(&scan.threshold()), "{}", scan.threshold());
        let shares = scan.of_boundaries();
        assert!(shares.of_bins[..5].iter().all(|&s| s == 0.0));
        assert!(shares.of_bins[90] > 2.0 * shares.of_bins[115], "{:?}", &shares.of_bins[80..120]);
        let scale = Scale::Linear { low: 0.0, high: 256.0 };
        assert!(scan.sharpness(&shares.of_bins, scale) > 1e-3);
    }

    #[test]
    fn one_value_alone_is_shown() {
        let constant = histogram(|i| if i == 128 { (1000.0, 0.0) } else { (0.0, 0.0) });
        assert!(constant.of_boundaries().of_bins[128] > 0.0);
        assert!(constant.of_tail().of_bins[128] > 0.0);
        assert!(of_magnitude().of_bins[BINS / 2] == 0.0 && of_magnitude().of_bins[0] > 0.9);
    }
}
