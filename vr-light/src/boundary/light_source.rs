//! Lights without size.

use glam::DVec3;
use vr_core::scattering::PointLight;
use vr_core::{Light, ParameterError};

use crate::spectrum::Spectrum;

/// A light without size. It is not seen itself.
///
/// A light of the colour L gives the irradiance π L: a white Lambertian surface that faces it has the radiance L, as in the shading of scenes.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::Light;
/// use vr_light::LightSource;
///
/// assert!(matches!(LightSource::from(Light::default()), LightSource::Headlight { .. }));
/// let sun = Light { direction: Some(DVec3::Y), color: [1.0; 3] };
/// assert!(matches!(LightSource::from(sun), LightSource::Directional { .. }));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum LightSource {
    /// A light at infinity.
    Directional {
        /// World vector towards the light, of any length.
        towards: DVec3,
        /// L.
        color: Spectrum,
    },
    /// A point that shines in all directions: the irradiance at the distance d is π L / d².
    Point {
        /// Its position.
        at: DVec3,
        /// L.
        color: Spectrum,
    },
    /// A light at infinity behind the eye, which shines along each primary ray.
    Headlight {
        /// L.
        color: Spectrum,
    },
}

/// Light that comes to a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Illumination {
    /// Unit vector towards the light.
    pub towards: DVec3,
    /// Distance of the light.
    pub distance: f64,
    /// Irradiance of a unit of colour across its direction.
    pub irradiance: f64,
}

impl LightSource {
    /// L.
    pub fn color(&self) -> &Spectrum {
        match self {
            Self::Directional { color, .. } | Self::Point { color, .. } | Self::Headlight { color } => color,
        }
    }

    /// Light that comes to a point, of a path whose primary ray has a direction; `None` at the very place of the light.
    pub(crate) fn illuminate(&self, at: DVec3, primary: DVec3) -> Option<Illumination> {
        let pi = std::f64::consts::PI;
        let far = |towards: DVec3| Some(Illumination { towards, distance: f64::INFINITY, irradiance: pi });
        match self {
            Self::Directional { towards, .. } => far(towards.normalize()),
            Self::Headlight { .. } => far(-primary),
            Self::Point { at: lamp, .. } => {
                let to = lamp - at;
                let distance = to.length();
                let irradiance = pi / (distance * distance);
                irradiance.is_finite().then(|| Illumination { towards: to / distance, distance, irradiance })
            }
        }
    }

    /// Checks the numbers for a number of bands.
    pub(crate) fn validate(&self, field: &str, bands: usize) -> Result<(), ParameterError> {
        self.color().validate(&format!("{field}.color"), bands, f64::MAX)?;
        match self {
            Self::Directional { towards, .. } if towards.try_normalize().is_none() => {
                Err(ParameterError::new(format!("{field}.direction"), towards, "must be finite and not zero"))
            }
            Self::Point { at, .. } if !at.is_finite() => {
                Err(ParameterError::new(format!("{field}.position"), at, "must be finite"))
            }
            _ => Ok(()),
        }
    }
}

impl From<PointLight> for LightSource {
    fn from(light: PointLight) -> Self {
        Self::Point { at: light.position, color: light.color.into() }
    }
}

impl From<Light> for LightSource {
    fn from(light: Light) -> Self {
        let color = light.color.into();
        match light.direction {
            Some(towards) => Self::Directional { towards, color },
            None => Self::Headlight { color },
        }
    }
}
