//! The opaque surfaces of a scene, as light meets them.

use std::sync::Arc;

use vr_core::{Clip, FacetHit, Feature, Ray, RenderError, Scene, SurfaceTracer, Unsupported};

/// Share of the coordinates by which rays start before the surface that they leave: above the rounding of places on it, so that light does not meet
/// another facet in the same place.
const LEAVING: f64 = 1e-10;

/// The opaque surfaces of a scene inside a clip: they stop light, and reflect it in all directions alike (Lambert).
#[derive(Clone, Debug)]
pub struct TracedSurfaces {
    tracer: Arc<dyn SurfaceTracer>,
    clip: Clip,
    /// Largest coordinate.
    reach: f64,
}

impl TracedSurfaces {
    /// Reason for which surfaces are refused.
    pub(crate) const REFUSED: &'static str =
        "opaque surfaces that are known as pictures alone: light meets them from all sides";

    /// The surfaces of a scene; `None` if there are none.
    ///
    /// # Errors
    /// Surfaces that rays cannot be traced against.
    pub fn of(scene: &Scene, clip: &Clip) -> Result<Option<Self>, RenderError> {
        let Some(surfaces) = &scene.surfaces else { return Ok(None) };
        let Some(tracer) = surfaces.tracer() else {
            let what = Self::REFUSED.to_owned();
            return Err(Unsupported { renderer: "light", feature: Feature::Surfaces, what }.into());
        };
        let (low, high) = surfaces.bounds();
        let reach = low.abs().max(high.abs()).max_element();
        Ok(Some(Self { tracer, clip: clip.clone(), reach }))
    }

    /// First place at which a ray meets them; `leaving` is the facet that it starts on.
    pub fn nearest(&self, ray: &Ray, leaving: Option<u32>) -> Option<FacetHit> {
        let [start, end] = ray.inside(&self.clip)?;
        let start = if leaving.is_some() { start.max(LEAVING * self.reach) } else { start };
        if start <= end { self.tracer.nearest(ray, [start, end], leaving) } else { None }
    }

    /// True if they are in the way of light from infinitely far away to the origin of a ray towards it.
    pub fn hide(&self, towards: &Ray, leaving: Option<u32>) -> bool {
        self.nearest(towards, leaving).is_some()
    }
}
