//! Lights at a place.

use glam::DVec3;

use crate::error::ParameterError;
use crate::limits::{MAX_COORDINATE, MAX_LIGHT};

/// A light without size, at a place in or beside the volume, that shines in all directions: the irradiance at the distance d is π L / d² for the colour L.
/// It is not seen itself.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::scattering::PointLight;
///
/// assert!(PointLight { position: DVec3::Y, color: [4.0; 3] }.validate("light").is_ok());
/// assert!(PointLight { position: DVec3::NAN, color: [4.0; 3] }.validate("light").is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// Its place in the world.
    pub position: DVec3,
    /// L, linear RGB: the radiance of a white surface that faces it at the distance 1.
    pub color: [f64; 3],
}

impl PointLight {
    /// Checks the numbers; `field` is what an error calls the light.
    ///
    /// # Errors
    /// A position that is not finite or has a coordinate above 10³⁰, or a colour that is negative, not finite or above 10¹².
    pub fn validate(&self, field: &str) -> Result<(), ParameterError> {
        if self.position.to_array().iter().any(|x| x.is_nan() || x.abs() > MAX_COORDINATE) {
            let allowed = "must be finite, coordinates 1e30 at most";
            return Err(ParameterError::new(format!("{field}.position"), self.position, allowed));
        }
        // A light far away needs the square of its distance.
        if self.color.iter().any(|c| !(0.0..=MAX_LIGHT * MAX_LIGHT).contains(c)) {
            let allowed = "must be finite and not negative, 1e12 at most";
            return Err(ParameterError::new(format!("{field}.color"), self.color, allowed));
        }
        Ok(())
    }
}
