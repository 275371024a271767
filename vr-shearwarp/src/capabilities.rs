//! Capabilities of the renderer: scenes and views that it can draw, and errors for the rest.

use std::sync::Arc;

use glam::DVec3;
use vr_core::{
    Compositing, Configurable, Feature, Filter, GradientMethod, GridVolume, RenderError, Scene, Unsupported,
};
use vr_kernels::tables::beyond_f32;

use crate::shear_warp::ShearWarp;

pub(crate) fn unsupported(feature: Feature, what: impl Into<String>) -> RenderError {
    Unsupported { renderer: ShearWarp::NAME, feature, what: what.into() }.into()
}

/// Returns the volume of a scene that this renderer can draw.
pub(crate) fn check(renderer: &ShearWarp, scene: &Scene) -> Result<Arc<GridVolume>, RenderError> {
    renderer.validate()?;
    scene.validate()?;
    scene.without_scattering(ShearWarp::NAME)?;
    if let Compositing::First { .. } = scene.compositing {
        return Err(unsupported(
            Feature::Compositing,
            "compositing 'first': the place of a surface between slices is not known",
        ));
    }
    if scene.surfaces.is_some() {
        return Err(unsupported(Feature::Surfaces, "opaque surfaces: a texel of the intermediate image is no pixel"));
    }
    if let Some(option) = idle_option(renderer, scene) {
        return Err(unsupported(
            Feature::Setting,
            format!("{option} under '{}': a ray is left with one value", scene.compositing.name()),
        ));
    }
    if scene.has_gradient_opacity() {
        return Err(unsupported(
            Feature::GradientOpacity,
            "opacity that follows the gradient: encoded normals have no length",
        ));
    }
    if scene.reflection().is_some_and(|shading| shading.gradient == GradientMethod::Analytic) {
        return Err(unsupported(Feature::AnalyticGradients, "analytic gradients: normals are encoded at the voxels"));
    }
    let volume = scene
        .volume
        .grid()
        .ok_or_else(|| Unsupported::volume_kind(ShearWarp::NAME, &scene.volume, Unsupported::GRIDS))?;
    if volume.filter() != Filter::Trilinear {
        return Err(unsupported(
            Feature::Filter,
            format!("the filter '{}': slices are interpolated linearly", volume.filter()),
        ));
    }
    match beyond_f32(volume, &scene.transfer) {
        Some(feature) => Err(unsupported(Feature::Precision, feature)),
        None => Ok(Arc::clone(volume)),
    }
}

/// Finds an option that was set and has no effect because the operator picks values and gathers no light.
fn idle_option(renderer: &ShearWarp, scene: &Scene) -> Option<&'static str> {
    if scene.compositing.integrates_light() {
        return None;
    }
    let default = ShearWarp::default();
    // A termination of 1 asks for what is done anyway: no ray ends early.
    if renderer.classification != default.classification {
        Some("classified voxels (the option classification)")
    } else if ![default.termination, 1.0].contains(&renderer.termination) {
        Some("a termination")
    } else if renderer.opacity_threshold > 0.0 {
        Some("an opacity-threshold")
    } else if renderer.empty_space != default.empty_space {
        Some("another search for what is visible (the option encoding)")
    } else if !renderer.correction {
        Some("uncorrected opacity (the option correction)")
    } else {
        None
    }
}

/// The index of the last sample along each axis.
pub(crate) fn last_sample(dims: [usize; 3]) -> DVec3 {
    DVec3::from_array(dims.map(|n| (n - 1) as f64))
}
