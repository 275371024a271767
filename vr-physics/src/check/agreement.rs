//! Pictures within the error that a renderer documents.

use proptest::strategy::Strategy;
use vr_core::{Control, Frame, Model, Renderer, Scene, View};

use super::drawn::{ReferencePixels, draw};
use super::effort::{Effort, Verdict};
use super::outcome::{CheckFailure, Report};
use super::test_scene::TestScene;
use crate::Metrics;

/// Every component of every pixel lies within `bound` of the canonical pixel (relative to max(1, largest magnitude of the
/// picture), as [`Metrics::max`] is), over [tame scenes](super::strategies).
///
/// `bound` is the error that the renderer documents for a scene and a view; if it is +∞, the scene is skipped. The
/// reference's own uncertainty comes on top; where that is larger than the bound, the scene is skipped, too.
///
/// # Errors
/// The failure, with a scene that shows it.
pub fn agrees_with_reference(
    renderer: &dyn Renderer,
    bound: impl Fn(&Scene, &View) -> f64,
    effort: &Effort,
) -> Result<Report, CheckFailure> {
    agrees_with_reference_on(renderer, effort.tame_scene(), bound, effort)
}

/// The check [`agrees_with_reference`] over the caller's own scenes.
///
/// # Errors
/// The failure, with a scene that shows it.
pub fn agrees_with_reference_on(
    renderer: &dyn Renderer,
    scenes: impl Strategy<Value = TestScene>,
    bound: impl Fn(&Scene, &View) -> f64,
    effort: &Effort,
) -> Result<Report, CheckFailure> {
    effort.over("agrees with the reference", renderer, scenes, |test| {
        let allowed = bound(&test.scene, &test.view);
        if allowed == f64::INFINITY {
            return Ok(Verdict::Skipped);
        }
        let frame = draw(renderer, test, &Control::default())?;
        Ok(judge(&frame, ReferencePixels::solve(&effort.reference, test, &Model::Canonical)?, allowed))
    })
}

/// Every component of every pixel lies within `bound` of the model that the renderer integrates
/// ([`Prepared::model`](vr_core::Prepared::model)), done exactly: only rounding and tables are left, and the scenes may be any
/// that a strategy of [`super::strategies`] draws.
///
/// # Errors
/// The failure, with a scene that shows it.
pub fn agrees_with_its_model(
    renderer: &dyn Renderer,
    scenes: impl Strategy<Value = TestScene>,
    bound: impl Fn(&Scene, &View) -> f64,
    effort: &Effort,
) -> Result<Report, CheckFailure> {
    effort.over("agrees with its own model", renderer, scenes, |test| {
        let allowed = bound(&test.scene, &test.view);
        if allowed == f64::INFINITY {
            return Ok(Verdict::Skipped);
        }
        let control = Control::default();
        let mut prepared = renderer.prepare(&test.scene, &control)?;
        let frame = prepared.render(&test.view, &control)?.frame;
        let model = prepared.model(&test.view)?;
        Ok(judge(&frame, ReferencePixels::solve(&effort.reference, test, &model)?, allowed))
    })
}

/// Compares a frame with the reference; skipped if the reference is less certain than `allowed`.
fn judge(frame: &Frame, expected: Option<ReferencePixels>, allowed: f64) -> Verdict {
    match expected {
        Some(expected) if expected.uncertainty <= allowed => {
            let error = Metrics::of(&expected.pixels, frame.pixels()).max;
            Verdict::within(error, allowed + expected.uncertainty, || "largest error".to_owned())
        }
        _ => Verdict::Skipped,
    }
}
