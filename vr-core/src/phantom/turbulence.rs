//! Turbulent gas: evenly spread points whose values follow a smooth function.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::split_mix::SplitMix64;
use crate::parallel::collect;
use crate::point_kernel::PointKernel;
use crate::point_set::PointSet;
use crate::transfer::{ControlPoint, viridis};

const WAVES: usize = 32;
/// Shortest and longest wave.
const LENGTHS: (f64, f64) = (0.4, 2.0);
/// Radius of a support in distances V^(1/3) between neighbours: some 58 of them, as for the cluster.
const REACH: f64 = 2.4;

/// A wave of the logarithm of the density.
struct Wave {
    /// Radians per world unit.
    k: DVec3,
    phase: f64,
    amplitude: f64,
}

/// Density of isothermal turbulence: its logarithm is normally distributed (Vázquez-Semadeni 1994, "Hierarchical structure in nearly
/// pressureless flows as a consequence of self-similar statistics").
///
/// ρ(x) = e^g(x), g(x) = Σ aᵢ cos(kᵢ·x + φᵢ), aᵢ ∝ |kᵢ|^(−1/3) for lengths that are evenly spread over their logarithm: Kolmogorov's
/// spectrum. The standard deviation of g is 1.
struct Density([Wave; WAVES]);

impl Density {
    fn new() -> Self {
        let mut random = SplitMix64::new(0);
        let mut waves = [(); WAVES].map(|()| {
            let (z, azimuth) = (random.between(-1.0, 1.0), random.between(0.0, TAU));
            let ring = (1.0 - z * z).sqrt();
            let direction = DVec3::new(ring * libm::cos(azimuth), ring * libm::sin(azimuth), z);
            let length = LENGTHS.0 * libm::pow(LENGTHS.1 / LENGTHS.0, random.unit());
            Wave { k: direction * (TAU / length), phase: random.between(0.0, TAU), amplitude: libm::cbrt(length) }
        });
        let variance: f64 = waves.iter().map(|w| 0.5 * w.amplitude * w.amplitude).sum();
        waves.iter_mut().for_each(|w| w.amplitude /= variance.sqrt());
        Self(waves)
    }

    fn at(&self, p: DVec3) -> f64 {
        libm::exp(self.0.iter().map(|w| w.amplitude * libm::cos(w.k.dot(p) + w.phase)).sum())
    }
}

/// Gas in the unit ball, every point standing for the same volume.
pub(super) fn points(count: usize) -> Option<PointSet> {
    let in_cube = (1u64..).map(|i| DVec3::new(halton(i, 2), halton(i, 3), halton(i, 5)) * 2.0 - DVec3::ONE);
    let positions: Vec<DVec3> = in_cube.filter(|p| p.length_squared() < 1.0).take(count).collect();
    let density = Density::new();
    let values: Vec<f32> = collect(positions.len(), |i| density.at(positions[i]) as f32);
    let volume = 4.0 / 3.0 * PI / count as f64;
    let reach = (REACH * libm::cbrt(volume)).min(1.0) as f32;
    PointSet::new(positions, vec![reach; count], vec![volume as f32; count], values, PointKernel::CubicSpline).ok()
}

/// The digits of `i` in a base, mirrored at the point: evenly spread over [0, 1) for any number of them (Halton 1964, "Algorithm 247:
/// Radical-inverse quasi-random point sequence").
fn halton(mut i: u64, base: u64) -> f64 {
    let (mut x, mut unit) = (0.0, 1.0);
    while i > 0 {
        unit /= base as f64;
        x += unit * (i % base) as f64;
        i /= base;
    }
    x
}

/// A transfer function that is clear where the gas is thin, and shows filaments and clumps.
pub(super) fn transfer() -> (Vec<ControlPoint>, f64) {
    let points = vec![
        ControlPoint::new(0.8, viridis(0.1), 0.0),
        ControlPoint::new(1.6, viridis(0.35), 0.02),
        ControlPoint::new(3.0, viridis(0.65), 0.15),
        ControlPoint::new(6.0, viridis(0.95), 0.60),
    ];
    (points, 2.0 / 64.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_mirrored() {
        assert_eq!([1, 2, 3, 4].map(|i| halton(i, 2)), [0.5, 0.25, 0.75, 0.125]);
        assert!((halton(5, 3) - 7.0 / 9.0).abs() < 1e-15);
    }

    #[test]
    fn the_field_follows_the_function() {
        let points = points(100_000).unwrap();
        let density = Density::new();
        let (mut off, mut min, mut max) = (0.0f64, f64::INFINITY, 0.0f64);
        for i in 0..20 {
            let at = points.positions()[i] * 0.8;
            let field: f64 = (0..points.count()).map(|k| points.contribution(k, at)).sum();
            off = off.max((field / density.at(at) - 1.0).abs());
            (min, max) = (min.min(field), max.max(field));
        }
        // Smoothing over a support of radius 0.083 takes a tenth or two from waves 0.4 long; without it this would be noise.
        assert!(off < 0.25, "{off}");
        assert!(max / min > 5.0, "{min} to {max}");
    }
}
