//! What the caster can draw, and what it says of the rest.

use std::sync::Arc;

use vr_core::{Compositing, Feature, Filter, GridVolume, Projection, RenderError, Scene, Unsupported, View};

use crate::caster::{
    Classification, Connectivity, Leaping, Order, Precision, RayCaster, Rule, Screen, Step, Traversal,
};

pub(crate) fn unsupported(feature: Feature, what: impl Into<String>) -> RenderError {
    Unsupported { renderer: RayCaster::NAME, feature, what: what.into() }.into()
}

/// Whether this caster can draw this scene; its volume, if so.
pub(crate) fn check(caster: &RayCaster, scene: &Scene) -> Result<Arc<GridVolume>, RenderError> {
    caster.validate()?;
    scene.validate()?;
    if caster.order == Order::BackToFront && scene.compositing != Compositing::Over {
        return Err(unsupported(
            Feature::Compositing,
            format!("compositing '{}' back to front", scene.compositing.name()),
        ));
    }
    if matches!(caster.step, Step::Local { .. }) && !caster.follows_light(scene) {
        let what = if caster.order == Order::BackToFront { "back to front" } else { scene.compositing.name() };
        return Err(unsupported(
            Feature::Setting,
            format!("local steps (local-error) under '{what}', where there is no light to follow: set a step"),
        ));
    }
    if let Order::FrontToBack { termination } = caster.order
        && !scene.compositing.integrates_light()
        // A termination of 1 asks for what is done anyway: no ray ends early.
        && ![Order::TERMINATION, 1.0].contains(&termination)
    {
        return Err(unsupported(
            Feature::Setting,
            format!("a termination under '{}': no opacity is gathered", scene.compositing.name()),
        ));
    }
    let samples_all = !scene.compositing.integrates_light() && !matches!(scene.compositing, Compositing::First { .. });
    let leaps =
        matches!(caster.step, Step::Vicinity { .. }) || !matches!(caster.leaping, Leaping::Auto | Leaping::None);
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
    let volume = scene.volume.grid();
    let volume = volume
        .ok_or_else(|| unsupported(Feature::VolumeKind, format!("volumes of the kind '{}'", scene.volume.kind())))?;
    let filter = volume.filter();
    if !caster.rule.goes_with(filter) {
        return Err(unsupported(
            Feature::Filter,
            format!("the filter '{filter}' by the rule '{}'", caster.rule.name()),
        ));
    }
    if matches!(caster.step, Step::Homogeneous { .. }) {
        if scene.compositing != Compositing::Over || caster.order == Order::BackToFront {
            return Err(unsupported(
                Feature::Setting,
                "homogeneous steps under anything but over, front to back".to_owned(),
            ));
        }
        if caster.rule != Rule::Midpoint {
            return Err(unsupported(
                Feature::Setting,
                "homogeneous steps by another rule than the midpoint's".to_owned(),
            ));
        }
        if scene.shading.is_some() {
            return Err(unsupported(
                Feature::Shading,
                "homogeneous steps with shading: values do not tell how it changes".to_owned(),
            ));
        }
    }
    Ok(Arc::clone(volume))
}

/// Checks that this caster can draw a view of a scene that it can draw.
pub(crate) fn check_view(caster: &RayCaster, view: &View) -> Result<(), RenderError> {
    let parallel = matches!(view.camera.projection, Projection::Orthographic { .. });
    if !parallel && matches!(caster.screen, Screen::Template { .. }) {
        return Err(unsupported(Feature::Perspective, "perspective with a template screen"));
    }
    Ok(())
}

/// What this caster's screen has no answer to.
fn beyond_screen(caster: &RayCaster, scene: &Scene) -> Option<String> {
    let compositing = format!("compositing '{}'", scene.compositing.name());
    let filter = scene.volume.filter().unwrap_or_default();
    let uneven = !matches!(caster.step, Step::Uniform(_)) || caster.traversal != Traversal::Samples;
    let uneven = uneven.then_some("steps that are not all of one length (set a step, in voxels)".to_owned());
    let found = match caster.screen {
        Screen::EveryPixel => vec![],
        // A promise for each pixel is none for what lies between them.
        Screen::Adaptive { .. } => {
            vec![matches!(caster.step, Step::Tolerance(_)).then_some("a promised error".to_owned())]
        }
        Screen::Coherent => vec![
            (!scene.compositing.integrates_light()).then_some(compositing),
            uneven,
            // What a table of segments shows cannot be told from the values at their ends.
            (!matches!(caster.rule, Rule::Midpoint | Rule::Left)).then(|| format!("the rule '{}'", caster.rule.name())),
        ],
        Screen::Template { connectivity } => {
            let own_values = connectivity == Connectivity::Discrete && filter == Filter::Nearest;
            vec![
                (scene.compositing != Compositing::Over).then_some(compositing),
                scene.shading.is_some().then_some("shading".to_owned()),
                scene.surfaces.is_some().then_some("opaque surfaces".to_owned()),
                (!own_values && filter != Filter::Trilinear).then(|| format!("the filter '{filter}'")),
                (caster.order == Order::BackToFront).then_some("compositing back to front".to_owned()),
                uneven,
                (caster.leaping != Leaping::Auto).then_some("a way of leaping".to_owned()),
                (caster.rule != Rule::Midpoint).then(|| format!("the rule '{}'", caster.rule.name())),
                (caster.precision == Precision::F64).then_some("64-bit precision".to_owned()),
                (caster.classification == Classification::Exact).then_some("exact classification".to_owned()),
            ]
        }
    };
    let what = found.into_iter().flatten().next()?;
    Some(format!("{what} with the screen '{}'", caster.screen.name()))
}
