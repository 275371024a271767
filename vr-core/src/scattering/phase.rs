//! Phase functions.

use std::f64::consts::PI;

use glam::DVec3;

use crate::error::ParameterError;

/// Distribution of the directions of scattered light over the angle θ to the direction in which it came.
///
/// The normalisation is that of radiative transfer: the mean of p over all directions is 1, ∫ p dω / 4π = 1. Light is scattered into a solid angle dω
/// with the probability p dω / 4π.
///
/// # Examples
/// ```
/// use vr_core::scattering::PhaseFunction;
///
/// let forward = PhaseFunction::henyey_greenstein(0.9)?;
/// assert_eq!(forward.mean_cosine(), 0.9);
/// assert!(forward.value(1.0) > 100.0 && forward.value(-1.0) < 0.1);
/// assert_eq!(PhaseFunction::Isotropic.value(0.3), 1.0);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub enum PhaseFunction {
    /// All directions alike: p = 1.
    #[default]
    Isotropic,
    /// A lobe forwards or backwards.
    HenyeyGreenstein(HenyeyGreenstein),
}

impl PhaseFunction {
    /// The phase function of Henyey and Greenstein with the mean cosine g, −1 < g < 1.
    ///
    /// # Errors
    /// A mean cosine that is not between −1 and 1.
    pub fn henyey_greenstein(g: f64) -> Result<Self, ParameterError> {
        Ok(Self::HenyeyGreenstein(HenyeyGreenstein::new(g)?))
    }

    /// p at the cosine of the angle between the directions of travel before and after.
    pub fn value(&self, cosine: f64) -> f64 {
        match self {
            Self::Isotropic => 1.0,
            Self::HenyeyGreenstein(lobe) => lobe.value(cosine),
        }
    }

    /// Mean of the cosine over scattered light.
    pub fn mean_cosine(&self) -> f64 {
        match self {
            Self::Isotropic => 0.0,
            Self::HenyeyGreenstein(lobe) => lobe.g,
        }
    }

    /// Largest value of p at any angle.
    pub fn max_value(&self) -> f64 {
        match self {
            Self::Isotropic => 1.0,
            Self::HenyeyGreenstein(lobe) => lobe.value(lobe.g.signum()),
        }
    }

    /// Cosine of a random angle, of a number uniform in [0, 1): distributed as p.
    pub fn sample_cosine(&self, uniform: f64) -> f64 {
        match self {
            Self::Isotropic => 1.0 - 2.0 * uniform,
            Self::HenyeyGreenstein(lobe) => lobe.sample_cosine(uniform),
        }
    }

    /// A random direction after scattering of light that travels in a unit direction, of two numbers uniform in [0, 1). Its density per solid angle is
    /// p / 4π.
    pub fn sample(&self, direction: DVec3, uniform: [f64; 2]) -> DVec3 {
        let cosine = self.sample_cosine(uniform[0]);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (sin, cos) = libm::sincos(2.0 * PI * uniform[1]);
        let (a, b) = direction.any_orthonormal_pair();
        (cosine * direction + sine * (cos * a + sin * b)).normalize()
    }
}

/// p = (1 − g²) / (1 + g² − 2 g cos θ)^(3/2) (Henyey & Greenstein, "Diffuse radiation in the Galaxy", 1941).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HenyeyGreenstein {
    g: f64,
}

/// Below this, the formula of the sampled angle loses its digits, and light is all but isotropic.
const SMALL: f64 = 1e-4;

impl HenyeyGreenstein {
    /// The lobe with the mean cosine g.
    ///
    /// # Errors
    /// A mean cosine that is not between −1 and 1.
    pub fn new(g: f64) -> Result<Self, ParameterError> {
        let lobe = Self { g };
        if g.abs() < 1.0 {
            Ok(lobe)
        } else {
            Err(ParameterError::new("scattering.phase.g", g, "must be above -1 and below 1"))
        }
    }

    /// The mean cosine.
    pub fn g(self) -> f64 {
        self.g
    }

    /// p at the cosine of an angle.
    pub fn value(self, cosine: f64) -> f64 {
        let g = self.g;
        // 1 + g² − 2 g cos θ, without cancellation near the lobe's peak.
        let denominator = (1.0 - g.abs()).powi(2) + 2.0 * g.abs() * (1.0 - g.signum() * cosine).max(0.0);
        (1.0 - g * g) / (denominator * denominator.sqrt())
    }

    /// Cosine of a random angle, of a number uniform in [0, 1).
    pub fn sample_cosine(self, uniform: f64) -> f64 {
        let g = self.g;
        let isotropic = 1.0 - 2.0 * uniform;
        if g.abs() < SMALL {
            // The first order of the formula below in g.
            return (isotropic + 1.5 * g * (1.0 - isotropic * isotropic)).clamp(-1.0, 1.0);
        }
        let ratio = (1.0 - g * g) / (1.0 + g * isotropic);
        ((1.0 + g * g - ratio * ratio) / (2.0 * g)).clamp(-1.0, 1.0)
    }
}
