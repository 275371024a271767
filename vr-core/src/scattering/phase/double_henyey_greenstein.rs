//! Two lobes.

use super::HenyeyGreenstein;
use crate::error::ParameterError;

/// A share of light is scattered by one lobe, the rest by another: most often one forwards and a weaker one backwards
/// (Irvine, "Multiple scattering by large particles", 1965).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleHenyeyGreenstein {
    lobes: [HenyeyGreenstein; 2],
    share: f64,
}

impl DoubleHenyeyGreenstein {
    /// Lobes with the mean cosines g; `share` of the light goes to the first.
    ///
    /// # Errors
    /// A mean cosine that is not between −1 and 1, a share outside of 0 to 1.
    pub fn new(g: [f64; 2], share: f64) -> Result<Self, ParameterError> {
        if !(0.0..=1.0).contains(&share) {
            return Err(ParameterError::new("scattering.phase.share", share, "must be 0 to 1"));
        }
        Ok(Self { lobes: [HenyeyGreenstein::new(g[0])?, HenyeyGreenstein::new(g[1])?], share })
    }

    /// The two lobes.
    pub fn lobes(&self) -> [HenyeyGreenstein; 2] {
        self.lobes
    }

    /// Share of the light that the first lobe scatters.
    pub fn share(&self) -> f64 {
        self.share
    }

    /// p at the cosine of an angle.
    pub fn value(&self, cosine: f64) -> f64 {
        self.mixed(|lobe| lobe.value(cosine))
    }

    /// Mean of the cosine over scattered light.
    pub fn mean_cosine(&self) -> f64 {
        self.mixed(HenyeyGreenstein::g)
    }

    /// Largest value: each lobe is convex over the cosine, so their sum is largest straight on or straight back.
    pub fn max_value(&self) -> f64 {
        self.value(1.0).max(self.value(-1.0))
    }

    /// Cosine of a random angle, of a number uniform in [0, 1): it chooses the lobe, and what is left of it the angle.
    pub fn sample_cosine(&self, uniform: f64) -> f64 {
        if uniform < self.share {
            self.lobes[0].sample_cosine(uniform / self.share)
        } else {
            self.lobes[1].sample_cosine((uniform - self.share) / (1.0 - self.share))
        }
    }

    fn mixed(&self, of: impl Fn(HenyeyGreenstein) -> f64) -> f64 {
        self.share * of(self.lobes[0]) + (1.0 - self.share) * of(self.lobes[1])
    }
}
