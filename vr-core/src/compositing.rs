//! Compositing operators: the quantity along the ray that becomes the pixel.

use crate::error::ParameterError;

/// Operator that makes one pixel of the field along a ray. Each has a reference in `vr-physics`.
///
/// # Examples
/// ```
/// use vr_core::Compositing;
///
/// assert_eq!(Compositing::default(), Compositing::Over);
/// assert!(Compositing::Accumulate { level: 0.5 }.integrates_light());
/// assert!(!Compositing::Maximum.integrates_light());
/// assert!(Compositing::First { threshold: 300.0 }.validate().is_ok());
/// let error = Compositing::Accumulate { level: 1.5 }.validate().unwrap_err();
/// assert_eq!(error.to_string(), "render.level: found 1.5; must be in (0, 1]");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Compositing {
    /// ∫ q e^(−τ) ds and α = 1 − e^(−τ): emission and absorption.
    #[default]
    Over,
    /// The first point where the field reaches a value, the entry point included: (c, 1), shaded if shading is on.
    First {
        /// Calibrated value to reach.
        threshold: f64,
    },
    /// (α(v)·c(v), α(v)) of the mean v of the field over the part of the chord that is not vacuum.
    Average,
    /// (α(v)·c(v), α(v)) of the largest value v.
    Maximum,
    /// (α(v)·c(v), α(v)) of the smallest value v.
    Minimum,
    /// The over integral, cut where 1 − e^(−τ) reaches a level.
    Accumulate {
        /// Opacity to stop at, in (0, 1]; 1 is [`Compositing::Over`].
        level: f64,
    },
}

impl Compositing {
    /// Name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Over => "over",
            Self::First { .. } => "first",
            Self::Average => "average",
            Self::Maximum => "maximum",
            Self::Minimum => "minimum",
            Self::Accumulate { .. } => "accumulate",
        }
    }

    /// True if light is integrated along the ray (rather than one value picked).
    pub fn integrates_light(self) -> bool {
        matches!(self, Self::Over | Self::Accumulate { .. })
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// A threshold that is not finite, a level outside (0, 1].
    pub fn validate(self) -> Result<(), ParameterError> {
        match self {
            Self::First { threshold } if !threshold.is_finite() => {
                Err(ParameterError::new("render.threshold", threshold, "must be finite"))
            }
            Self::Accumulate { level } if !(level > 0.0 && level <= 1.0) => {
                Err(ParameterError::new("render.level", level, "must be in (0, 1]"))
            }
            _ => Ok(()),
        }
    }
}
