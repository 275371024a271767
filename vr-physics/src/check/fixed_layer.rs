//! Surfaces that are a given picture.

use std::sync::Arc;

use glam::DVec3;
use vr_core::{Control, Layer, Light, RenderError, Scene, Surfaces, View};

/// Surfaces that look the same from everywhere: one picture, for tests whose view stays what it is.
#[derive(Clone, Debug)]
pub struct FixedLayer(pub Layer);

impl FixedLayer {
    /// The picture with this colour and depth in each pixel of a view, by its number.
    pub fn new(view: &View, pixel: impl Fn(u32) -> ([f32; 3], f32)) -> Self {
        Self(Layer { pixels: (0..view.size[0] * view.size[1]).map(pixel).collect() })
    }

    /// A scene with this picture for its surfaces.
    pub fn among(self, scene: &Scene) -> Scene {
        Scene { surfaces: Some(Arc::new(self)), ..scene.clone() }
    }
}

impl Surfaces for FixedLayer {
    fn layer(&self, _: &[Light], _: &View, _: &Control) -> Result<Layer, RenderError> {
        Ok(self.0.clone())
    }

    /// A picture has no place in the world: a point.
    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::ZERO, DVec3::ZERO)
    }
}
