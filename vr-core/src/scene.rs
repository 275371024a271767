//! A scene: a volume and how it is to look.

use std::sync::Arc;

use crate::compositing::Compositing;
use crate::error::ParameterError;
use crate::filter::Filter;
use crate::shading::Shading;
use crate::transfer::TransferFunction;
use crate::volume::Volume;

/// What is drawn. Cheap to clone: the volume and the transfer function are shared.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The volume.
    pub volume: Volume,
    /// The filter that makes the canonical field.
    pub filter: Filter,
    /// From value to extinction and emission.
    pub transfer: Arc<TransferFunction>,
    /// `None`: unshaded.
    pub shading: Option<Arc<Shading>>,
    /// What becomes of the field along a ray.
    pub compositing: Compositing,
    /// Linear radiance that comes in behind everything. Not part of a frame: added when a PNG is written.
    pub background: [f32; 3],
}

impl Scene {
    /// An unshaded scene under emission and absorption, trilinear, before black.
    pub fn new(volume: Volume, transfer: TransferFunction) -> Self {
        Self {
            volume,
            filter: Filter::default(),
            transfer: Arc::new(transfer),
            shading: None,
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
        self.shading.as_ref().map_or(Ok(()), |s| s.validate())
    }
}
