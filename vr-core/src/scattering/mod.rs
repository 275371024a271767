//! Scattering of light in the medium: how much of what is extinguished goes on in another direction, and in which.
//!
//! Along a ray the total extinction χ is the true absorption κ and the scattering σ together: χ = κ + σ. The albedo ϖ = σ/χ says which share is
//! scattered; 1/χ is the mean free path. Light that is scattered leaves in directions that the [`PhaseFunction`] tells.

mod environment_image;
mod phase;
mod point_light;
mod shape;
mod simple_surface;

pub use environment_image::EnvironmentImage;
pub use phase::{DoubleHenyeyGreenstein, HenyeyGreenstein, PhaseFunction, TabulatedPhase};
pub use point_light::PointLight;
pub use shape::Shape;
pub use simple_surface::{Finish, SimpleSurface};

use std::sync::Arc;

use crate::error::ParameterError;

/// Scattering of light by the medium of a scene.
///
/// # Examples
/// ```
/// use vr_core::scattering::{Albedo, PhaseFunction, Scattering};
///
/// // Light that the scene's lights send into a cloud.
/// let cloud = Scattering {
///     albedo: Albedo::Constant([0.99; 3]),
///     phase: PhaseFunction::henyey_greenstein(0.85)?,
///     environment: [0.1; 3],
///     ..Scattering::default()
/// };
/// assert!(cloud.validate().is_ok());
/// assert_eq!(cloud.albedo.of([1.0, 0.5, 0.0]), [0.99; 3]);
/// assert_eq!(Albedo::Color.of([1.0, 0.5, 0.0]), [1.0, 0.5, 0.0]);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scattering {
    /// Share of the extinction that is scattering.
    pub albedo: Albedo,
    /// Directions in which scattered light leaves.
    pub phase: PhaseFunction,
    /// Radiance that comes from all sides and is scattered. It is not seen behind the medium: that is [`Scene::background`](crate::Scene::background).
    pub environment: [f64; 3],
    /// A picture of the light from all sides, which adds to the environment.
    pub environment_map: Option<Arc<EnvironmentImage>>,
    /// Lights at a place, beside those of the scene.
    pub point_lights: Vec<PointLight>,
    /// Opaque surfaces of simple shapes, 1000 at most: each ray is put to all of them. A clip does not cut them.
    pub surfaces: Vec<SimpleSurface>,
}

/// Largest number of simple surfaces.
const MAX_SURFACES: usize = 1000;

impl Scattering {
    /// Checks the numbers.
    ///
    /// # Errors
    /// An albedo outside of 0 to 1, an environment that is negative or brighter than 10⁶, a [point light](PointLight::validate) or a [surface](SimpleSurface::validate), or more than 1000 surfaces.
    pub fn validate(&self) -> Result<(), ParameterError> {
        if let Albedo::Constant(albedo) = self.albedo
            && albedo.iter().any(|a| !(0.0..=1.0).contains(a))
        {
            return Err(ParameterError::new("scattering.albedo", albedo, "must be 0 to 1"));
        }
        if self.environment.iter().any(|e| !(0.0..=crate::limits::MAX_LIGHT).contains(e)) {
            let allowed = "must be finite and not negative, 1e6 at most";
            return Err(ParameterError::new("scattering.environment", self.environment, allowed));
        }
        let mut lights = self.point_lights.iter().enumerate();
        lights.try_for_each(|(i, light)| light.validate(&format!("scattering.point_lights[{i}]")))?;
        if self.surfaces.len() > MAX_SURFACES {
            let allowed = "must be 1000 at most: more triangles make a mesh";
            return Err(ParameterError::new("scattering.surfaces", self.surfaces.len(), allowed));
        }
        let mut surfaces = self.surfaces.iter().enumerate();
        surfaces.try_for_each(|(i, surface)| surface.validate(&format!("scattering.surfaces[{i}]")))
    }
}

/// Share of the extinction that is scattering, in red, green and blue.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Albedo {
    /// Colour of the transfer function, cut at 1: a white voxel scatters all light, a black one none. The medium does not glow then, unless the
    /// transfer function gives emission on its own.
    #[default]
    Color,
    /// The same everywhere. The colour of the transfer function is that of the glow then: q = κ·c, unless emission is given on its own.
    Constant([f64; 3]),
}

impl Albedo {
    /// Albedo of a place where the transfer function has this colour.
    pub fn of(self, color: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Color => color.map(|c| c.clamp(0.0, 1.0)),
            Self::Constant(albedo) => albedo,
        }
    }
}
