//! The texture slicer behind the trait that all renderers stand behind.

use vr_core::{Control, Prepared, RenderError, Renderer, Scene, View};

use crate::capabilities::check;
use crate::prepared::PreparedTextureSlicer;
use crate::texture_slicer::TextureSlicer;

impl Renderer for TextureSlicer {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn supports(&self, scene: &Scene, view: Option<&View>) -> Result<(), RenderError> {
        check(self, scene)?;
        view.map_or(Ok(()), |view| Ok(view.validate()?))
    }

    fn prepare(&self, scene: &Scene, control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        Ok(Box::new(PreparedTextureSlicer::new(self.clone(), scene, control)?))
    }
}
