//! Capabilities of the renderer: scenes and views that it can draw, and errors for the rest.

use std::sync::Arc;

use vr_core::{
    Classification, Compositing, Configurable, Feature, Filter, GradientMethod, RenderError, Scene, Unsupported, View,
};
use vr_kernels::tables::beyond_f32;

use crate::input::SplatInput;
use crate::kernel::SplatKernel;
use crate::splatter::{Buffers, CompositingOrder, Splatter};

pub(crate) fn unsupported(feature: Feature, what: impl Into<String>) -> RenderError {
    Unsupported { renderer: Splatter::NAME, feature, what: what.into() }.into()
}

/// Kinds of volume that can be splatted.
const DRAWN: &str = "scattered points, and uniform grids, to which others can be resampled";

/// Returns the input that a scene holds, if this renderer can draw it.
pub(crate) fn check(renderer: &Splatter, scene: &Scene) -> Result<SplatInput, RenderError> {
    renderer.validate()?;
    scene.validate()?;
    scene.without_scattering(Splatter::NAME)?;
    let input = match (scene.volume.grid(), scene.volume.points()) {
        (Some(grid), _) => SplatInput::Grid(Arc::clone(grid)),
        (_, Some(points)) => SplatInput::Points(Arc::clone(points)),
        _ => return Err(Unsupported::volume_kind(Splatter::NAME, &scene.volume, DRAWN).into()),
    };
    // A grid's filter, precision and size.
    if let SplatInput::Grid(grid) = &input {
        if grid.filter() != Filter::Trilinear {
            let feature = format!("the filter '{}': the option 'kernel' says how voxels are spread", grid.filter());
            return Err(unsupported(Feature::Filter, feature));
        }
        if let Some(feature) = beyond_f32(grid, &scene.transfer) {
            return Err(unsupported(Feature::Precision, feature));
        }
        if grid.dims().iter().any(|&n| n > usize::from(u16::MAX)) {
            return Err(unsupported(Feature::Size, "grids of more than 65535 voxels along an axis"));
        }
    }
    // Settings that scattered points do not have.
    if matches!(input, SplatInput::Points(_)) && renderer.buffers == Buffers::Axis {
        return Err(unsupported(
            Feature::Setting,
            "sheets of the volume's own among scattered points: they have no layers",
        ));
    }
    if matches!(input, SplatInput::Points(_)) && renderer.kernel != SplatKernel::default() {
        return Err(unsupported(
            Feature::Setting,
            "another kernel, radius, sigma or width than the default for scattered points: they have kernels of their own",
        ));
    }
    check_shading(renderer, scene, &input)?;
    // Order and compositing.
    if renderer.order == CompositingOrder::BackToFront
        && (renderer.buffers != Buffers::Axis || scene.compositing != Compositing::Over)
    {
        return Err(unsupported(Feature::Setting, "back to front but the volume's own sheets under 'over'"));
    }
    if renderer.sets_termination() && !scene.compositing.integrates_light() {
        return Err(unsupported(
            Feature::Setting,
            format!("a termination under '{}': no opacity is gathered", scene.compositing.name()),
        ));
    }
    let values_in_image_sheets = renderer.buffers == Buffers::Image && renderer.classification == Classification::Post;
    match scene.compositing {
        picks if !picks.integrates_light() && !values_in_image_sheets => Err(unsupported(
            Feature::Compositing,
            format!("compositing '{}' but of values in sheets parallel to the image", picks.name()),
        )),
        _ => Ok(input),
    }
}

fn check_shading(renderer: &Splatter, scene: &Scene, input: &SplatInput) -> Result<(), RenderError> {
    if scene.has_gradient_opacity() {
        return Err(unsupported(Feature::GradientOpacity, "opacity that follows the gradient"));
    }
    let Some(shading) = scene.reflection() else { return Ok(()) };
    let SplatInput::Grid(grid) = input else {
        return Err(unsupported(Feature::Shading, "shading of scattered points"));
    };
    if renderer.splats_light() {
        return Err(unsupported(Feature::Shading, "shading of what is classified before it is splatted"));
    }
    if shading.gradient == GradientMethod::Analytic {
        return Err(unsupported(
            Feature::AnalyticGradients,
            "analytic gradients: those at the voxels are interpolated",
        ));
    }
    if grid.dims().iter().product::<usize>() > i32::MAX as usize {
        return Err(unsupported(Feature::Size, "shading of 2³¹ voxels and more"));
    }
    Ok(())
}

/// Largest number of pixels, subpixels included, along either side of a picture.
const MAX_SUBPIXELS: u32 = 1 << 16;

/// Checks that this renderer can draw this view.
pub(crate) fn check_view(view: &View) -> Result<(), RenderError> {
    view.validate()?;
    if view.size.iter().any(|&n| n.saturating_mul(view.supersampling) > MAX_SUBPIXELS) {
        return Err(unsupported(Feature::Size, "pictures of more than 65536 subpixels along a side"));
    }
    Ok(())
}

impl Splatter {
    /// True if voxels or points are classified before they are splatted.
    pub(crate) fn splats_light(&self) -> bool {
        self.classification == Classification::Pre || self.buffers == Buffers::Samples
    }
}
