//! The projector, as a renderer.

use std::sync::Arc;

use vr_core::{
    CellMesh, Compositing, Configurable, Control, Feature, Prepared, RenderError, Renderer, Scene, Unsupported, View,
};

use crate::capabilities::mesh_of;

use super::prepared::PreparedProjector;

/// Attenuation of light inside a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Attenuation {
    /// The integral along each ray, of the transfer function at every value between those at both faces.
    #[default]
    Exact,
    /// Opacity and colour at the thickest point of a cell's projection, linear from there to its rim: the classic approximation of Shirley & Tuchman.
    Linear,
}

/// A renderer of meshes of cells that projects each cell onto the screen (Shirley & Tuchman 1990), in order of visibility.
#[derive(Clone, Debug, PartialEq)]
pub struct CellProjector {
    /// Attenuation of light inside a cell.
    pub attenuation: Attenuation,
    /// Opacity in (0, 1] at which pixels take no more; 1: never. What is left out changes no pixel by more than 1 − termination, times the largest colour.
    pub termination: f64,
}

impl CellProjector {
    /// The name in scene files and on command lines.
    pub const NAME: &'static str = "project";

    /// Returns the mesh of a scene that can be drawn.
    pub(super) fn check(&self, scene: &Scene) -> Result<Arc<CellMesh>, RenderError> {
        self.validate()?;
        let mesh = mesh_of(Self::NAME, scene)?;
        if self.attenuation == Attenuation::Linear {
            let refused = [
                (
                    scene.compositing != Compositing::Over,
                    Feature::Compositing,
                    "compositing by another operator than over",
                ),
                (scene.reflection().is_some(), Feature::Shading, "shading"),
                (scene.has_gradient_opacity(), Feature::GradientOpacity, "opacity by the gradient"),
                (scene.transfer.has_emission(), Feature::Setting, "emission of its own"),
                (scene.surfaces.is_some(), Feature::Surfaces, "opaque surfaces"),
            ];
            if let Some((_, feature, name)) = refused.into_iter().find(|r| r.0) {
                let what = format!(
                    "{name} with attenuation=linear, which knows a cell by its thickest point; attenuation=exact draws it"
                );
                return Err(Unsupported { renderer: Self::NAME, feature, what }.into());
            }
        }
        Ok(mesh)
    }

    /// Checks a view against the settings.
    pub(super) fn check_view(&self, view: &View) -> Result<(), RenderError> {
        view.validate()?;
        if self.attenuation == Attenuation::Linear && (view.clip.crop.is_some() || !view.clip.planes.is_empty()) {
            let what = "clip planes with attenuation=linear, which does not cut cells; attenuation=exact draws them"
                .to_owned();
            return Err(Unsupported { renderer: Self::NAME, feature: Feature::Setting, what }.into());
        }
        Ok(())
    }
}

impl Default for CellProjector {
    fn default() -> Self {
        Self { attenuation: Attenuation::Exact, termination: 1.0 - 1e-5 }
    }
}

impl Renderer for CellProjector {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn supports(&self, scene: &Scene, view: Option<&View>) -> Result<(), RenderError> {
        self.check(scene)?;
        view.map_or(Ok(()), |view| self.check_view(view))
    }

    fn prepare(&self, scene: &Scene, control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        Ok(Box::new(PreparedProjector::new(self.clone(), scene, control)?))
    }
}
