//! Errors of a picture that its renderer knows.

/// Error of each component of each pixel, as the renderer that drew them knows it: red, green, blue and opacity, row by row from the top.
///
/// # Examples
/// ```
/// use vr_core::Uncertainty;
///
/// let noise = Uncertainty::StandardError(vec![[0.3, 0.1, 0.0, 0.0], [0.1, 0.1, 0.0, 0.0]]);
/// assert_eq!(noise.largest(), f64::from(0.3f32));
/// assert!((noise.rms() - (0.12f64 / 8.0).sqrt()).abs() < 1e-7);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Uncertainty {
    /// Standard error of a mean over random paths.
    StandardError(Vec<[f32; 4]>),
    /// Upper bound, or an estimate where there is none, of the error of a sum without chance.
    Bound(Vec<[f32; 4]>),
}

impl Uncertainty {
    /// The errors.
    pub fn components(&self) -> &[[f32; 4]] {
        match self {
            Self::StandardError(components) | Self::Bound(components) => components,
        }
    }

    /// Largest error of any component.
    pub fn largest(&self) -> f64 {
        self.components().iter().flatten().fold(0.0, |max, &e| max.max(f64::from(e)))
    }

    /// Root mean square over all components of all pixels.
    pub fn rms(&self) -> f64 {
        let squares: f64 = self.components().iter().flatten().map(|&e| f64::from(e) * f64::from(e)).sum();
        (squares / (4 * self.components().len()).max(1) as f64).sqrt()
    }
}
