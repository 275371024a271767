//! Capabilities of the renderer: scenes and views that it can draw, and errors for the rest.

use std::sync::Arc;

use vr_core::{
    Classification, Compositing, Configurable, Feature, Filter, GradientMethod, PointMixing, PointSet, RenderError,
    Scene, Unsupported, View,
};
use vr_kernels::tables::beyond_f32;

use crate::ghosts::BEYOND;
use crate::input::SplatInput;
use crate::kernel::{Shape, SplatKernel};
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
    let input = match (scene.volume.value_grid(), scene.volume.points()) {
        (Some(grid), _) => SplatInput::Grid(Arc::clone(grid)),
        (_, Some(points)) => SplatInput::Points(Arc::clone(points)),
        _ => return Err(Unsupported::volume_kind(Splatter::NAME, &scene.volume, DRAWN).into()),
    };
    // A grid's filter, precision and size.
    if let SplatInput::Grid(grid) = &input {
        check_filter(renderer, grid.filter())?;
        if let Some(feature) = beyond_f32(grid, &scene.transfer) {
            return Err(unsupported(Feature::Precision, feature));
        }
        if grid.dims().iter().any(|&n| n + 2 * BEYOND > usize::from(u16::MAX)) {
            return Err(unsupported(Feature::Size, "grids of more than 65533 voxels along an axis"));
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
    if let SplatInput::Points(points) = &input {
        check_mixture(renderer, scene, points)?;
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
    match scene.compositing {
        picks if !picks.integrates_light() => check_picks(renderer, picks, &input)?,
        _ => {}
    }
    Ok(input)
}

/// Checks that weights can be divided out where points are averaged, or their colours.
fn check_mixture(renderer: &Splatter, scene: &Scene, points: &PointSet) -> Result<(), RenderError> {
    let what = match (points.mixing(), points.colors()) {
        (PointMixing::Sum, None) => return Ok(()),
        (PointMixing::Mean, _) => "means of scattered points",
        (PointMixing::Sum, Some(_)) => "colours of scattered points",
    };
    if renderer.splats_light() || renderer.buffers != Buffers::Image {
        let why = "but of values in sheets parallel to the image: others hold no weights to divide by";
        return Err(unsupported(Feature::Setting, format!("{what} {why}")));
    }
    if points.colors().is_some() && !scene.compositing.integrates_light() {
        let operator = scene.compositing.name();
        let why = format!("under '{operator}': a picked value does not say where it was, nor its colour");
        return Err(unsupported(Feature::Compositing, format!("colours of scattered points {why}")));
    }
    Ok(())
}

/// Checks that a kernel is the grid's filter, or the filter the default.
fn check_filter(renderer: &Splatter, filter: Filter) -> Result<(), RenderError> {
    let why = if filter == Filter::Trilinear {
        return Ok(());
    } else if renderer.kernel != SplatKernel::default() {
        "beside a kernel of the renderer's: a voxel is spread by one of them"
    } else if filter == Filter::BSpline && (renderer.buffers != Buffers::Image || renderer.splats_light()) {
        "but of values in sheets parallel to the image: its coefficients, which may lie beyond all voxels, are a field only all together"
    } else {
        return Ok(());
    };
    Err(unsupported(Feature::Filter, format!("the filter '{filter}' {why}")))
}

/// Checks that there are values to pick from.
fn check_picks(renderer: &Splatter, operator: Compositing, input: &SplatInput) -> Result<(), RenderError> {
    let why = match input {
        // A sample on its own has its value, whenever it is classified.
        SplatInput::Grid(_)
            if renderer.classification == Classification::Post || renderer.buffers == Buffers::Samples =>
        {
            return Ok(());
        }
        SplatInput::Points(_)
            if renderer.buffers == Buffers::Image && renderer.classification == Classification::Post =>
        {
            return Ok(());
        }
        SplatInput::Grid(_) => "of voxels that are classified before they are splatted: light has no value to compare",
        SplatInput::Points(_) => "of scattered points but of values in sheets parallel to the image",
    };
    Err(unsupported(Feature::Compositing, format!("compositing '{}' {why}", operator.name())))
}

/// Checks that there are gradients where the scene's light depends on them.
fn check_shading(renderer: &Splatter, scene: &Scene, input: &SplatInput) -> Result<(), RenderError> {
    let integrates = scene.compositing.integrates_light();
    let Some(shading) =
        scene.gradient_shading().filter(|_| scene.reflection().is_some() || scene.has_gradient_opacity())
    else {
        return Ok(());
    };
    let samples = match input {
        SplatInput::Grid(grid) => grid.dims().iter().product::<usize>(),
        SplatInput::Points(points) => points.count(),
    };
    // Points have one gradient, the sum of their kernels' own, whichever is asked for.
    let of_grid = matches!(input, SplatInput::Grid(_));
    if of_grid && shading.gradient == GradientMethod::Analytic && integrates {
        let kinks = matches!(renderer.spreading(input).kernel.shape, Shape::Bilinear | Shape::Cone);
        let why = if renderer.splats_light() && kinks {
            "of voxels classified on their own: their kernel has a kink at every voxel, and no slope there"
        } else if renderer.buffers == Buffers::Axis && !renderer.splats_light() {
            "in the volume's own sheets: each is an integral along the ray, and has no slope across its layer"
        } else {
            ""
        };
        if !why.is_empty() {
            return Err(unsupported(Feature::AnalyticGradients, format!("analytic gradients {why}")));
        }
    }
    if samples > i32::MAX as usize {
        return Err(unsupported(Feature::Size, "shading of 2³¹ voxels or points and more"));
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
