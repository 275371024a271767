//! A view of a scene: camera, image size, supersampling and clipping.

use glam::DVec3;

use crate::camera::Camera;
use crate::error::ParameterError;

/// Camera, size, supersampling and clipping of a picture.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{Camera, View};
///
/// let camera = Camera::framing((DVec3::NEG_ONE, DVec3::ONE), 30.0, 20.0, Some(30.0));
/// let view = View { supersampling: 4, ..View::new(camera, [640, 480]) };
/// assert!(view.validate().is_ok());
/// assert_eq!(View::new(camera, [640, 0]).validate().unwrap_err().field, "image.size");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Number of subpixels along the edge of a pixel, whose mean it is; 1 for the correct pixel.
    pub supersampling: u32,
    /// Crop box and clip planes.
    pub clip: Clip,
}

/// The largest width and height of a picture.
const MAX_PIXELS: u32 = 1 << 16;

impl View {
    /// A view without clipping, one ray a pixel.
    pub fn new(camera: Camera, size: [u32; 2]) -> Self {
        Self { camera, size, supersampling: 1, clip: Clip::default() }
    }

    /// Width of the picture over its height.
    pub fn aspect(&self) -> f64 {
        f64::from(self.size[0]) / f64::from(self.size[1])
    }

    /// Checks everything but the camera's own axes.
    ///
    /// # Errors
    /// A size that is not 1 to 65536, supersampling that is not 1 to 64, an empty crop box, a plane without a normal.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let [w, h] = self.size;
        if w == 0 || h == 0 || w > MAX_PIXELS || h > MAX_PIXELS {
            return Err(ParameterError::new("image.size", self.size, "width and height must be 1 to 65536"));
        }
        if self.supersampling == 0 || self.supersampling > 64 {
            return Err(ParameterError::new("image.samples", self.supersampling, "must be 1 to 64"));
        }
        if let Some((low, high)) = self.clip.crop
            && !(low.cmplt(high).all() && low.is_finite() && high.is_finite())
        {
            let found = (low.to_array(), high.to_array());
            return Err(ParameterError::new(
                "clip.box",
                found,
                "the first corner must be below the second, both finite",
            ));
        }
        for (i, p) in self.clip.planes.iter().enumerate() {
            if !(p.normal.is_finite() && p.normal.length() > 0.0 && p.offset.is_finite()) {
                let allowed = "normal and offset must be finite, the normal not zero";
                return Err(ParameterError::new(format!("clip.planes[{i}]"), p, allowed));
            }
        }
        Ok(())
    }
}

/// Crop box and planes that cut parts of the volume and the surfaces away. Everything is kept by default.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{Clip, Ray};
///
/// let clip = Clip { crop: Some((DVec3::NEG_ONE, DVec3::ONE)), ..Clip::default() };
/// let ray = |x| Ray { origin: DVec3::new(x, 0.0, -5.0), direction: DVec3::Z };
/// assert_eq!(ray(0.5).inside(&clip), Some([4.0, 6.0]));
/// assert_eq!(ray(1.5).inside(&clip), None);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct Clip {
    /// Lower and upper corner of a world box that is kept.
    #[cfg_attr(feature = "serde", serde(rename = "box"))]
    pub crop: Option<(DVec3, DVec3)>,
    /// Half spaces that are kept, all of them.
    pub planes: Vec<Plane>,
}

/// A half space that is kept: normal·x ≥ offset, in world space.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{Clip, Plane, Ray};
///
/// // Keeps what lies beyond x = 3.
/// let plane = Plane { normal: DVec3::X, offset: 3.0 };
/// let clip = Clip { planes: vec![plane], ..Clip::default() };
/// let ray = Ray { origin: DVec3::ZERO, direction: DVec3::X };
/// assert_eq!(ray.inside(&clip), Some([3.0, f64::INFINITY]));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Plane {
    /// Vector into the half space; any length.
    pub normal: DVec3,
    /// Smallest value of normal·x that is kept.
    pub offset: f64,
}
