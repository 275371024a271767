//! A scene: a volume and how it is to look.

use std::sync::Arc;

use glam::DVec3;

use crate::compositing::Compositing;
use crate::control::Control;
use crate::error::{ParameterError, RenderError};
use crate::shading::{Light, Shading};
use crate::surfaces::{Layer, Surfaces};
use crate::transfer::TransferFunction;
use crate::view::View;
use crate::volume::Volume;

/// What is drawn. Cheap to clone: volume, transfer function, shading and surfaces are shared.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The volume, and with a grid the filter that makes the canonical field.
    pub volume: Volume,
    /// From value to extinction and emission.
    pub transfer: Arc<TransferFunction>,
    /// How surfaces in the volume reflect light; `None`: unshaded.
    pub shading: Option<Arc<Shading>>,
    /// What lights the volume, where it is shaded, and the surfaces.
    pub lights: Vec<Light>,
    /// Opaque things among the volume.
    pub surfaces: Option<Arc<dyn Surfaces>>,
    /// What becomes of the field along a ray.
    pub compositing: Compositing,
    /// Linear radiance that comes in behind everything. Not part of a frame: added when a PNG is written.
    pub background: [f32; 3],
}

impl Scene {
    /// An unshaded scene under emission and absorption, before black, with a headlight for what it may be given to light.
    pub fn new(volume: Volume, transfer: TransferFunction) -> Self {
        Self {
            volume,
            transfer: Arc::new(transfer),
            shading: None,
            lights: vec![Light::default()],
            surfaces: None,
            compositing: Compositing::default(),
            background: [0.0; 3],
        }
    }

    /// Checks what the parts do not check when they are made.
    ///
    /// # Errors
    /// A [`ParameterError`] naming the field.
    pub fn validate(&self) -> Result<(), ParameterError> {
        self.compositing.validate()?;
        if self.background.iter().any(|&c| !(c >= 0.0 && c.is_finite())) {
            let allowed = "must be finite and not negative";
            return Err(ParameterError::new("image.background", self.background, allowed));
        }
        Light::validate_all(&self.lights)?;
        self.shading.as_ref().map_or(Ok(()), |s| s.validate())
    }

    /// Draws the scene's surfaces as they are seen in a view; `None` where it has none.
    ///
    /// # Errors
    /// As [`View::validate`] and [`Surfaces::layer`]; a layer that does not have one entry a pixel.
    pub fn layer(&self, view: &View, control: &Control) -> Result<Option<Layer>, RenderError> {
        view.validate()?;
        let Some(surfaces) = &self.surfaces else { return Ok(None) };
        let layer = surfaces.layer(&self.lights, view, control)?;
        if layer.pixels.len() as u64 != u64::from(view.size[0]) * u64::from(view.size[1]) {
            let allowed = "the layer of a scene's surfaces must have one entry per pixel of the picture";
            return Err(ParameterError::new("surfaces", layer.pixels.len(), allowed).into());
        }
        Ok(Some(layer))
    }

    /// Lower and upper corner of the world box around all that there is to see: the volume, and the surfaces where there are any.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let (low, high) = self.volume.bounds();
        let (other_low, other_high) = self.surfaces.as_ref().map_or((low, high), |s| s.bounds());
        (low.min(other_low), high.max(other_high))
    }

    /// True if both have the same surfaces, in memory.
    pub fn has_surfaces_of(&self, other: &Self) -> bool {
        match (&self.surfaces, &other.surfaces) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        }
    }

    /// The same scene with its volume under another filter; see [`Volume::with_filter`].
    #[must_use]
    pub fn with_filter(&self, filter: crate::Filter) -> Self {
        Self { volume: self.volume.with_filter(filter), ..self.clone() }
    }
}
