//! The texture slicer behind the trait that all renderers stand behind.

use vr_core::{Control, Prepared, RenderError, Renderer, Scene, View};

use crate::prepared::PreparedTexSlice;
use crate::support::{check, check_view};
use crate::tex_slice::TexSlice;

impl Renderer for TexSlice {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn supports(&self, scene: &Scene, view: Option<&View>) -> Result<(), RenderError> {
        check(self, scene)?;
        view.map_or(Ok(()), |view| {
            view.validate()?;
            check_view(self, scene, view)
        })
    }

    fn prepare(&self, scene: &Scene, control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        Ok(Box::new(PreparedTexSlice::new(self.clone(), scene, control)?))
    }
}
