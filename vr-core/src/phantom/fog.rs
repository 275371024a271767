//! Dense fog: smooth noise that is visible everywhere.

use std::f64::consts::TAU;

use glam::DVec3;

use super::Phantom;
use super::split_mix::SplitMix64;
use crate::transfer::ControlPoint;

const WAVES: usize = 12;
/// Amplitude of each wave: large enough that the fog has thick and thin places, small enough that nothing saturates.
const AMPLITUDE: f64 = 0.5;

/// Random plane waves, squeezed into (0, 1): there is nothing to skip, and nothing to terminate early.
///
/// f(x) = 1 / (1 + e^(−g(x))),  g(x) = Σ a·cos(kᵢ·x + φᵢ), with wavelengths from 0.4 to 2.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::phantom::{Fog, Phantom};
///
/// let fog = Fog::default();
/// let value = fog.value(DVec3::ZERO);
/// assert!(0.0 < value && value < 1.0, "visible everywhere");
/// // No two points differ by more than the slope's bound allows.
/// let near = fog.value(0.01 * DVec3::X);
/// assert!((near - value).abs() <= 0.01 * fog.lipschitz());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Fog {
    waves: [Wave; WAVES],
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Wave {
    /// Radians per world unit.
    k: DVec3,
    phase: f64,
}

impl Default for Fog {
    /// The fog of seed 0.
    fn default() -> Self {
        Self::new(0)
    }
}

impl Fog {
    /// The fog of a seed.
    pub fn new(seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let waves = [(); WAVES].map(|()| {
            // Uniform over the sphere: the height is uniform (Archimedes).
            let (z, azimuth) = (random.between(-1.0, 1.0), random.between(0.0, TAU));
            let ring = (1.0 - z * z).sqrt();
            let direction = DVec3::new(ring * libm::cos(azimuth), ring * libm::sin(azimuth), z);
            Wave { k: direction * (TAU / random.between(0.4, 2.0)), phase: random.between(0.0, TAU) }
        });
        Self { waves }
    }
}

fn logistic(g: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-g))
}

impl Phantom for Fog {
    fn name(&self) -> &'static str {
        "fog"
    }

    fn value(&self, p: DVec3) -> f64 {
        logistic(AMPLITUDE * self.waves.iter().map(|w| libm::cos(w.k.dot(p) + w.phase)).sum::<f64>())
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let f = self.value(p);
        let inner: DVec3 = self.waves.iter().map(|w| w.k * -libm::sin(w.k.dot(p) + w.phase)).sum();
        inner * (AMPLITUDE * f * (1.0 - f))
    }

    fn value_range(&self) -> (f64, f64) {
        let crest = AMPLITUDE * WAVES as f64;
        (logistic(-crest), logistic(crest))
    }

    fn lipschitz(&self) -> f64 {
        // The logistic function is nowhere steeper than 1/4.
        0.25 * AMPLITUDE * self.waves.iter().map(|w| w.k.length()).sum::<f64>()
    }

    fn transfer_points(&self) -> Vec<ControlPoint> {
        let (low, high) = self.value_range();
        vec![ControlPoint::new(low, [0.35, 0.45, 0.70], 0.004), ControlPoint::new(high, [1.0, 0.97, 0.90], 0.08)]
    }
}
