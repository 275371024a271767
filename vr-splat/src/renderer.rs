//! The splatting renderer behind the trait that all renderers stand behind.

use vr_core::{Control, Prepared, RenderError, Renderer, Scene};

use crate::prepared::PreparedSplatting;
use crate::splatting::Splatting;

impl Renderer for Splatting {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn prepare(&self, scene: &Scene, control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        Ok(Box::new(PreparedSplatting::new(self.clone(), scene, control)?))
    }
}
