//! Phase functions.

mod double_henyey_greenstein;
mod henyey_greenstein;
mod rayleigh;
mod tabulated;
#[cfg(test)]
mod tests;

use std::f64::consts::PI;

pub use double_henyey_greenstein::DoubleHenyeyGreenstein;
pub use henyey_greenstein::HenyeyGreenstein;
pub use tabulated::TabulatedPhase;

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
    /// Two lobes.
    DoubleHenyeyGreenstein(DoubleHenyeyGreenstein),
    /// Particles much smaller than the wavelength: p = 3/4 (1 + cos² θ).
    Rayleigh,
    /// Values at some cosines.
    Tabulated(TabulatedPhase),
}

impl PhaseFunction {
    /// The phase function of Henyey and Greenstein with the mean cosine g, −1 < g < 1.
    ///
    /// # Errors
    /// A mean cosine that is not between −1 and 1.
    pub fn henyey_greenstein(g: f64) -> Result<Self, ParameterError> {
        Ok(Self::HenyeyGreenstein(HenyeyGreenstein::new(g)?))
    }

    /// Two lobes of Henyey and Greenstein with the mean cosines g; `share` of the light goes to the first.
    ///
    /// # Errors
    /// A mean cosine that is not between −1 and 1, a share outside of 0 to 1.
    pub fn double_henyey_greenstein(g: [f64; 2], share: f64) -> Result<Self, ParameterError> {
        Ok(Self::DoubleHenyeyGreenstein(DoubleHenyeyGreenstein::new(g, share)?))
    }

    /// The phase function with these values at these cosines, `[cosine, value]`, linear between them; the cosines rise from −1 to 1, and the
    /// values are
    /// normalised.
    ///
    /// # Errors
    /// Same as for [`TabulatedPhase::new`].
    pub fn tabulated(points: &[[f64; 2]]) -> Result<Self, ParameterError> {
        Ok(Self::Tabulated(TabulatedPhase::new(points)?))
    }

    /// p at the cosine of the angle between the directions of travel before and after.
    pub fn value(&self, cosine: f64) -> f64 {
        match self {
            Self::Isotropic => 1.0,
            Self::HenyeyGreenstein(lobe) => lobe.value(cosine),
            Self::DoubleHenyeyGreenstein(lobes) => lobes.value(cosine),
            Self::Rayleigh => rayleigh::value(cosine),
            Self::Tabulated(table) => table.value(cosine),
        }
    }

    /// Mean of the cosine over scattered light.
    pub fn mean_cosine(&self) -> f64 {
        match self {
            Self::Isotropic | Self::Rayleigh => 0.0,
            Self::HenyeyGreenstein(lobe) => lobe.g(),
            Self::DoubleHenyeyGreenstein(lobes) => lobes.mean_cosine(),
            Self::Tabulated(table) => table.mean_cosine(),
        }
    }

    /// Largest value of p at any angle.
    pub fn max_value(&self) -> f64 {
        match self {
            Self::Isotropic => 1.0,
            Self::HenyeyGreenstein(lobe) => lobe.max_value(),
            Self::DoubleHenyeyGreenstein(lobes) => lobes.max_value(),
            Self::Rayleigh => rayleigh::value(1.0),
            Self::Tabulated(table) => table.max_value(),
        }
    }

    /// Cosine of a random angle, of a number uniform in [0, 1): distributed as p.
    pub fn sample_cosine(&self, uniform: f64) -> f64 {
        match self {
            Self::Isotropic => 1.0 - 2.0 * uniform,
            Self::HenyeyGreenstein(lobe) => lobe.sample_cosine(uniform),
            Self::DoubleHenyeyGreenstein(lobes) => lobes.sample_cosine(uniform),
            Self::Rayleigh => rayleigh::sample_cosine(uniform),
            Self::Tabulated(table) => table.sample_cosine(uniform),
        }
    }

    /// A random direction after scattering of light that travels in a unit direction, of two numbers uniform in [0, 1). Its density per solid
    /// angle is
    /// p / 4π.
    pub fn sample(&self, direction: DVec3, uniform: [f64; 2]) -> DVec3 {
        let cosine = self.sample_cosine(uniform[0]);
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (sin, cos) = libm::sincos(2.0 * PI * uniform[1]);
        let (a, b) = direction.any_orthonormal_pair();
        (cosine * direction + sine * (cos * a + sin * b)).normalize()
    }
}
