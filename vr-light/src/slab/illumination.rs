//! Light that comes to a slab from above.

use super::layer::MAX_LIGHT;
use vr_core::ParameterError;

use super::directions::Directions;

/// Smallest cosine of a direction.
pub(super) const MIN_COSINE: f64 = 1e-6;

/// Light that comes from above.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Illumination {
    /// None: only the slab's own sources.
    #[default]
    Dark,
    /// Parallel light.
    Beam {
        /// Cosine of its angle to the normal, 10⁻⁶ to 1.
        cosine: f64,
        /// Flux through a plane parallel to the slab: the cosine times the irradiance on a plane that faces the beam.
        flux: f64,
    },
    /// The same radiance from all directions.
    Diffuse {
        /// The radiance; its flux is π times this.
        radiance: f64,
    },
}

impl Illumination {
    /// Flux that comes in.
    pub fn flux(&self) -> f64 {
        match *self {
            Self::Dark => 0.0,
            Self::Beam { flux, .. } => flux,
            Self::Diffuse { radiance } => std::f64::consts::PI * radiance,
        }
    }

    pub(super) fn validate(&self) -> Result<(), ParameterError> {
        let (key, light) = match *self {
            Self::Dark => return Ok(()),
            Self::Beam { cosine, .. } if !(MIN_COSINE..=1.0).contains(&cosine) => {
                return Err(ParameterError::new("illumination.cosine", cosine, "must be 1e-6 to 1"));
            }
            Self::Beam { flux, .. } => ("illumination.flux", flux),
            Self::Diffuse { radiance } => ("illumination.radiance", radiance),
        };
        if (0.0..=MAX_LIGHT).contains(&light) {
            Ok(())
        } else {
            Err(ParameterError::new(key, light, "must be 0 to 1e6"))
        }
    }

    /// Flux and fluence that reach a depth unscattered.
    pub(super) fn direct(&self, directions: &Directions, depth: f64) -> [f64; 2] {
        match *self {
            Self::Dark => [0.0; 2],
            Self::Beam { cosine, flux } => {
                let passed = flux * libm::exp(-depth / cosine);
                [passed, passed / cosine]
            }
            Self::Diffuse { radiance } => {
                let passed: Vec<f64> = directions.direct(depth).iter().map(|d| radiance * d).collect();
                [directions.flux(&passed), directions.fluence(&passed)]
            }
        }
    }
}
