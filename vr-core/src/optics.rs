//! Conversions between opacity α, extinction κ and optical depth τ, good from 10⁻³⁰⁰ to infinity.
//!
//! Over a homogeneous length h: τ = κ h, transmittance θ = e^(−τ), α = 1 − θ. Light of emission q gains b = q h w(τ) with the
//! source weight w(τ) = (1 − e^(−τ)) / τ.

use crate::real::Real;

/// κ of a homogeneous slab of opacity `alpha` and thickness `length`: −ln(1 − α) / length; +∞ for α = 1.
#[inline]
pub fn extinction_of_opacity(alpha: f64, length: f64) -> f64 {
    -libm::log1p(-alpha) / length
}

/// α of an optical depth: 1 − e^(−τ).
#[inline]
pub fn opacity_of_depth<R: Real>(tau: R) -> R {
    -((-tau).exp_m1())
}

/// τ of an opacity: −ln(1 − α); +∞ for α = 1.
#[inline]
pub fn depth_of_opacity<R: Real>(alpha: R) -> R {
    -((-alpha).ln_1p())
}

/// The opacity of a slab `ratio` times as thick: 1 − (1 − α)^ratio. Nothing (0) for a ratio of 0, even of an opaque slab.
#[inline]
pub fn opacity_of_thickness<R: Real>(alpha: R, ratio: R) -> R {
    if ratio == R::ZERO {
        return R::ZERO;
    }
    -((ratio * (-alpha).ln_1p()).exp_m1())
}

/// Light and opacity of a homogeneous step `ratio` times as long: light grows with opacity and, where nothing absorbs, with the length.
pub fn step_of_thickness([r, g, b, alpha]: [f64; 4], ratio: f64) -> [f64; 4] {
    // Interpolated, opacity may round past 1.
    let part = opacity_of_thickness(alpha.min(1.0), ratio);
    let grown = if alpha > 0.0 { part / alpha } else { ratio };
    [r * grown, g * grown, b * grown, part]
}

/// The source weight (1 − e^(−τ)) / τ: 1 at τ = 0, 1/τ for large τ, 0 at infinity.
///
/// `expm1` keeps the quotient accurate down to the smallest τ; only 0/0 needs its limit.
#[inline]
pub fn source_weight<R: Real>(tau: R) -> R {
    if tau == R::ZERO { R::ONE } else { opacity_of_depth(tau) / tau }
}

/// Adds the light and opacity of a homogeneous step behind those of a ray so far, up to an opacity `level`; returns true if that is reached.
///
/// Only the step's part before the level counts then, with light in proportion to its opacity. Nothing must be added behind it.
pub fn add_up_to_level(rgba: &mut [f64; 4], [r, g, b, opacity]: [f64; 4], level: f64) -> bool {
    let clear = 1.0 - rgba[3];
    let reached = rgba[3] + clear * opacity >= level;
    // A step of no opacity reaches nothing: the quotient is finite.
    let share = if reached { (level - rgba[3]) / (clear * opacity) } else { 1.0 };
    for (sum, light) in rgba.iter_mut().zip([r, g, b]) {
        *sum += clear * share * light;
    }
    rgba[3] = if reached { level } else { rgba[3] + clear * opacity };
    reached
}

/// Fraction of a homogeneous step of opacity α > 0, behind transparency `clear`, at which opacity reaches a level: x with
/// clear·(1 − α)^x = 1 − level. An opaque step is so from its first point on.
pub fn fraction_to_level(clear: f64, alpha: f64, level: f64) -> f64 {
    (depth_of_opacity(1.0 - (1.0 - level) / clear) / depth_of_opacity(alpha)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holds_from_tiny_to_infinite() {
        for exponent in -300..=2 {
            let tau = 10f64.powi(exponent);
            let alpha = opacity_of_depth(tau);
            // α loses what τ has beyond 1 − 2⁻⁵³: the way back is good to that.
            let slack = 4.0 * f64::EPSILON * (1.0 + libm::exp(tau).min(1e300) / tau.max(1e-300));
            let back = depth_of_opacity(alpha);
            assert!((back - tau).abs() <= tau * slack || (tau > 36.0 && back > 36.0), "{tau} {back}");
            let w = source_weight(tau);
            assert!((w * tau - alpha).abs() <= 2.0 * f64::EPSILON * alpha, "{tau}");
            assert!((0.0..=1.0).contains(&w) && (0.0..=1.0).contains(&alpha));
        }
        assert_eq!(opacity_of_depth(f64::INFINITY), 1.0);
        assert_eq!(source_weight(f64::INFINITY), 0.0);
        assert_eq!(extinction_of_opacity(1.0, 2.0), f64::INFINITY);
        assert_eq!(extinction_of_opacity(1e-30, 0.5), 2e-30);
        assert_eq!(opacity_of_thickness(1.0, 1e-30), 1.0);
        assert_eq!(opacity_of_thickness(1.0, 0.0), 0.0);
        assert_eq!(opacity_of_thickness(1e-30f32, 0.5), 5e-31);
    }

    #[test]
    fn a_level_is_reached_within_a_step() {
        assert!((fraction_to_level(1.0, 0.75, 0.5) - 0.5).abs() < 1e-15);
        assert_eq!(
            [fraction_to_level(0.75, 1.0, 0.5), fraction_to_level(0.5, 0.5, 0.5), fraction_to_level(1.0, 0.5, 0.5)],
            [0.0, 0.0, 1.0]
        );
        let mut rgba = [0.0; 4];
        assert!(!add_up_to_level(&mut rgba, [1.0, 0.0, 2.0, 0.5], 0.625));
        assert!(add_up_to_level(&mut rgba, [1.0, 0.0, 2.0, 0.5], 0.625));
        assert_eq!(rgba, [1.25, 0.0, 2.5, 0.625]);
    }

    #[test]
    fn light_goes_with_opacity_or_with_length() {
        assert_eq!(step_of_thickness([1.0, 2.0, 0.0, 0.75], 0.5), [2.0 / 3.0, 4.0 / 3.0, 0.0, 0.5]);
        assert_eq!(step_of_thickness([1.0, 2.0, 0.0, 0.0], 3.0), [3.0, 6.0, 0.0, 0.0]);
        assert_eq!(step_of_thickness([0.5, 0.5, 0.5, 1.0], 1e-9), [0.5, 0.5, 0.5, 1.0]);
    }

    #[test]
    fn thickness_composes() {
        for alpha in [1e-20, 1e-7, 0.3, 0.999_999] {
            let half = opacity_of_thickness(alpha, 0.5);
            let whole = half + (1.0 - half) * half;
            assert!((whole - alpha).abs() <= 4.0 * f64::EPSILON * alpha, "{alpha}");
        }
    }
}
