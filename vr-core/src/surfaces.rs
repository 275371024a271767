//! Opaque surfaces among the volume.

use std::fmt;
use std::sync::Arc;

use glam::DVec3;

use crate::control::Control;
use crate::error::RenderError;
use crate::ray::Ray;
use crate::shading::Light;
use crate::view::View;

/// Opaque surfaces in a scene: the volume before them is drawn over them, the volume behind them is hidden.
///
/// Renderers of volumes do not know their geometry: they ask for a [`Layer`] for each view that they draw.
///
/// # Examples
/// A red wall:
/// ```
/// use glam::DVec3;
/// use vr_core::{Control, Layer, Light, RenderError, Surfaces, View};
///
/// #[derive(Debug)]
/// struct Wall;
/// impl Surfaces for Wall {
///     fn layer(&self, _: &[Light], view: &View, _: &Control) -> Result<Layer, RenderError> {
///         view.validate()?;
///         let count = view.size[0] as usize * view.size[1] as usize;
///         Ok(Layer { pixels: vec![([1.0, 0.0, 0.0], 7.0); count] })
///     }
///     fn bounds(&self) -> (DVec3, DVec3) {
///         (DVec3::NEG_ONE, DVec3::ONE)
///     }
/// }
///
/// # use vr_core::{Camera, phantom::{self, Phantom}};
/// let mut scene = phantom::by_name("fog").unwrap().scene(5)?;
/// scene.surfaces = Some(std::sync::Arc::new(Wall));
/// let view = View::new(Camera::framing(scene.bounds(), 0.0, 0.0, None), [4, 3]);
/// let layer = scene.layer(&view, &Control::default())?.expect("it has surfaces");
/// assert_eq!(layer.depth(0), 7.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Surfaces: Send + Sync + fmt::Debug {
    /// Draws the surfaces as they are seen in a view, inside its clip.
    ///
    /// # Errors
    /// Same as for [`View::validate`]; also an error of the surfaces' own, or [`RenderError::Cancelled`].
    fn layer(&self, lights: &[Light], view: &View, control: &Control) -> Result<Layer, RenderError>;

    /// Lower and upper corner of the world box around them.
    fn bounds(&self) -> (DVec3, DVec3);

    /// True if [`Self::tracer`] gives one. Asking is cheap.
    fn can_be_traced(&self) -> bool {
        false
    }

    /// Their geometry, prepared for rays from anywhere; `None` where they are known as layers alone.
    fn tracer(&self) -> Option<Arc<dyn SurfaceTracer>> {
        None
    }
}

/// Geometry of opaque surfaces, as rays from anywhere meet it: for renderers that follow light.
pub trait SurfaceTracer: Send + Sync + fmt::Debug {
    /// The first place, between two world distances, at which a ray meets a facet. `leaving` is the facet that the ray starts on: it is not met again.
    fn nearest(&self, ray: &Ray, between: [f64; 2], leaving: Option<u32>) -> Option<FacetHit>;
}

/// Place at which a ray meets a facet of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetHit {
    /// World distance along the ray.
    pub distance: f64,
    /// Number of the facet.
    pub facet: u32,
    /// Unit normal by which it is lit, interpolated where the surface is smooth, on the side of the ray.
    pub normal: DVec3,
    /// Unit normal of the facet itself, on the side of the ray.
    pub facet_normal: DVec3,
    /// Share of red, green and blue that is reflected in all directions (Lambert), 0 to 1.
    pub reflectance: [f64; 3],
}

impl FacetHit {
    /// Cosine of light from the direction of a unit vector; 0 of light from behind.
    pub fn cosine(&self, towards: DVec3) -> f64 {
        if self.facet_normal.dot(towards) > 0.0 { self.normal.dot(towards).max(0.0) } else { 0.0 }
    }
}

/// The picture of opaque surfaces from one view, with depth. One entry a pixel, of the ray through its centre, serves all subpixel rays of
/// [`View::supersampling`].
///
/// # Examples
/// ```
/// use vr_core::Layer;
///
/// // A red wall seven units away in one pixel, nothing in the other.
/// let layer = Layer { pixels: vec![([1.0, 0.0, 0.0], 7.0), ([0.0; 3], f32::INFINITY)] };
/// assert_eq!((layer.depth(0), layer.depth(1)), (7.0, f64::INFINITY));
/// let half = [0.25, 0.25, 0.25, 0.5];
/// assert_eq!(layer.under(0, half), [0.75, 0.25, 0.25, 1.0]);
/// assert_eq!(layer.under(1, half), half);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Row by row from the top: linear RGB and the world distance along the pixel's ray, +∞ where there is nothing.
    pub pixels: Vec<([f32; 3], f32)>,
}

impl Layer {
    /// World distance along a pixel's ray at which it ends; +∞ where it meets no surface.
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
