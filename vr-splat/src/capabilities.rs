//! What the renderer can draw, and what it says of the rest.

use std::sync::Arc;

use vr_core::{Compositing, Feature, Filter, GradientMethod, RenderError, Scene, Unsupported, View};
use vr_kernels::tables::beyond_f32;

use crate::input::SplatInput;
use crate::kernel::SplatKernel;
use crate::splatting::{Buffers, Classification, SheetOrder, Splatting};

pub(crate) fn unsupported(feature: Feature, what: impl Into<String>) -> RenderError {
    Unsupported { renderer: Splatting::NAME, feature, what: what.into() }.into()
}

/// Whether this renderer can draw this scene; what is in it, if so.
pub(crate) fn check(renderer: &Splatting, scene: &Scene) -> Result<SplatInput, RenderError> {
    renderer.validate()?;
    scene.validate()?;
    let input = match (scene.volume.grid(), scene.volume.points()) {
        (Some(grid), _) => SplatInput::Grid(Arc::clone(grid)),
        (_, Some(points)) => SplatInput::Points(Arc::clone(points)),
        _ => return Err(unsupported(Feature::VolumeKind, format!("volumes of the kind '{}'", scene.volume.kind()))),
    };
    if let SplatInput::Grid(grid) = &input {
        if grid.filter() != Filter::Trilinear {
            let feature = format!("the filter '{}': the option 'kernel' says how voxels are spread", grid.filter());
            return Err(unsupported(Feature::Filter, feature));
        }
        if let Some(feature) = beyond_f32(grid, &scene.transfer) {
            return Err(unsupported(Feature::Precision, feature));
        }
        if grid.dims().iter().any(|&n| n > usize::from(u16::MAX)) {
            return Err(unsupported(Feature::Size, "grids of more than 65535 samples along an axis"));
        }
    }
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
    if renderer.order == SheetOrder::BackToFront
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
    let values_in_image_sheets =
        renderer.buffers == Buffers::Image && renderer.classification == Classification::Values;
    match scene.compositing {
        picks if !picks.integrates_light() && !values_in_image_sheets => Err(unsupported(
            Feature::Compositing,
            format!("compositing '{}' but of values in sheets parallel to the image", picks.name()),
        )),
        Compositing::First { .. } if scene.shading.is_some() => {
            Err(unsupported(Feature::Compositing, "compositing 'first' of a shaded surface"))
        }
        _ => Ok(input),
    }
}

fn check_shading(renderer: &Splatting, scene: &Scene, input: &SplatInput) -> Result<(), RenderError> {
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
            "analytic gradients: those at the samples are interpolated",
        ));
    }
    if grid.census().nan + grid.census().infinite > 0 {
        return Err(unsupported(Feature::MissingValues, "shading of a volume with missing samples"));
    }
    if grid.dims().iter().product::<usize>() > i32::MAX as usize {
        return Err(unsupported(Feature::Size, "shading of 2³¹ samples and more"));
    }
    Ok(())
}

/// The most pixels, subpixels included, along either side of a picture.
const MOST_SUBPIXELS: u32 = 1 << 16;

/// Whether this renderer can draw this view.
pub(crate) fn check_view(view: &View) -> Result<(), RenderError> {
    view.validate()?;
    if view.size.iter().any(|&n| n.saturating_mul(view.supersampling) > MOST_SUBPIXELS) {
        return Err(unsupported(Feature::Size, "pictures of more than 65536 subpixels along a side"));
    }
    Ok(())
}

impl Splatting {
    /// Whether what is splatted is classified beforehand.
    pub(crate) fn splats_light(&self) -> bool {
        self.classification == Classification::Voxels || self.buffers == Buffers::Samples
    }
}
