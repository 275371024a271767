//! The shear-warp renderer behind the trait that all renderers stand behind.

use vr_core::{Control, Prepared, RenderError, Renderer, Scene};

use crate::prepared::PreparedShearWarp;
use crate::shear_warp::ShearWarp;

impl Renderer for ShearWarp {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn prepare(&self, scene: &Scene, control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        Ok(Box::new(PreparedShearWarp::new(self.clone(), scene, control)?))
    }
}
