//! A view of a scene: camera, image size, clipping, and what opaque things stand in it.

use std::sync::Arc;

use glam::DVec3;

use crate::camera::Camera;
use crate::error::ParameterError;

/// What to draw from where, how large.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// A pixel is the mean over `samples`² subpixel centres; 1 is canonical.
    pub samples: u32,
    /// Crop box and clip planes.
    pub clip: Clip,
    /// Opaque things among the volume.
    pub layer: Option<Arc<Layer>>,
}

/// The largest width and height of a picture.
const MOST_PIXELS: u32 = 1 << 16;

impl View {
    /// A view without clipping, one ray a pixel.
    pub fn new(camera: Camera, size: [u32; 2]) -> Self {
        Self { camera, size, samples: 1, clip: Clip::default(), layer: None }
    }

    /// Checks everything but the camera's own axes.
    ///
    /// # Errors
    /// A zero-sized or absurdly large picture, no samples, an empty crop box, a plane without a normal, a layer of another size.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let [w, h] = self.size;
        if w == 0 || h == 0 || w > MOST_PIXELS || h > MOST_PIXELS {
            return Err(ParameterError::new("image.size", self.size, "width and height must be 1 to 65536"));
        }
        if self.samples == 0 || self.samples > 64 {
            return Err(ParameterError::new("image.samples", self.samples, "must be 1 to 64"));
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
        if let Some(layer) = &self.layer
            && layer.pixels.len() as u64 != u64::from(w) * u64::from(h)
        {
            return Err(ParameterError::new(
                "layer",
                layer.pixels.len(),
                "must have one entry per pixel of the picture",
            ));
        }
        Ok(())
    }
}

/// What is cut away. Everything is kept by default.
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

/// Keeps normal·x ≥ offset, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Plane {
    /// Points into what is kept; any length.
    pub normal: DVec3,
    /// See above.
    pub offset: f64,
}

/// An opaque picture with depth, as another renderer of surfaces made it: the volume before it is drawn over it, the volume
/// behind it is hidden. One entry a pixel, of the ray through its centre, serves all subpixel rays of [`View::samples`].
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Row by row from the top: linear RGB and the world distance along the pixel's ray, +∞ where there is nothing.
    pub pixels: Vec<([f32; 3], f32)>,
}

impl Layer {
    /// How far a pixel's ray goes.
    pub fn depth(&self, pixel: usize) -> f64 {
        f64::from(self.pixels[pixel].1)
    }

    /// Draws a premultiplied pixel over the layer.
    pub fn under(&self, pixel: usize, rgba: [f64; 4]) -> [f64; 4] {
        let (color, depth) = self.pixels[pixel];
        if depth == f32::INFINITY {
            return rgba;
        }
        let rest = 1.0 - rgba[3];
        std::array::from_fn(|c| if c < 3 { rgba[c] + rest * f64::from(color[c]) } else { 1.0 })
    }
}
