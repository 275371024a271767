//! Scenes and views that the caster can draw, and the errors for all others.

use glam::DVec3;
use vr_core::{
    Compositing, Configurable, Feature, Field, ParameterError, Projection, RenderError, Scene, Unsupported, View,
};

use crate::caster::{CompositingOrder, ImageSampling, RayCaster, Rule, Step, TransferLookup, Traversal, knows_ranges};
use crate::options::STEP;
use crate::source::Source;

pub(crate) fn unsupported(feature: Feature, what: impl Into<String>) -> RenderError {
    Unsupported { renderer: RayCaster::NAME, feature, what: what.into() }.into()
}

/// Checks that this caster can draw a scene. Returns the field that it casts rays through.
pub(crate) fn check(caster: &RayCaster, scene: &Scene) -> Result<Source, RenderError> {
    caster.validate()?;
    scene.validate()?;
    scene.without_scattering(RayCaster::NAME)?;
    if caster.order == CompositingOrder::BackToFront && scene.compositing != Compositing::Over {
        return Err(unsupported(
            Feature::Compositing,
            format!("compositing '{}' back to front", scene.compositing.name()),
        ));
    }
    if matches!(caster.step, Step::Local { .. }) && !caster.follows_light(scene) {
        let what =
            if caster.order == CompositingOrder::BackToFront { "back to front" } else { scene.compositing.name() };
        return Err(unsupported(
            Feature::Setting,
            format!("local steps (local-error) under '{what}', where there is no light to follow: set a step"),
        ));
    }
    if let CompositingOrder::FrontToBack { termination } = caster.order
        && !scene.compositing.integrates_light()
        // A termination of 1 asks for what is done anyway: no ray ends early.
        && ![CompositingOrder::TERMINATION, 1.0].contains(&termination)
    {
        return Err(unsupported(
            Feature::Setting,
            format!("a termination under '{}': no opacity is gathered", scene.compositing.name()),
        ));
    }
    if caster.transfer_lookup == TransferLookup::Table && !scene.compositing.integrates_light() {
        return Err(unsupported(
            Feature::Setting,
            format!(
                "classification=table under '{}', which looks at values: set auto or exact",
                scene.compositing.name()
            ),
        ));
    }
    if matches!(caster.rule, Rule::Linear | Rule::Quadratic) && !scene.compositing.integrates_light() {
        let (rule, operator) = (caster.rule.name(), scene.compositing.name());
        let what =
            format!("the rule '{rule}' under '{operator}', where no step is integrated: set rule=midpoint or left");
        return Err(unsupported(Feature::Setting, what));
    }
    let samples_all = !scene.compositing.integrates_light() && !matches!(scene.compositing, Compositing::First { .. });
    let leaps = caster.step.finds_empty_space() || caster.empty_space.is_named();
    if samples_all && leaps {
        let what = scene.compositing.name();
        return Err(unsupported(
            Feature::Setting,
            format!("leaping over what is clear under '{what}', which depends on it, too"),
        ));
    }
    if let Some(what) = beyond_screen(caster, scene) {
        return Err(unsupported(Feature::Setting, what));
    }
    if caster.rule == Rule::Exact && !scene.compositing.integrates_light() {
        return Err(unsupported(
            Feature::Compositing,
            format!("compositing '{}' by the rule 'exact'", scene.compositing.name()),
        ));
    }
    if scene.transfer.has_rows() && !matches!(caster.rule, Rule::Auto | Rule::Midpoint | Rule::Left) {
        let rule = caster.rule.name();
        let what = format!("a transfer function by gradient by the rule '{rule}', which integrates over values alone");
        return Err(unsupported(Feature::GradientOpacity, what));
    }
    let source = Source::of(&scene.volume).ok_or_else(|| {
        Unsupported::volume_kind(RayCaster::NAME, &scene.volume, "volumes in a box with finite edges")
    })?;
    check_step_count(caster, &source)?;
    let Source::Grid(volume) = &source else {
        check_field(caster, scene)?;
        return Ok(source);
    };
    if scene.volume.colors().is_some() {
        check_colors(caster)?;
    }
    let filter = volume.filter();
    if !caster.rule.goes_with(filter) {
        return Err(unsupported(
            Feature::Filter,
            format!("the filter '{filter}' by the rule '{}'", caster.rule.name()),
        ));
    }
    #[cfg(feature = "classics")]
    if let Some((feature, what)) = crate::classics::beyond_steps(caster, scene) {
        return Err(unsupported(feature, what));
    }
    Ok(source)
}

/// Most steps of a ray that are taken: more would take a second or longer, and a picture has some hundred thousand rays.
const MAX_STEPS: f64 = 1e8;

