//! The texture slicer behind the trait that all renderers stand behind.

use vr_core::{Control, Prepared, RenderError, Renderer, Scene};

use crate::prepared::PreparedTexSlice;
use crate::tex_slice::TexSlice;

impl Renderer for TexSlice {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn prepare(&self, scene: &Scene, control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        Ok(Box::new(PreparedTexSlice::new(self.clone(), scene, control)?))
    }
}
