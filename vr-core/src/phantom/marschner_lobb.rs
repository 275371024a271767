//! The Marschner-Lobb test signal.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};

use super::Phantom;
use crate::transfer::ControlPoint;

/// Circular ripples of almost constant slope on a sine along z; on a 40³ grid nearly all of its spectrum lies just below the
/// Nyquist frequency, so that a reconstruction filter shows every weakness.
///
/// Marschner & Lobb, "An evaluation of reconstruction filters for volume rendering", IEEE Visualization 1994, section 6:
///
/// ρ(x, y, z) = (1 − sin(πz/2) + α·(1 + ρᵣ(√(x² + y²)))) / (2·(1 + α)),  ρᵣ(r) = cos(2π·f_M·cos(πr/2))
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::phantom::{MarschnerLobb, Phantom};
///
/// // Ripples that are twice as far apart suit a grid of half as many voxels along each side.
/// let coarse = MarschnerLobb { frequency: 3.0, ..MarschnerLobb::default() };
/// assert!(coarse.lipschitz() < MarschnerLobb::default().lipschitz());
/// assert!((0.0..=1.0).contains(&coarse.value(DVec3::new(0.3, 0.1, 0.2))));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarschnerLobb {
    /// Frequency of the ripples, f_M.
    pub frequency: f64,
    /// Their amplitude relative to that of the sine, α.
    pub alpha: f64,
}

impl Default for MarschnerLobb {
    /// The paper's parameters.
    fn default() -> Self {
        Self { frequency: 6.0, alpha: 0.25 }
    }
}

impl MarschnerLobb {
    fn normalisation(&self) -> f64 {
        1.0 / (2.0 * (1.0 + self.alpha))
    }
}

impl Phantom for MarschnerLobb {
    fn name(&self) -> &'static str {
        "marschner-lobb"
    }

    fn value(&self, p: DVec3) -> f64 {
        let r = DVec2::new(p.x, p.y).length();
        let ripple = libm::cos(2.0 * PI * self.frequency * libm::cos(FRAC_PI_2 * r));
        (1.0 - libm::sin(FRAC_PI_2 * p.z) + self.alpha * (1.0 + ripple)) * self.normalisation()
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let radial = DVec2::new(p.x, p.y);
        let r = radial.length();
        let phase = 2.0 * PI * self.frequency * libm::cos(FRAC_PI_2 * r);
        let slope = libm::sin(phase) * PI * PI * self.frequency * libm::sin(FRAC_PI_2 * r);
        // On the axis itself the slope is zero, and the direction does not matter.
        let outward = radial.normalize_or_zero() * (self.alpha * slope);
        DVec3::new(outward.x, outward.y, -FRAC_PI_2 * libm::cos(FRAC_PI_2 * p.z)) * self.normalisation()
    }

    fn value_range(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    fn lipschitz(&self) -> f64 {
        // |∂/∂r| ≤ α·π²·f_M and |∂/∂z| ≤ π/2, before normalisation.
        DVec2::new(self.alpha * PI * PI * self.frequency, FRAC_PI_2).length() * self.normalisation()
    }

    fn transfer_points(&self) -> Vec<ControlPoint> {
        vec![
            ControlPoint::new(0.30, [0.10, 0.25, 0.80], 0.0),
            ControlPoint::new(0.50, [0.30, 0.60, 1.00], 0.35),
            ControlPoint::new(0.70, [0.95, 0.90, 0.80], 0.10),
            ControlPoint::new(1.00, [1.00, 0.55, 0.15], 0.30),
        ]
    }
}
