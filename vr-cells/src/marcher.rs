//! The marcher, as a renderer.

use vr_core::{Control, Prepared, RenderError, Renderer, Scene, View};

use crate::capabilities::check;
use crate::prepared::PreparedMarcher;

/// A renderer of meshes of cells that goes from cell to cell along each ray.
#[derive(Clone, Debug, PartialEq)]
pub struct CellMarcher {
    /// Opacity in (0, 1] at which rays end; 1: never. What is left out changes no pixel by more than 1 − termination, times the largest colour.
    pub termination: f64,
}

impl CellMarcher {
    /// The name in scene files and on command lines.
    pub const NAME: &'static str = "march";
}

impl Default for CellMarcher {
    fn default() -> Self {
        Self { termination: 1.0 - 1e-6 }
    }
}

impl Renderer for CellMarcher {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn supports(&self, scene: &Scene, view: Option<&View>) -> Result<(), RenderError> {
        check(self, scene)?;
        view.map_or(Ok(()), |view| Ok(view.validate()?))
    }

    fn prepare(&self, scene: &Scene, control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        Ok(Box::new(PreparedMarcher::new(self.clone(), scene, control)?))
    }
}
