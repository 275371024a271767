//! One picture of one scene, by the renderer under test and by the reference.

use vr_core::{Control, Frame, Model, RenderError, Renderer};

use super::test_scene::TestScene;
use crate::Reference;

/// A fresh picture.
pub(super) fn draw(renderer: &dyn Renderer, test: &TestScene, control: &Control) -> Result<Frame, RenderError> {
    Ok(renderer.prepare(&test.scene, control)?.render(&test.view, control)?.frame)
}

/// The reference of a picture, and its error relative to max(1, largest magnitude).
pub(super) struct ReferencePixels {
    pub pixels: Vec<[f64; 4]>,
    pub uncertainty: f64,
}

impl ReferencePixels {
    /// Solves a scene; `None` if the reference cannot.
    pub fn solve(reference: &Reference, test: &TestScene, model: &Model) -> Result<Option<Self>, RenderError> {
        let solution = match reference.solve(&test.scene, &test.view, model, &Control::default()) {
            Err(RenderError::Unsupported { .. }) => return Ok(None),
            other => other?,
        };
        let pixels: Vec<[f64; 4]> = solution.pixels.iter().map(|p| p.rgba).collect();
        let peak = pixels.iter().flatten().fold(1.0, |peak: f64, c| peak.max(c.abs()));
        let uncertainty = solution.pixels.iter().fold(0.0, |worst: f64, p| worst.max(p.certainty.value())) / peak;
        Ok(Some(Self { pixels, uncertainty }))
    }
}
