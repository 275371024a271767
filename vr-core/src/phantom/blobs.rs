//! Sparse Gaussian blobs.

use glam::DVec3;

use super::Phantom;
use super::split_mix::SplitMix64;
use crate::transfer::{ControlPoint, inferno};

const COUNT: usize = 64;
/// Blobs keep so far apart, in sums of their standard deviations, that at most one counts anywhere: the ranges of values and
/// slopes below follow from it.
const SEPARATION: f64 = 4.0;

/// Gaussian blobs at random places that do not meet: some 2 % of the box is above a tenth of the largest value, and
/// four fifths are below what 8 bits can tell from zero.
///
/// f(x) = Σ aᵢ·exp(−|x − cᵢ|² / 2σᵢ²)
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::phantom::{Blobs, Phantom};
///
/// let blobs = Blobs::default();
/// let diagonal = (0..1000).map(|i| blobs.value(DVec3::splat(f64::from(i) / 500.0 - 1.0)));
/// assert!(diagonal.filter(|&value| value < 0.1).count() > 800, "mostly empty");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Blobs {
    blobs: Vec<Blob>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Blob {
    center: DVec3,
    amplitude: f64,
    sigma: f64,
}

impl Blob {
    /// exp(−EXPONENT) is 2⁻⁶⁰: beyond it a blob is taken as zero, a jump that no sum of values near 1 can show.
    const CUT_EXPONENT: f64 = 41.6;

    fn value(self, p: DVec3) -> f64 {
        let exponent = p.distance_squared(self.center) / (2.0 * self.sigma * self.sigma);
        if exponent < Self::CUT_EXPONENT { self.amplitude * libm::exp(-exponent) } else { 0.0 }
    }
}

impl Default for Blobs {
    /// The blobs of seed 0.
    fn default() -> Self {
        Self::new(0)
    }
}

impl Blobs {
    /// The blobs of a seed: 64 of them, 0.03 to 0.06 wide (σ) and 0.5 to 1 high, the first one 1 high.
    pub fn new(seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let mut blobs: Vec<Blob> = Vec::with_capacity(COUNT);
        while blobs.len() < COUNT {
            let candidate = Blob {
                center: DVec3::from_array([(); 3].map(|()| random.between(-0.85, 0.85))),
                amplitude: if blobs.is_empty() { 1.0 } else { random.between(0.5, 1.0) },
                sigma: random.between(0.03, 0.06),
            };
            // Ends soon: the spheres kept apart fill a quarter of the box, and random ones pack to over a third.
            let apart = |b: &Blob| b.center.distance(candidate.center) >= SEPARATION * (b.sigma + candidate.sigma);
            if blobs.iter().all(apart) {
                blobs.push(candidate);
            }
        }
        Self { blobs }
    }
}

impl Phantom for Blobs {
    fn name(&self) -> &'static str {
        "blobs"
    }

    fn value(&self, p: DVec3) -> f64 {
        self.blobs.iter().map(|b| b.value(p)).sum()
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        self.blobs.iter().map(|b| (b.center - p) * (b.value(p) / (b.sigma * b.sigma))).sum()
    }

    fn value_range(&self) -> (f64, f64) {
        // All but one blob are at least SEPARATION·σ away.
        let rest: f64 = self.blobs.iter().map(|b| b.amplitude * libm::exp(-SEPARATION * SEPARATION / 2.0)).sum();
        (0.0, 1.0 + rest)
    }

    fn lipschitz(&self) -> f64 {
        // A blob is steepest at a distance of σ, a·e^(−1/2)/σ, and ever less steep further out.
        let slope = |b: &Blob, sigmas: f64| b.amplitude / b.sigma * sigmas * libm::exp(-sigmas * sigmas / 2.0);
        let steepest = self.blobs.iter().map(|b| slope(b, 1.0)).fold(0.0, f64::max);
        steepest + self.blobs.iter().map(|b| slope(b, SEPARATION)).sum::<f64>()
    }

    fn transfer_points(&self) -> Vec<ControlPoint> {
        vec![
            ControlPoint::new(0.08, inferno(0.35), 0.0),
            ControlPoint::new(0.30, inferno(0.55), 0.10),
            ControlPoint::new(0.60, inferno(0.75), 0.40),
            ControlPoint::new(1.00, inferno(0.95), 0.80),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_are_visible_and_most_is_zero_in_8_bits() {
        let blobs = Blobs::default();
        let mut random = SplitMix64::new(5);
        let n = 100_000;
        let values: Vec<f64> =
            (0..n).map(|_| blobs.value(DVec3::from_array([(); 3].map(|()| random.between(-1.0, 1.0))))).collect();
        let share = |count: usize| count as f64 / f64::from(n);
        let visible = share(values.iter().filter(|&&v| v > 0.1).count());
        assert!((0.01..0.04).contains(&visible), "{visible}");
        assert!(share(values.iter().filter(|&&v| v < 0.5 / 255.0).count()) > 0.8);
    }
}
