//! Scenes of meshes that can be drawn.

use std::sync::Arc;

use vr_core::{CellMesh, Configurable, Feature, Field, RenderError, Scene, Unsupported};

use crate::marcher::CellMarcher;

/// Returns the mesh of a scene, if the marcher draws it.
pub(crate) fn check(renderer: &CellMarcher, scene: &Scene) -> Result<Arc<CellMesh>, RenderError> {
    renderer.validate()?;
    mesh_of(CellMarcher::NAME, scene)
}

/// True if a scene asks for the gradients of its mesh.
pub(crate) fn needs_gradients(scene: &Scene) -> bool {
    scene.reflection().is_some() || scene.has_gradient_opacity()
}

/// Returns the mesh of a scene, if it is one of cells and has the gradients that the scene asks for.
pub(crate) fn mesh_of(renderer: &'static str, scene: &Scene) -> Result<Arc<CellMesh>, RenderError> {
    scene.validate()?;
    scene.without_scattering(renderer)?;
    let mesh =
        scene.volume.cells().ok_or_else(|| Unsupported::volume_kind(renderer, &scene.volume, "meshes of cells"))?;
    // Cells that are constant have no gradient.
    let refused = [
        (scene.has_gradient_opacity(), Feature::GradientOpacity, "opacity by the gradient"),
        (scene.reflection().is_some(), Feature::Shading, "shading"),
    ];
    if let Some((_, feature, name)) = refused.into_iter().find(|r| r.0 && !mesh.has_gradient()) {
        let what = format!("{name} of a mesh with values of cells, which jump and have no gradient");
        return Err(Unsupported { renderer, feature, what }.into());
    }
    Ok(Arc::clone(mesh))
}
