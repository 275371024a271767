//! Capabilities of the renderer: scenes and views that it can draw, and errors for the rest.

use std::sync::Arc;

use vr_core::{Compositing, Configurable, Feature, Filter, GridVolume, RenderError, Scene, Unsupported};
use vr_kernels::tables::beyond_f32;

use crate::medium::follows_interpolant;
use crate::texture_slicer::{Blend, DrawOrder, Format, TextureSlicer};

pub(crate) fn unsupported(feature: Feature, what: impl Into<String>) -> RenderError {
    Unsupported { renderer: TextureSlicer::NAME, feature, what: what.into() }.into()
}

/// Returns the volume of a scene that this renderer can draw.
pub(crate) fn check(renderer: &TextureSlicer, scene: &Scene) -> Result<Arc<GridVolume>, RenderError> {
    renderer.validate()?;
    scene.validate()?;
    scene.without_scattering(TextureSlicer::NAME)?;
    let volume = scene
        .volume
        .value_grid()
        .ok_or_else(|| Unsupported::volume_kind(TextureSlicer::NAME, &scene.volume, Unsupported::GRIDS))?;
    // The volume.
    match volume.filter() {
        Filter::Trilinear => {}
        Filter::Nearest if renderer.is_pre_integrated() => {
            let why = "pre-integrated segments under the filter 'nearest': values go linearly along a segment, and these jump; take scalar";
            return Err(unsupported(Feature::Setting, why));
        }
        Filter::Nearest if follows_interpolant(scene) => {
            let why = "analytic gradients of the filter 'nearest', which are zero wherever there are any; take central differences";
            return Err(unsupported(Feature::AnalyticGradients, why));
        }
        Filter::Nearest => {}
        other => {
            let why =
                format!("the filter '{other}': textures are interpolated linearly, or the nearest texel is taken");
            return Err(unsupported(Feature::Filter, why));
        }
    }
    if volume.dims().iter().product::<usize>() > i32::MAX as usize {
        return Err(unsupported(Feature::Size, "volumes of 2³¹ voxels and more"));
    }
    if let Some(feature) = beyond_f32(volume, &scene.transfer) {
        return Err(unsupported(Feature::Precision, feature));
    }
    // Compositing.
    let picks = !scene.compositing.integrates_light();
    if picks && renderer.holds_light() {
        return Err(unsupported(
            Feature::Compositing,
            format!("compositing '{}' of light: take values", scene.compositing.name()),
        ));
    }
    if picks && renderer.is_pre_integrated() {
        let name = scene.compositing.name();
        let why =
            format!("pre-integrated segments under '{name}': a value is picked, and no light integrated; take scalar");
        return Err(unsupported(Feature::Setting, why));
    }
    if picks && !renderer.correction {
        let name = scene.compositing.name();
        let why = format!(
            "opacities without correction under '{name}': no opacity is gathered, and slabs count by their length"
        );
        return Err(unsupported(Feature::Setting, why));
    }
    if picks && renderer.sets_termination() {
        return Err(unsupported(
            Feature::Setting,
            format!("a termination under '{}': no opacity is gathered", scene.compositing.name()),
        ));
    }
    if renderer.blend == Blend::BackToFront {
        match scene.compositing {
            Compositing::Accumulate { level } if level < 1.0 => {
                return Err(unsupported(
                    Feature::Compositing,
                    "compositing 'accumulate' back to front: it ends at what is nearest",
                ));
            }
            _ if picks => {
                let name = scene.compositing.name();
                return Err(unsupported(
                    Feature::Compositing,
                    format!("compositing '{name}' back to front: nothing is blended"),
                ));
            }
            _ => {}
        }
    }
    check_texture(renderer, scene)?;
    Ok(Arc::clone(volume))
}

fn check_texture(renderer: &TextureSlicer, scene: &Scene) -> Result<(), RenderError> {
    if renderer.holds_light() && follows_interpolant(scene) {
        return Err(unsupported(
            Feature::AnalyticGradients,
            "analytic gradients in textures of light: these are classified and shaded at the voxels, where eight cells meet and the interpolant has no derivative; \
             take central differences, or values",
        ));
    }
    if renderer.format == Format::LuminanceAlpha {
        let grey = |c: [f64; 3]| c[0] == c[1] && c[1] == c[2];
        let rows = scene.transfer.rows().iter().flat_map(|row| row.transfer.points());
        let mut points = scene.transfer.points().iter().chain(rows);
        if scene.volume.has_colors() {
            return Err(unsupported(Feature::Color, "colours of voxels in textures of luminance and alpha"));
        }
        if !points.all(|p| grey(p.color) && grey(p.emission.unwrap_or_default())) {
            return Err(unsupported(Feature::Color, "colours in textures of luminance and alpha"));
        }
        if scene.reflection().is_some() && !scene.lights.iter().all(|light| grey(light.color)) {
            return Err(unsupported(Feature::Color, "lights of a colour on textures of luminance and alpha"));
        }
    }
    if renderer.brick.is_some() && renderer.order == DrawOrder::Slices {
        return Err(unsupported(
            Feature::Setting,
            "whole slices of bricks: a brick's slices are drawn while it is there, before the next brick's",
        ));
    }
    Ok(())
}
