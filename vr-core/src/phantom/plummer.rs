//! A star cluster: strongly clustered points.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::split_mix::SplitMix64;
use crate::point_kernel::PointKernel;
use crate::point_set::PointSet;
use crate::transfer::{ControlPoint, inferno};

/// The radius a of the core.
const CORE: f64 = 0.08;
/// Part of the cluster's mass, which is 1, that is drawn: all within seven core radii. The rest would reach to infinity.
const DRAWN: f64 = 0.97;
/// Radius of a support in distances (m/ρ)^(1/3) between neighbours: some 58 of them, as the cubic spline of smoothed particle
/// hydrodynamics wants (Price 2012, "Smoothed particle hydrodynamics and magnetohydrodynamics").
const REACH: f64 = 2.4;
/// Largest radius: reached only where points are so few that there is no field to speak of.
const MAX_REACH: f64 = 0.5;

/// Density of the model of Plummer 1911, "On the problem of distribution in globular star clusters":
/// ρ(r) = 3/(4π a³) · (1 + r²/a²)^(−5/2).
fn density(r: f64) -> f64 {
    let squared = 1.0 + r * r / (CORE * CORE);
    3.0 / (4.0 * PI * CORE * CORE * CORE) / (squared * squared * squared.sqrt())
}

/// Stars of equal mass, whose field is the density; each reaches as far as the density of the model asks for.
pub(super) fn points(count: usize) -> Option<PointSet> {
    let mut random = SplitMix64::new(0);
    let mass = DRAWN / count as f64;
    let (mut positions, mut radii) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for _ in 0..count {
        // Within r there is the mass (1 + a²/r²)^(−3/2); solved for r.
        let inside = DRAWN * random.unit();
        let r = CORE / (libm::pow(inside, -2.0 / 3.0) - 1.0).sqrt();
        // Uniform over the sphere: the height is uniform (Archimedes).
        let (z, azimuth) = (random.between(-1.0, 1.0), random.between(0.0, TAU));
        let ring = (1.0 - z * z).sqrt();
        positions.push(DVec3::new(ring * libm::cos(azimuth), ring * libm::sin(azimuth), z) * r);
        radii.push((REACH * libm::cbrt(mass / density(r))).min(MAX_REACH) as f32);
    }
    PointSet::new(positions, radii, vec![mass as f32; count], vec![1.0; count], PointKernel::CubicSpline).ok()
}

/// A faint halo, and a core that is 500 times as dense as the mean of the ball around it.
pub(super) fn transfer() -> (Vec<ControlPoint>, f64) {
    let points = vec![
        ControlPoint::new(0.05, inferno(0.20), 0.0),
        ControlPoint::new(0.5, inferno(0.35), 0.006),
        ControlPoint::new(5.0, inferno(0.55), 0.03),
        ControlPoint::new(50.0, inferno(0.75), 0.15),
        ControlPoint::new(500.0, inferno(0.97), 0.60),
    ];
    (points, 0.25 * CORE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_the_mass_is_within_the_half_mass_radius() {
        let points = points(20_000).unwrap();
        // Where (1 + a²/r²)^(−3/2) = ½.
        let half = CORE / (libm::pow(0.5, -2.0 / 3.0) - 1.0).sqrt();
        let inside = points.positions().iter().filter(|p| p.length() < half).count() as f64 / 20_000.0;
        // Of all the mass, not only what is drawn; the standard deviation of 20 000 draws is 0.0035.
        assert!((inside - 0.5 / DRAWN).abs() < 0.015, "{inside}");
    }

    #[test]
    fn the_field_is_the_density() {
        let points = points(20_000).unwrap();
        for r in [0.0, 0.03, 0.1, 0.3] {
            let mean = |directions: &[DVec3]| {
                let field = |d: &DVec3| (0..points.count()).map(|k| points.contribution(k, *d * r)).sum::<f64>();
                directions.iter().map(field).sum::<f64>() / directions.len() as f64
            };
            let found = mean(&[DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z]);
            // Noise of some 58 neighbours, six of them averaged: 10 %.
            assert!((found / density(r) - 1.0).abs() < 0.2, "{found} for {} at {r}", density(r));
        }
    }

    #[test]
    fn radii_spread_widely() {
        let points = points(10_000).unwrap();
        let (low, high) = points.radii().iter().fold((f32::MAX, 0.0f32), |(l, h), &r| (l.min(r), h.max(r)));
        assert!(high / low > 20.0, "{low} to {high}");
    }
}
