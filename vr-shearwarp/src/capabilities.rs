//! Capabilities of the renderer: scenes and views that it can draw, and errors for the rest.

use std::sync::Arc;

use glam::DVec3;
use vr_core::{
    Classification, Compositing, Configurable, Feature, Filter, GridVolume, RenderError, Scene, Unsupported,
};
use vr_kernels::tables::beyond_f32;

use crate::shear_warp::ShearWarp;
use crate::steepness::{looks_at_filter_gradients, samples_filter_gradients};

pub(crate) fn unsupported(feature: Feature, what: impl Into<String>) -> RenderError {
    Unsupported { renderer: ShearWarp::NAME, feature, what: what.into() }.into()
}

/// Returns the volume of a scene that this renderer can draw.
pub(crate) fn check(renderer: &ShearWarp, scene: &Scene) -> Result<Arc<GridVolume>, RenderError> {
    renderer.validate()?;
    scene.validate()?;
    scene.without_scattering(ShearWarp::NAME)?;
    if let Some(option) = idle_option(renderer, scene) {
        return Err(unsupported(
            Feature::Setting,
            format!("{option} under '{}': a ray is left with one value", scene.compositing.name()),
        ));
    }
    if samples_filter_gradients(scene) {
        if renderer.classification == Classification::Pre {
            let what = "analytic gradients of voxels: between the cells around a voxel the trilinear filter's gradient jumps, and has none of its own there";
            return Err(unsupported(Feature::AnalyticGradients, what));
        }
        if renderer.slice_spacing() == 1.0 {
            let what = "analytic gradients in slices that are layers of voxels: across a layer the trilinear filter's gradient jumps; slices closer than a voxel lie between layers";
            return Err(unsupported(Feature::AnalyticGradients, what));
        }
    }
    let volume = scene
        .volume
        .value_grid()
        .ok_or_else(|| Unsupported::volume_kind(ShearWarp::NAME, &scene.volume, Unsupported::GRIDS))?;
    match volume.filter() {
        Filter::Trilinear => {}
        Filter::Nearest if looks_at_filter_gradients(scene) => {
            let why = "analytic gradients of the filter 'nearest', which are zero wherever there are any; take central differences";
            return Err(unsupported(Feature::AnalyticGradients, why));
        }
        Filter::Nearest => {}
        other => {
            let why = format!("the filter '{other}': slices are interpolated linearly, or the nearest voxel is taken");
            return Err(unsupported(Feature::Filter, why));
        }
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
    // A surface is searched for in the cells that reach its threshold.
    let shows_all = !matches!(scene.compositing, Compositing::First { .. });
    // A termination of 1 asks for what is done anyway: no ray ends early.
    if renderer.classification != default.classification {
        Some("classified voxels (the option classification)")
    } else if ![default.termination, 1.0].contains(&renderer.termination) {
        Some("a termination")
    } else if renderer.opacity_threshold > 0.0 {
        Some("an opacity-threshold")
    } else if renderer.empty_space != default.empty_space && shows_all {
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
