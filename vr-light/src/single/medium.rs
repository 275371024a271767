//! Coefficients of the medium of a scene.

use std::sync::Arc;

use vr_core::scattering::{Albedo, Scattering};
use vr_core::{Feature, OpacityRule, RenderError, Scene, TransferFunction, Unsupported};

/// Largest opacity of a unit distance: a wall of opacity 1 is a medium so dense that light enters it by a fourteenth of that distance.
const MAX_OPACITY: f64 = 1.0 - 1e-6;

/// Scattering and emission at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coefficients {
    /// Scattering per world unit.
    pub(super) scattering: [f64; 3],
    /// Emission per world unit.
    pub(super) emission: [f64; 3],
}

/// The scene whose extinction the rays meet: under emission and absorption, without shading.
pub(super) fn unlit(scene: &Scene) -> Result<Scene, RenderError> {
    let refused = |feature, what: &str| Err(Unsupported { renderer: "light", feature, what: what.into() }.into());
    if !scene.compositing.integrates_light() {
        return refused(Feature::Compositing, "the compositing operator: it picks a value, and scatters no light");
    }
    if scene.volume.has_colors() || scene.volume.field().is_some_and(|f| f.values_are_codes()) {
        return refused(Feature::Color, "volumes with colours of their own under single scattering");
    }
    if scene.has_gradient_opacity() {
        return refused(Feature::GradientOpacity, "opacity that follows the gradient under single scattering");
    }
    scene.validate()?;
    let mut unlit = scene.clone();
    unlit.shading = None;
    unlit.scattering = None;
    unlit.surfaces = None;
    unlit.compositing = vr_core::Compositing::Over;
    let transfer = &scene.transfer;
    if transfer.rule() == OpacityRule::Power && transfer.points().iter().any(|p| p.opacity > MAX_OPACITY) {
        let mut points = transfer.points().to_vec();
        for point in &mut points {
            point.opacity = point.opacity.min(MAX_OPACITY);
        }
        unlit.transfer = Arc::new(TransferFunction::new(points, transfer.rule(), transfer.unit_distance())?);
    }
    Ok(unlit)
}

/// Coefficients where the field has this value.
pub(super) fn coefficients(transfer: &TransferFunction, scattering: &Scattering, value: f64) -> Coefficients {
    let at = transfer.at(value);
    let extinction = transfer.extinction(at.opacity);
    let albedo = scattering.albedo.of(at.color);
    let emission = match scattering.albedo {
        _ if transfer.has_emission() => at.emission,
        Albedo::Color => [0.0; 3],
        Albedo::Constant(albedo) => std::array::from_fn(|c| (1.0 - albedo[c]) * extinction * at.color[c]),
    };
    Coefficients { scattering: albedo.map(|a| a * extinction), emission }
}
