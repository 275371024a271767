//! Gradients of the field that textures hold, in f64.

use glam::DVec3;
use vr_core::{GradientMethod, GridVolume};

use crate::compression::Compressed;

/// Source of gradients at any place, where f64 is wanted: in the model, and at a first point.
pub(crate) struct ExactGradients<'a> {
    pub(crate) volume: &'a GridVolume,
    /// The texture, where that is not the volume itself.
    pub(crate) compressed: Option<&'a Compressed>,
    pub(crate) method: GradientMethod,
}

impl ExactGradients<'_> {
    /// Gradient in the world, of stored numbers, at an index. Zero where there is none: the interpolant has no derivative in vacuum.
    pub(crate) fn at(&self, index: [f64; 3]) -> DVec3 {
        let gradient = match (self.method, self.compressed) {
            (GradientMethod::CentralDifferences, None) => self.volume.central_differences_at(index),
            (GradientMethod::CentralDifferences, Some(compressed)) => compressed.gradient_at(index),
            (GradientMethod::Analytic, None) => self.volume.stored_and_gradient_at(index).1,
            (GradientMethod::Analytic, Some(compressed)) => compressed.slope_at(index),
        };
        let world = self.volume.placement().gradient_to_world(gradient.into());
        if world.is_nan() { DVec3::ZERO } else { world }
    }
}

/// Gradient in the world, of stored numbers, at a voxel: by central differences.
pub(crate) fn at_voxel(volume: &GridVolume, index: [usize; 3]) -> DVec3 {
    volume.placement().gradient_to_world(volume.central_differences_at_sample(index).into())
}
