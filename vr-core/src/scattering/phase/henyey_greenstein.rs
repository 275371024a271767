//! One lobe, forwards or backwards.

use crate::error::ParameterError;

/// p = (1 − g²) / (1 + g² − 2 g cos θ)^(3/2) (Henyey & Greenstein, "Diffuse radiation in the Galaxy", 1941).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HenyeyGreenstein {
    g: f64,
}

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
        let g = self.g.abs();
        // 1 − g² and 1 + g² − 2 g cos θ, without cancellation near the lobe's peak.
        let denominator = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - self.g.signum() * cosine).max(0.0);
        (1.0 - g) * (1.0 + g) / (denominator * denominator.sqrt())
    }

    /// Largest value: that of the lobe's peak.
    pub fn max_value(self) -> f64 {
        self.value(self.g.signum())
    }

    /// Cosine of a random angle, of a number uniform in [0, 1); 0 gives the direction straight on.
    pub fn sample_cosine(self, uniform: f64) -> f64 {
        // The inverse of the cumulative distribution, solved for 1 − cos θ: every factor is a sum of positive terms, so that neither a sharp peak
        // nor a g near 0 loses digits.
        let (g, rest) = (self.g, 1.0 - uniform);
        let far = if g < 0.0 { uniform } else { rest };
        let root = (1.0 - g.abs()) + 2.0 * g.abs() * far;
        let scale = (1.0 - g) / root;
        1.0 - (2.0 * uniform * (1.0 + g * rest) * scale * scale).clamp(0.0, 2.0)
    }
}
