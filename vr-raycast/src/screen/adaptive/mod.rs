//! Adaptive rays: sparse ones, refined where the colours bend; the rest is interpolated.

mod canvas;
mod cells;

use vr_core::{Control, Layer, RenderError, RenderStats, Rendered, View};

use super::every_pixel::every_pixel;
use crate::tracer::Tracer;
use canvas::Canvas;
use cells::Cells;

/// Distance of the first rays in pixels. A detail that is smaller and lies between them is missed, whatever the threshold. With 8 instead, 3 % of
/// the pixels' rays were saved at most, and more was missed.
const COARSE: usize = 4;

/// Draws a view by adaptive refinement, after Levoy (*Volume rendering by adaptive refinement*, The Visual Computer 6, 1990).
///
/// Rays go through the corners of cells of 4×4 pixels first. A cell is quartered where, at one of its corners, a component of the
/// premultiplied colours leaves the straight lines through the neighbouring corners by more than `threshold` (the sum of its second
/// differences along x and y), or where that is so for one of the cells that touch it; down to single pixels. Levoy refines where
/// corners differ, and so follows every slope; a slope that stays the same is interpolated exactly. What lies between the rays is
/// interpolated by cubics through four neighbours, x first: a smooth picture is right to the fourth order of the distance.
///
/// That all corners of a cell lie on a line bounds what is inside it by no law: something small may stand between the rays. The refined
/// neighbours are there because edges rarely end at a cell's side: where one is found, it is followed. The tests measure the rest.
///
/// A threshold of 0 traces every pixel. Cells in which an opaque layer shows are traced whole: layers have edges that no corner
/// tells of. Depth is interpolated linearly where both neighbours have one, and taken from one of them elsewhere.
///
/// The picture depends on scene, view and threshold alone, not on the number of threads.
pub(crate) fn adaptive(
    tracer: &dyn Tracer,
    (view, layer): (&View, Option<&Layer>),
    threshold: f64,
    control: &Control,
) -> Result<Rendered, RenderError> {
    if threshold == 0.0 {
        return every_pixel(tracer, view, control);
    }
    let mut stats = RenderStats::default();
    let mut canvas = Canvas::new((view, layer), control, COARSE);
    let mut spacing = COARSE;
    let mut cells = Cells::all(canvas.points(spacing));
    let first = canvas.claim_all(spacing);
    stats.time("rays", || canvas.trace(tracer, &first, spacing))?;
    while spacing > 1 {
        let refined = stats.time("refinement", || {
            let mut differing = cells.within(&canvas.bent(&cells, spacing, threshold as f32));
            differing.include(&canvas.cells_with_layer(spacing), &cells);
            differing.grown(&cells)
        });
        spacing /= 2;
        let wanted = refined.points(|at| canvas.claim(at, spacing));
        stats.time("rays", || canvas.trace(tracer, &wanted, spacing))?;
        stats.time("interpolation", || canvas.interpolate(spacing));
        cells = refined.quartered();
    }
    control.report(1.0);
    stats.counts = canvas.counts();
    let frame = stats.time("image", || canvas.into_frame());
    Ok(Rendered { frame, stats })
}

#[cfg(test)]
mod tests;
