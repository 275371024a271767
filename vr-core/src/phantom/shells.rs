//! Thin nested shells.

use glam::DVec3;

use super::Phantom;
use crate::transfer::{ControlPoint, viridis};

/// Four concentric spherical shells, smooth but thin: a step or a block that is too long misses them.
///
/// f(x) = Σ aₖ·exp(−(|x| − rₖ)² / 2σ²), with σ = 0.015 and radii 0.3, 0.5, 0.7, 0.9; the inner shells are the higher ones.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::phantom::{Phantom, Shells};
///
/// let along_x = |radius| Shells.value(radius * DVec3::X);
/// assert!(along_x(0.5) > 0.79, "on the second shell");
/// assert!(along_x(0.6) < 1e-9, "between it and the third");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shells;

const SIGMA: f64 = 0.015;
/// Radius and height of each shell.
const SHELLS: [(f64, f64); 4] = [(0.3, 1.0), (0.5, 0.8), (0.7, 0.6), (0.9, 0.4)];
/// exp(−CUT_EXPONENT) is 2⁻⁶⁰: beyond it a shell is taken as zero, a jump that no sum of values near 1 can show. Since
/// that is well before the centre, |x| having no derivative there does no harm.
const CUT_EXPONENT: f64 = 41.6;

/// Value and derivative of one shell at a distance from the centre.
fn shell((radius, height): (f64, f64), r: f64) -> (f64, f64) {
    let d = (r - radius) / SIGMA;
    let exponent = 0.5 * d * d;
    if exponent >= CUT_EXPONENT {
        return (0.0, 0.0);
    }
    let value = height * libm::exp(-exponent);
    (value, -value * d / SIGMA)
}

impl Phantom for Shells {
    fn name(&self) -> &'static str {
        "shells"
    }

    fn value(&self, p: DVec3) -> f64 {
        let r = p.length();
        SHELLS.iter().map(|&s| shell(s, r).0).sum()
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let r = p.length();
        p.normalize_or_zero() * SHELLS.iter().map(|&s| shell(s, r).1).sum::<f64>()
    }

    fn value_range(&self) -> (f64, f64) {
        (0.0, 1.0)
    }

    fn lipschitz(&self) -> f64 {
        // The slope of the highest shell at a distance of σ. Shells lie 13σ apart: what they add to each other there is cut.
        libm::exp(-0.5) / SIGMA
    }

    fn transfer_points(&self) -> Vec<ControlPoint> {
        vec![
            ControlPoint::new(0.10, viridis(0.20), 0.0),
            ControlPoint::new(0.40, viridis(0.35), 0.10),
            ControlPoint::new(0.60, viridis(0.60), 0.15),
            ControlPoint::new(0.80, viridis(0.80), 0.30),
            ControlPoint::new(1.00, viridis(1.00), 0.70),
        ]
    }
}
