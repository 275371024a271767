//! One picture of one scene, by the renderer under test and by the reference.

use std::collections::HashMap;
use std::sync::{Arc, LazyLock, Mutex};

use vr_core::parallel::locked;
use vr_core::{Control, Frame, Model, RenderError, Renderer};

use super::strategies::Kind;
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

/// Name of a scene that is the same each time it is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum SceneName {
    /// A hard case.
    Case(&'static str),
    /// The scene of a kind that a seed draws.
    Drawn(Kind, u64),
}

/// Canonical pixels of a scene; `None` if the reference cannot solve it.
pub(super) type Solution = Option<Arc<ReferencePixels>>;

/// Solutions of scenes that have names, by tolerance (its bits), kept as long as the process runs: checks of several renderers, and of several
/// settings of one, look at the same scenes.
static SOLUTIONS: LazyLock<Mutex<HashMap<(SceneName, u64), Solution>>> = LazyLock::new(Mutex::default);

/// Returns the canonical pixels of a scene that has a name, solved when first asked for.
pub(super) fn solve_once(reference: &Reference, name: SceneName, test: &TestScene) -> Result<Solution, RenderError> {
    let key = (name, reference.tolerance().to_bits());
    if let Some(solution) = locked(&SOLUTIONS).get(&key) {
        return Ok(solution.clone());
    }
    // No lock is held meanwhile: a thread that solves in parallel may take up work that asks for the same scene.
    let solution = ReferencePixels::solve(reference, test, &Model::Canonical)?.map(Arc::new);
    Ok(locked(&SOLUTIONS).entry(key).or_insert(solution).clone())
}
