//! Adaptive rays: sparse ones, refined where the colours bend; the rest is interpolated.

mod canvas;
mod cells;

use vr_core::{Control, Layer, RenderError, RenderStats, Rendered, View};

use super::AdaptiveRays;
use super::every_pixel::every_pixel;
use crate::tracer::Tracer;
use canvas::Canvas;
use cells::Cells;

/// Distance of the first rays in pixels, which is also that of the tiles of [`ThinParts`](crate::thin_parts::ThinParts). A detail that is smaller and lies between them is found by these
/// alone. With 8 instead, 3 % of
/// the pixels' rays were saved at most, and more was missed.
pub(crate) const COARSE: usize = 4;

/// Part of the cells in which something shows, above which those that are refined are traced whole.
const MOSTLY: f64 = 0.9;

/// Draws a view by adaptive refinement, after Levoy (*Volume rendering by adaptive refinement*, The Visual Computer 6, 1990).
///
/// Rays go through the corners of cells of 4×4 pixels first. A cell is quartered where, at one of its corners, a component of the
/// premultiplied colours leaves the straight lines through the neighbouring corners by more than `threshold` (the sum of its second
/// differences along x and y), or where that is so for one of the cells that touch it; down to single pixels. Levoy refines where
/// corners differ, and so follows every slope; a slope that stays the same is interpolated exactly. What lies between the rays is
/// interpolated by cubics through four neighbours, x first: a smooth picture is right to the fourth order of the distance.
///
/// A cell may hold something small even though its corners lie on a line: it stands between the rays. Three things find most of it. First, the neighbours of
/// a cell that is refined are refined, too. Second, where the picture bends at the side of a refined cell, refinement goes on beyond that side, two pixels at
/// a time, until nothing bends: one ray that meets a thin line finds all of it. Third, every pixel is traced in cells in which [`ThinParts`](crate::thin_parts::ThinParts) show. How much is
/// still missed is measured by the tests.
///
/// If nearly all cells that show anything are to be refined, and nothing is known of what follows, every pixel in them is traced at once: packets of neighbouring pixels are so much faster than
/// packets of every other pixel that leaving some out would save nothing.
///
/// A threshold of 0 traces every pixel. Cells in which an opaque layer shows are traced whole: layers have edges that no corner
/// tells of. Depth is interpolated linearly where both neighbours have one, and taken from one of them elsewhere.
///
/// The picture depends on scene, view and threshold alone, not on the number of threads.
pub(crate) fn adaptive(
    tracer: &dyn Tracer,
    (view, layer): (&View, Option<&Layer>),
    AdaptiveRays { threshold, thin_parts, are_few }: AdaptiveRays<'_>,
    control: &Control,
) -> Result<Rendered, RenderError> {
    if threshold == 0.0 {
        return every_pixel(tracer, view, control);
    }
    let mut stats = RenderStats::default();
    let thin = match thin_parts {
        Some(thin) => stats.time("thin parts", || thin.tiles(view))?,
        None => Vec::new(),
    };
    let mut canvas = Canvas::new((view, layer), control, COARSE)?;
    let mut spacing = COARSE;
    let mut cells = Cells::all(canvas.points(spacing));
    // Cells that are traced whole, whatever their corners are.
    let mut whole = cells.among(&thin);
    let first = canvas.claim_all(spacing);
    stats.time("rays", || canvas.trace(tracer, &first, spacing))?;
    while spacing > 1 {
        if spacing < COARSE {
            follow(tracer, &mut canvas, (&mut cells, spacing), threshold as f32, &mut stats)?;
        }
        let refined = stats.time("refinement", || {
            let mut differing = cells.within(&canvas.bent(&cells, spacing, threshold as f32));
            differing.include(&canvas.cells_with_layer(spacing), &cells);
            differing.add(&whole);
            differing.grown(&cells)
        });
        if spacing == COARSE && !are_few && is_most_of(&refined, &cells.within(&canvas.seen(spacing))) {
            // Hardly any ray would be left out in them: those of neighbouring pixels run together.
            trace_whole(tracer, &mut canvas, refined, threshold as f32, &mut stats)?;
            break;
        }
        spacing /= 2;
        let wanted = refined.points(2, |at| canvas.claim(at, spacing));
        stats.time("rays", || canvas.trace(tracer, &wanted, spacing))?;
        stats.time("interpolation", || canvas.interpolate(spacing));
        cells = refined.quartered();
        whole = whole.quartered();
    }
    control.report(1.0);
    stats.counts = canvas.counts();
    let frame = stats.time("image", || canvas.into_frame());
    Ok(Rendered { frame, stats })
}

