//! The shear-warp renderer behind the trait that all renderers stand behind.

use vr_core::{Control, Prepared, RenderError, Renderer, Scene, View};

use crate::capabilities::check;
use crate::prepared::PreparedShearWarp;
use crate::shear_warp::ShearWarp;

impl Renderer for ShearWarp {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn supports(&self, scene: &Scene, view: Option<&View>) -> Result<(), RenderError> {
        check(self, scene)?;
        view.map_or(Ok(()), |view| {
            view.validate()?;
            Ok(())
        })
    }

    fn prepare(&self, scene: &Scene, control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        Ok(Box::new(PreparedShearWarp::new(self.clone(), scene, control)?))
    }
}
