//! Error map: how far the picture at rest is from the reference, pixel by pixel of a grid.

use serde::Serialize;
use vr_core::{Control, Frame, Model, RenderError, Renderer, Scene, View};
use vr_physics::metrics::subgrid;
use vr_study::error_colors;
use vr_study::reference::{ReferencePixels, SUBGRID};

/// Number of colours of a legend: more than a screen can tell apart along it.
const LEGEND: u32 = 61;

/// Errors of a picture on a grid of its pixels, with their colours. An error is the largest difference of any component of
/// premultiplied linear RGBA, in units of 1, or of the reference's largest component where that is more.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorMap {
    /// Width and height of the picture, in pixels.
    pub size: [u32; 2],
    /// Name of the renderer that drew it.
    pub renderer: String,
    /// Columns and rows of the grid; of each of its parts, one pixel is compared.
    pub parts: [u32; 2],
    /// Pixels that were compared, row by row of the grid: column and row.
    pub pixels: Vec<[u32; 2]>,
    /// Error of each; `None` where chance hides it: the reference itself is a mean over random paths.
    pub errors: Vec<Option<f64>>,
    /// Colour of each error, as a screen has it.
    pub colors: Vec<[u8; 3]>,
    /// RMSE of the pixels that were compared.
    pub rmse: f64,
    /// Largest error of these.
    pub max: f64,
    /// Errors at the ends of the scale of colours, which is logarithmic.
    pub ends: [f64; 2],
    /// Colours of the scale, evenly from its lower end to its upper one.
    pub legend: Vec<[u8; 3]>,
    /// Error of the reference itself, in words.
    pub certainty: String,
}

impl ErrorMap {
    /// Draws a picture and compares it.
    pub(super) fn of(
        (scene, view): (&Scene, &View),
        renderer: &dyn Renderer,
        control: &Control,
    ) -> Result<Self, RenderError> {
        let frame = renderer.prepare(scene, control)?.render(view, control)?.frame;
        let pixels = subgrid(SUBGRID, view.size);
        let exact = ReferencePixels::solve((scene, view), &Model::Canonical, pixels, control)?;
        let errors = exact.significant_errors(&frame);
        let metrics = exact.judge(&frame);
        let (low, high) = error_colors::DECADES;
        let last = f64::from(LEGEND - 1);
        Ok(Self {
            size: view.size,
            renderer: renderer.name().to_owned(),
            parts: view.size.map(|side| side.min(SUBGRID)),
            pixels: exact.pixels().to_vec(),
            colors: on_screen(errors.iter().map(|&error| error_colors::color(error))),
            errors: errors.into_iter().map(|error| (!error.is_nan()).then_some(error)).collect(),
            rmse: metrics.rmse,
            max: metrics.max,
            ends: [10f64.powi(low), 10f64.powi(high)],
            legend: on_screen((0..LEGEND).map(|i| error_colors::at(f64::from(i) / last))),
            certainty: exact.certainty_text(),
        })
    }
}

/// Linear colours as a screen has them.
fn on_screen(colors: impl Iterator<Item = [f32; 3]>) -> Vec<[u8; 3]> {
    let pixels: Vec<[f32; 4]> = colors.map(|[r, g, b]| [r, g, b, 1.0]).collect();
    let frame = Frame::new([pixels.len() as u32, 1], pixels, None);
    vr_io::screen_rgba(&frame, [0.0; 3]).chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect()
}