/// True if cells are nearly all of those in which something shows.
fn is_most_of(cells: &Cells, shown: &Cells) -> bool {
    cells.common(shown) as f64 > MOSTLY * shown.common(shown) as f64
}

/// Traces all pixels of cells of the coarse grid, and of others for as long as what is interpolated in them bends at the sides of these; interpolates the rest.
fn trace_whole(
    tracer: &dyn Tracer,
    canvas: &mut Canvas<'_>,
    mut cells: Cells,
    threshold: f32,
    stats: &mut RenderStats,
) -> Result<(), RenderError> {
    let all = Cells::all(canvas.points(COARSE));
    let pixels_of = |canvas: &mut Canvas<'_>, cells: &Cells| cells.points(COARSE as u32, |at| canvas.claim(at, 1));
    let pixels = pixels_of(canvas, &cells);
    stats.time("rays", || canvas.trace(tracer, &pixels, 1))?;
    interpolate_all(canvas, stats);
    let reach = |canvas: &Canvas<'_>, added: &Cells| {
        let pixels = (0..COARSE.ilog2()).fold(added.clone(), |cells, _| cells.quartered());
        all.touching(&canvas.bent(&pixels, 1, threshold), COARSE)
    };
    if spread(tracer, canvas, (&mut cells, 1), reach, pixels_of, stats)? {
        interpolate_all(canvas, stats);
    }
    Ok(())
}

/// Interpolates all points through which no ray goes from those of the coarse grid.
fn interpolate_all(canvas: &mut Canvas<'_>, stats: &mut RenderStats) {
    let finer = std::iter::successors(Some(COARSE / 2), |&finer| (finer > 1).then_some(finer / 2));
    stats.time("interpolation", || finer.for_each(|spacing| canvas.interpolate(spacing)));
}

/// Adds the cells, so many pixels apart, that touch what bends at a corner of others, and traces their corners, until nothing bends where they end.
fn follow(
    tracer: &dyn Tracer,
    canvas: &mut Canvas<'_>,
    (cells, spacing): (&mut Cells, usize),
    threshold: f32,
    stats: &mut RenderStats,
) -> Result<(), RenderError> {
    let all = Cells::all(canvas.points(spacing));
    let reach = |canvas: &Canvas<'_>, added: &Cells| added.within(&canvas.bent(added, spacing, threshold)).grown(&all);
    let corners_of = |canvas: &mut Canvas<'_>, cells: &Cells| cells.corners(|at| canvas.claim(at, spacing));
    spread(tracer, canvas, (cells, spacing), reach, corners_of, stats)?;
    Ok(())
}

/// Adds the cells that `reach` finds from the last ones that were added, and traces the points in them that `wanted` lists, so many pixels apart, until it finds
/// no more. Returns true if it found any.
fn spread(
    tracer: &dyn Tracer,
    canvas: &mut Canvas<'_>,
    (cells, spacing): (&mut Cells, usize),
    reach: impl Fn(&Canvas<'_>, &Cells) -> Cells,
    wanted: impl Fn(&mut Canvas<'_>, &Cells) -> Vec<[u32; 2]>,
    stats: &mut RenderStats,
) -> Result<bool, RenderError> {
    let (mut added, mut found) = (cells.clone(), false);
    loop {
        let reached = stats.time("refinement", || reach(canvas, &added).without(cells));
        if reached.is_empty() {
            return Ok(found);
        }
        let points = wanted(canvas, &reached);
        stats.time("rays", || canvas.trace(tracer, &points, spacing))?;
        cells.add(&reached);
        (added, found) = (reached, true);
    }
}

#[cfg(test)]
mod tests;
