//! Scenes that the marcher draws.

use std::sync::Arc;

use vr_core::{CellMesh, Configurable, RenderError, Scene, Unsupported};

use crate::marcher::CellMarcher;

/// Returns the mesh of a scene, if it is one of cells.
pub(crate) fn check(renderer: &CellMarcher, scene: &Scene) -> Result<Arc<CellMesh>, RenderError> {
    renderer.validate()?;
    scene.validate()?;
    let mesh = scene.volume.cells().ok_or_else(|| Unsupported::volume_kind(CellMarcher::NAME, &scene.volume))?;
    Ok(Arc::clone(mesh))
}
