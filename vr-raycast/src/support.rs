//! What the caster can draw, and what it says of the rest.

use vr_core::{Compositing, RenderError, Scene, UniformVolume};

use crate::caster::{Leaping, Order, RayCaster, Rule, Screen, Step};

pub(crate) fn unsupported(feature: String) -> RenderError {
    RenderError::Unsupported { renderer: RayCaster::NAME, feature }
}

/// Whether this caster can draw this scene; its volume, if so.
pub(crate) fn check<'s>(caster: &RayCaster, scene: &'s Scene) -> Result<&'s UniformVolume, RenderError> {
    caster.validate()?;
    scene.validate()?;
    if caster.order == Order::BackToFront && scene.compositing != Compositing::Over {
        return Err(unsupported(format!("compositing '{}' back to front", scene.compositing.name())));
    }
    if matches!(caster.step, Step::Local { .. }) && !caster.follows_light(scene) {
        let what = if caster.order == Order::BackToFront { "back to front" } else { scene.compositing.name() };
        return Err(unsupported(format!(
            "local steps (local-error) under '{what}', where there is no light to follow: set a step"
        )));
    }
    if let Order::FrontToBack { termination } = caster.order
        && !scene.compositing.integrates_light()
        // A termination of 1 asks for what is done anyway: no ray ends early.
        && ![Order::TERMINATION, 1.0].contains(&termination)
    {
        return Err(unsupported(format!("a termination under '{}': no opacity is gathered", scene.compositing.name())));
    }
    let samples_all = !scene.compositing.integrates_light() && !matches!(scene.compositing, Compositing::First { .. });
    let leaps = caster.step.finds_empty_space() || !matches!(caster.leaping, Leaping::Auto | Leaping::None);
    if samples_all && leaps {
        let what = scene.compositing.name();
        return Err(unsupported(format!("leaping over what is clear under '{what}', which depends on it, too")));
    }
    if let Some(what) = beyond_screen(caster, scene) {
        return Err(unsupported(what));
    }
    if caster.rule == Rule::Exact && !scene.compositing.integrates_light() {
        return Err(unsupported(format!("compositing '{}' by the rule 'exact'", scene.compositing.name())));
    }
    let filter = caster.filter_of(scene);
    if !caster.rule.goes_with(filter) {
        return Err(unsupported(format!("the filter '{filter}' by the rule '{}'", caster.rule.name())));
    }
    #[cfg(feature = "classics")]
    if let Some(what) = crate::classics::beyond_steps(caster, scene) {
        return Err(unsupported(what.to_owned()));
    }
    scene.volume.uniform().ok_or_else(|| unsupported(format!("volumes of the kind '{}'", scene.volume.kind())))
}

/// What this caster's screen has no answer to.
#[cfg_attr(not(feature = "classics"), expect(unused_variables, reason = "these screens draw every scene"))]
fn beyond_screen(caster: &RayCaster, scene: &Scene) -> Option<String> {
    let what = match caster.screen {
        Screen::EveryPixel => None,
        // A promise for each pixel is none for what lies between them.
        Screen::Adaptive { .. } => matches!(caster.step, Step::Tolerance(_)).then_some("a promised error".to_owned()),
        #[cfg(feature = "classics")]
        Screen::Coherent | Screen::Template { .. } => crate::classics::beyond_screen(caster, scene),
    }?;
    Some(format!("{what} with the screen '{}'", caster.screen.name()))
}
