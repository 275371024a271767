//! What the caster can draw, and what it says of the rest.

use vr_core::{Compositing, RenderError, Scene, UniformVolume};

use crate::caster::{Order, RayCaster, Rule, Step, Traversal};

fn unsupported(feature: String) -> RenderError {
    RenderError::Unsupported { renderer: RayCaster::NAME, feature }
}

/// Whether this caster can draw this scene; its volume, if so.
pub(crate) fn check<'s>(caster: &RayCaster, scene: &'s Scene) -> Result<&'s UniformVolume, RenderError> {
    caster.validate()?;
    scene.validate()?;
    if caster.order == Order::BackToFront && scene.compositing != Compositing::Over {
        return Err(unsupported(format!("compositing '{}' back to front", scene.compositing.name())));
    }
    if caster.rule == Rule::Exact && !scene.compositing.integrates_light() {
        return Err(unsupported(format!("compositing '{}' by the rule 'exact'", scene.compositing.name())));
    }
    let filter = caster.filter_of(scene);
    if !caster.rule.goes_with(filter) {
        return Err(unsupported(format!("the filter '{filter}' by the rule '{}'", caster.rule.name())));
    }
    if matches!(caster.step, Step::Local { .. }) && caster.traversal == Traversal::Samples {
        if !scene.compositing.integrates_light() {
            return Err(unsupported(format!(
                "compositing '{}' in steps that follow the light",
                scene.compositing.name()
            )));
        }
        if caster.order == Order::BackToFront {
            return Err(unsupported("steps that follow the data, back to front".to_owned()));
        }
    }
    if matches!(caster.step, Step::Homogeneous { .. }) {
        if scene.compositing != Compositing::Over || caster.order == Order::BackToFront {
            return Err(unsupported("homogeneous steps under anything but over, front to back".to_owned()));
        }
        if caster.rule != Rule::Midpoint {
            return Err(unsupported("homogeneous steps by another rule than the midpoint's".to_owned()));
        }
        if scene.shading.is_some() {
            return Err(unsupported("homogeneous steps with shading: values do not tell how it changes".to_owned()));
        }
    }
    scene.volume.uniform().ok_or_else(|| unsupported(format!("volumes of the kind '{}'", scene.volume.kind())))
}
