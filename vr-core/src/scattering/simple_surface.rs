//! Surfaces of simple shapes beside the medium.

use super::Shape;
use crate::error::ParameterError;
use crate::limits::MAX_LIGHT;

/// An opaque surface of a simple shape in or beside the medium, alike on both sides. Its radiance is I = E + ∫ k I_inc cos θ dω: what it emits, and what it
/// reflects by a kernel k that its reflectance ρ and its [`Finish`] tell. It is seen, shades the medium and lights it.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::scattering::{Finish, Shape, SimpleSurface};
///
/// let lamp = SimpleSurface {
///     shape: Shape::Sphere { centre: DVec3::Y, radius: 0.2 },
///     emission: [5.0; 3],
///     reflectance: [0.0; 3],
///     finish: Finish::Matte,
/// };
/// assert!(lamp.validate("lamp").is_ok());
/// // More light than there is.
/// assert!(SimpleSurface { reflectance: [1.1; 3], ..lamp }.validate("lamp").is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimpleSurface {
    /// Its shape in the world.
    pub shape: Shape,
    /// E, linear RGB: the radiance that it emits in all directions.
    pub emission: [f64; 3],
    /// ρ in red, green and blue: the share of light along the normal that is reflected.
    pub reflectance: [f64; 3],
    /// Directions in which it reflects.
    pub finish: Finish,
}

/// Directions in which a surface reflects light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Finish {
    /// The same radiance in all directions (Lambert).
    #[default]
    Matte,
    /// The mirrored direction alone.
    Mirror,
    /// A lobe about the mirrored direction, of the cosine of the angle to it to this power (Phong).
    Gloss {
        /// 0 to 10⁶: the sharpness of the lobe.
        exponent: f64,
    },
}

impl SimpleSurface {
    /// Checks the numbers; `field` is what an error calls the surface.
    ///
    /// # Errors
    /// A shape without area or with coordinates above 10³⁰, an emission that is negative or above 10⁶, a reflectance outside of 0 to 1, an exponent outside of 0 to 10⁶.
    pub fn validate(&self, field: &str) -> Result<(), ParameterError> {
        self.shape.validate(&format!("{field}.shape"))?;
        if self.emission.iter().any(|e| !(0.0..=MAX_LIGHT).contains(e)) {
            let allowed = "must be finite and not negative, 1e6 at most";
            return Err(ParameterError::new(format!("{field}.emission"), self.emission, allowed));
        }
        if self.reflectance.iter().any(|r| !(0.0..=1.0).contains(r)) {
            return Err(ParameterError::new(format!("{field}.reflectance"), self.reflectance, "must be 0 to 1"));
        }
        match self.finish {
            Finish::Gloss { exponent } if !(0.0..=1e6).contains(&exponent) => {
                Err(ParameterError::new(format!("{field}.finish.gloss"), exponent, "must be 0 to 1e6"))
            }
            _ => Ok(()),
        }
    }
}