/// Checks that the longest ray through a field ends in reasonable time.
fn check_step_count(caster: &RayCaster, source: &Source) -> Result<(), RenderError> {
    let (placement, dims) = (source.placement(), source.dims());
    let diagonal = placement.axes() * DVec3::from_array(dims.map(|n| (n - 1) as f64));
    let steps = diagonal.length() / caster.world_step(placement);
    if steps <= MAX_STEPS {
        return Ok(());
    }
    let length = caster.step.length().unwrap_or(1.0);
    let found = format!("{length} of the smallest voxel edge, {steps:.1e} steps from corner to corner");
    Err(ParameterError { field: STEP.into(), found, allowed: "must take at most 1e8 steps; set a longer one" }.into())
}

/// Checks that this caster can draw a grid whose voxels have colours of their own.
fn check_colors(caster: &RayCaster) -> Result<(), RenderError> {
    let plain = matches!(caster.step, Step::Uniform(_) | Step::Local { .. } | Step::ErrorBound(_))
        && caster.traversal == Traversal::Samples
        && matches!(caster.rule, Rule::Auto | Rule::Midpoint | Rule::Left)
        && (matches!(
            caster.image_sampling,
            ImageSampling::Auto | ImageSampling::EveryPixel | ImageSampling::Adaptive { .. }
        ) || !caster.image_sampling.casts_pixels());
    if !plain {
        let what = "voxels with colours, except in uniform or local steps by the rule midpoint or left, which sample a step at one place, and with a promised error";
        return Err(unsupported(Feature::Setting, what));
    }
    Ok(())
}

/// Checks that this caster can draw a field that is no grid's: it can do all that needs no more than the field's values and gradients.
fn check_field(caster: &RayCaster, scene: &Scene) -> Result<(), RenderError> {
    let kind = scene.volume.kind();
    if caster.filter.is_some() {
        return Err(unsupported(Feature::Filter, format!("a filter over volumes of the kind '{kind}'")));
    }
    let follows = matches!(caster.step, Step::Local { .. }) && knows_ranges(&scene.volume);
    let plain = (matches!(caster.step, Step::Uniform(_) | Step::ErrorBound(_)) || follows)
        && caster.traversal == Traversal::Samples
        && matches!(caster.rule, Rule::Auto | Rule::Midpoint | Rule::Left)
        && !caster.empty_space.is_named()
        && matches!(
            caster.image_sampling,
            ImageSampling::Auto | ImageSampling::EveryPixel | ImageSampling::Adaptive { .. }
        );
    if !plain {
        let what = format!(
            "volumes of the kind '{kind}' but in {} steps by the rule midpoint or left: no more is known of them between samples",
            if knows_ranges(&scene.volume) { "uniform or local" } else { "uniform" }
        );
        return Err(unsupported(Feature::Setting, what));
    }
    if scene.shading.is_some() && !scene.volume.field().is_some_and(Field::has_gradient) {
        return Err(unsupported(
            Feature::Shading,
            format!("shading of volumes of the kind '{kind}' without a gradient"),
        ));
    }
    if scene.transfer.has_rows() && !scene.volume.field().is_some_and(Field::has_gradient) {
        let what = format!("a transfer function by gradient of volumes of the kind '{kind}', which have none");
        return Err(unsupported(Feature::GradientOpacity, what));
    }
    Ok(())
}

/// Checks that this caster can draw a view of a scene that it can draw.
pub(crate) fn check_view(caster: &RayCaster, view: &View) -> Result<(), RenderError> {
    let parallel = matches!(view.camera.projection, Projection::Orthographic { .. });
    if !parallel && !caster.image_sampling.casts_pixels() {
        let what = "perspective with a template screen: its rays are not parallel, and do not step alike";
        return Err(unsupported(Feature::Perspective, what));
    }
    Ok(())
}

/// Returns the part of a scene that this caster's choice of rays cannot draw.
#[cfg_attr(not(feature = "classics"), expect(unused_variables, reason = "these screens draw every scene"))]
fn beyond_screen(caster: &RayCaster, scene: &Scene) -> Option<String> {
    let what = match caster.image_sampling {
        ImageSampling::Auto | ImageSampling::EveryPixel => None,
        // A bound for each pixel is none for what lies between them.
        ImageSampling::Adaptive { .. } => {
            matches!(caster.step, Step::ErrorBound(_)).then_some("a promised error".to_owned())
        }
        #[cfg(feature = "classics")]
        ImageSampling::Coherent | ImageSampling::CBuffer | ImageSampling::Template { .. } => {
            crate::classics::beyond_screen(caster, scene)
        }
    }?;
    Some(format!("{what} with the screen '{}'", caster.image_sampling.name()))
}
