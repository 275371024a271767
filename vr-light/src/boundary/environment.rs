//! Light that comes from infinitely far away, from all sides.

use glam::DVec3;
use vr_core::ParameterError;

use super::EnvironmentMap;
use crate::spectrum::{BandGroup, Lanes, Spectrum};

/// Radiance that comes in from infinity.
///
/// # Examples
/// ```
/// use vr_light::{Environment, Spectrum};
///
/// let sky = Environment::Uniform(Spectrum::grey(0.5));
/// assert_eq!(sky, Environment::from([0.5; 1]));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Environment {
    /// The same from all directions.
    Uniform(Spectrum),
    /// A picture of all directions.
    Map(EnvironmentMap),
}

impl Default for Environment {
    /// Darkness.
    fn default() -> Self {
        Self::Uniform(Spectrum::black())
    }
}

impl Environment {
    /// Radiance that is seen in a direction.
    pub(crate) fn lanes(&self, direction: DVec3, group: BandGroup) -> Lanes {
        match self {
            Self::Uniform(radiance) => radiance.lanes(group),
            Self::Map(map) => map.lanes(direction, group),
        }
    }

    /// The map, if directions are worth choosing.
    pub(crate) fn map(&self) -> Option<&EnvironmentMap> {
        if let Self::Map(map) = self { Some(map) } else { None }
    }

    /// Checks the numbers for a number of bands.
    pub(crate) fn validate(&self, bands: usize) -> Result<(), ParameterError> {
        match self {
            Self::Uniform(radiance) => radiance.validate("environment", bands, f64::MAX),
            Self::Map(map) if map.bands() == bands => Ok(()),
            Self::Map(map) => {
                Err(ParameterError::new("environment.bands", map.bands(), "must be as many as the medium has"))
            }
        }
    }
}

impl<const N: usize> From<[f64; N]> for Environment {
    fn from(bands: [f64; N]) -> Self {
        Self::Uniform(Spectrum::new(bands.to_vec()))
    }
}
