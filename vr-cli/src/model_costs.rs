//! Cost of simpler models of light, measured by random paths in a small picture.

use serde::Serialize;
use vr_core::{Control, Model, RenderError, Renderer, Scene, View};
use vr_light::{LightModel, LightRenderer};
use vr_physics::metrics::subgrid;
use vr_study::reference::ReferencePixels;
use vr_study::subject::reduced;

/// Pixels of the picture.
const PIXELS: f64 = 32.0 * 32.0;
/// Paths of each pixel of a model's picture; its noise is subtracted.
const PATHS: u32 = 256;

/// Error of a model against the whole equation, as RMS over the components of a picture's pixels.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct MeasuredCost {
    #[serde(skip)]
    pub model: LightModel,
    /// Estimate; 0 where noise hides it.
    pub rms: f64,
    /// Bound of it that holds with a probability of 97.5 %.
    pub at_most: f64,
}

/// Measures the error of emission-absorption and of single scattering: random paths that end at their first or second scattering.
///
/// # Errors
/// A scene that the renderer of light refuses, or cancellation.
pub fn measure((scene, view): (&Scene, &View), control: &Control) -> Result<Vec<MeasuredCost>, RenderError> {
    let small = reduced(view, PIXELS);
    let pixels = subgrid(u32::MAX, small.size);
    let whole = ReferencePixels::solve((scene, &small), &Model::Canonical, pixels, control)?;
    let models = [(LightModel::EmissionAbsorption, 0), (LightModel::SingleScattering, 1)];
    let cost = |(model, scatterings)| {
        let renderer = LightRenderer { paths: PATHS, max_scatterings: Some(scatterings), ..LightRenderer::default() };
        let frame = renderer.prepare(scene, control)?.render(&small, control)?.frame;
        let account = whole.noise_account(&frame).expect("a scene that scatters has a reference with noise");
        Ok(MeasuredCost { model, rms: account.bias(), at_most: account.bias_bound })
    };
    models.into_iter().map(cost).collect()
}
