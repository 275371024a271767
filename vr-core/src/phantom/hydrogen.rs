//! The electron of a hydrogen atom.

use glam::DVec3;

use super::Phantom;
use crate::transfer::{ControlPoint, inferno};

/// Probability density of the electron of a hydrogen atom in the 3d(z²) state (n, l, m = 3, 2, 0), scaled so that its maximum is 1.
///
/// |ψ|² ∝ (e^(−ρ/3)·(3ζ² − ρ²))², ρ and ζ being |x| and z in Bohr radii, 24 of which are one world unit. See Griffiths &
/// Schroeter, *Introduction to Quantum Mechanics*, 3rd edition 2018, section 4.2.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::phantom::{Hydrogen, Phantom};
///
/// // The density is largest on the z axis, six Bohr radii from the nucleus.
/// let highest = Hydrogen.value(6.0 / 24.0 * DVec3::Z);
/// assert!((highest - 1.0).abs() < 1e-12);
/// assert!(Hydrogen.value(DVec3::ZERO) < 1e-12);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hydrogen;

/// Bohr radii per world unit; on the faces of the box the density is below 0.2 % of its maximum.
const BOHR_RADII: f64 = 24.0;
/// 1 / max |ψ|²: the maximum of 4ρ⁴·e^(−2ρ/3) on the z axis, at ρ = 6, is 5184·e^(−4).
const NORMALISATION: f64 = 54.598_150_033_144_24 / 5184.0;

impl Hydrogen {
    /// ψ, not normalised, at a position in Bohr radii.
    fn psi(p: DVec3) -> f64 {
        libm::exp(-p.length() / 3.0) * (3.0 * p.z * p.z - p.length_squared())
    }
}

impl Phantom for Hydrogen {
    fn name(&self) -> &'static str {
        "hydrogen"
    }

    fn value(&self, p: DVec3) -> f64 {
        let psi = Self::psi(p * BOHR_RADII);
        psi * psi * NORMALISATION
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let p = p * BOHR_RADII;
        let (psi, decay) = (Self::psi(p), libm::exp(-p.length() / 3.0));
        let psi_gradient = DVec3::new(-2.0 * p.x, -2.0 * p.y, 4.0 * p.z) * decay - p.normalize_or_zero() * (psi / 3.0);
        psi_gradient * (2.0 * psi * NORMALISATION * BOHR_RADII)
    }

    fn value_range(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    fn lipschitz(&self) -> f64 {
        // In spherical coordinates, ρ⁴·(3cos²θ − 1)²·e^(−2ρ/3) has
        // |∂/∂ρ| ≤ 4·|4ρ³ − ⅔ρ⁴|·e^(−2ρ/3) ≤ 216·e^(−2), its value on the z axis at ρ = 3, and
        // |∂/ρ∂θ| ≤ max(ρ³·e^(−2ρ/3)) · max|12·cosθ·sinθ·(3cos²θ − 1)| ≤ 4.5³·e^(−3) · 6.74, at cos²θ = (11 + √73)/24.
        let radial = 216.0 * libm::exp(-2.0);
        let polar = 91.125 * libm::exp(-3.0) * 6.74;
        (radial * radial + polar * polar).sqrt() * NORMALISATION * BOHR_RADII
    }

    /// The point nearest to the nucleus, where |x| has a kink: through the nucleus itself the fifth derivative jumps, and
    /// close by it is large.
    fn breakpoints(&self, origin: DVec3, direction: DVec3, out: &mut Vec<f64>) {
        out.push(-origin.dot(direction) / direction.length_squared());
    }

    fn transfer_points(&self) -> Vec<ControlPoint> {
        vec![
            ControlPoint::new(0.004, inferno(0.30), 0.0),
            ControlPoint::new(0.05, inferno(0.45), 0.04),
            ControlPoint::new(0.30, inferno(0.70), 0.20),
            ControlPoint::new(1.00, inferno(1.00), 0.70),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_one_at_the_likeliest_place_and_zero_on_the_cone() {
        assert!((Hydrogen.value(DVec3::Z * 6.0 / BOHR_RADII) - 1.0).abs() < 1e-14);
        assert!(Hydrogen.value(DVec3::new(2f64.sqrt(), 0.0, 1.0) * 0.2) < 1e-30);
        let (_, corner) = Hydrogen.domain();
        assert!(Hydrogen.value(DVec3::Z * corner.z) < 2e-3);
    }
}
