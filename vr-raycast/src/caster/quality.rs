//! Quality of a picture, where steps are left to the caster.

use super::Step;

/// Error that automatic steps ([`Step::Auto`]) and automatic rays ([`ImageSampling::Auto`](super::ImageSampling::Auto)) aim at: the one dial between a quick
/// picture and a good one. It is aimed at, not promised; [`Step::ErrorBound`] promises.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Quality {
    /// RMSE of 4·10⁻³, one level of a picture of 8 bits; steps of ½ where no light is followed.
    Draft,
    /// RMSE of 10⁻³, as much as the rounding to 8 bits adds; steps of ⅕ where no light is followed.
    #[default]
    Normal,
    /// RMSE of 2.5·10⁻⁴, a quarter of that; steps of ⅒ where no light is followed.
    Fine,
    /// Any RMSE in (0, 1]; steps in between where no light is followed.
    Rmse(f64),
}

impl Quality {
    /// Those of a fixed RMSE, from the quickest to the best.
    pub const ALL: [Self; 3] = [Self::Draft, Self::Normal, Self::Fine];

    /// Returns the name that options use.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Normal => "normal",
            Self::Fine => "fine",
            Self::Rmse(_) => "rmse",
        }
    }

    /// Returns the RMSE that local steps aim at.
    pub const fn error(self) -> f64 {
        match self {
            Self::Draft => 4e-3,
            Self::Normal => Step::ERROR,
            Self::Fine => 2.5e-4,
            Self::Rmse(error) => error,
        }
    }

    /// Returns the length of uniform steps, as a fraction of the smallest voxel edge.
    pub(crate) fn step(self) -> f64 {
        match self {
            Self::Draft => 0.5,
            Self::Normal => Step::OTHERWISE,
            Self::Fine => 0.1,
            // The error grows with the square of the length.
            Self::Rmse(error) => (Step::OTHERWISE * (error / Step::ERROR).sqrt()).clamp(0.01, 1.0),
        }
    }
}
