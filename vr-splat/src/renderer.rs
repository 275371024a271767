//! The splatting renderer behind the trait that all renderers stand behind.

use vr_core::{Control, Prepared, RenderError, Renderer, Scene, View};

use crate::capabilities::{check, check_view};
use crate::prepared::PreparedSplatter;
use crate::splatter::Splatter;

impl Renderer for Splatter {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn supports(&self, scene: &Scene, view: Option<&View>) -> Result<(), RenderError> {
        check(self, scene)?;
        view.map_or(Ok(()), check_view)
    }

    fn prepare(&self, scene: &Scene, control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        Ok(Box::new(PreparedSplatter::new(self.clone(), scene, control)?))
    }
}
