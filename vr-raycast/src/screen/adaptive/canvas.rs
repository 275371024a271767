//! Picture as far as it is known.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use vr_core::{Control, Counts, Frame, Layer, RenderError, View};

use super::cells::Cells;
use crate::screen::blocks::in_blocks;
use crate::screen::every_pixel::traced;
use crate::tracer::Tracer;

/// Number of pixels that one task traces.
const BATCH: usize = 256;

/// Picture at points one pixel apart. They begin with the view's pixels, and go on to the right and below until the coarse grid ends: all
/// cells are whole.
pub(super) struct Canvas<'a> {
    view: &'a View,
    layer: Option<&'a Layer>,
    control: &'a Control,
    /// Number of points across.
    across: usize,
    rows: Vec<Row>,
    done: AtomicUsize,
    counts: Counts,
}

#[derive(Clone, Debug, Default)]
struct Row {
    /// Premultiplied colours.
    rgba: Vec<[f32; 4]>,
    /// World distances to what is seen; +∞ where nothing is.
    depth: Vec<f32>,
    traced: Vec<bool>,
}

impl<'a> Canvas<'a> {
    /// Makes a canvas for a grid of points `coarse` pixels apart, and all finer ones.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`]: a large canvas takes a good part of a second to fill.
    pub(super) fn new(
        (view, layer): (&'a View, Option<&'a Layer>),
        control: &'a Control,
        coarse: usize,
    ) -> Result<Self, RenderError> {
        let [across, down] = view.size.map(|n| (n as usize - 1).div_ceil(coarse).max(1) * coarse + 1);
        let row = Row { rgba: vec![[0.0; 4]; across], depth: vec![f32::INFINITY; across], traced: vec![false; across] };
        let rows = (0..down).map(|_| control.check().map(|()| row.clone())).collect::<Result<_, _>>()?;
        Ok(Self { view, layer, control, across, rows, done: AtomicUsize::new(0), counts: Counts::default() })
    }

    pub(super) fn counts(&self) -> Counts {
        self.counts
    }

    /// Returns the numbers of points that are so many pixels apart, across and down.
    pub(super) fn points(&self, spacing: usize) -> [usize; 2] {
        [self.across, self.rows.len()].map(|n| (n - 1) / spacing + 1)
    }

    /// Claims a point, of those so many pixels apart; returns it unless a ray has gone through it or is about to.
    pub(super) fn claim(&mut self, at: [u32; 2], spacing: usize) -> bool {
        let [x, y] = at.map(|i| i as usize * spacing);
        !std::mem::replace(&mut self.rows[y].traced[x], true)
    }

    /// Claims all points so many pixels apart, in blocks of 4×4.
    pub(super) fn claim_all(&mut self, spacing: usize) -> Vec<[u32; 2]> {
        let mut points = Vec::new();
        in_blocks([0; 2], self.points(spacing).map(|n| n as u32), |at| {
            self.claim(at, spacing);
            points.push(at);
        });
        points
    }

    /// Traces points of those so many pixels apart.
    pub(super) fn trace(
        &mut self,
        tracer: &dyn Tracer,
        points: &[[u32; 2]],
        spacing: usize,
    ) -> Result<(), RenderError> {
        let (view, control, done) = (self.view, self.control, &self.done);
        let all = (self.across * self.rows.len()) as f64;
        let batch = |points: &[[u32; 2]]| {
            control.check()?;
            let pixels: Vec<[u32; 2]> = points.iter().map(|p| p.map(|i| i * spacing as u32)).collect();
            let traced = traced(tracer, view, &pixels);
            let finished = done.fetch_add(points.len(), Ordering::Relaxed) + points.len();
            control.report(finished as f64 / all);
            Ok(traced)
        };
        let batches: Result<Vec<_>, RenderError> =
            control.run(|| points.par_chunks(BATCH).with_max_len(1).map(batch).collect());
        for (points, (values, counts)) in points.chunks(BATCH).zip(batches?) {
            self.counts += counts;
            for (point, value) in points.iter().zip(values) {
                let [x, y] = point.map(|i| i as usize * spacing);
                let row = &mut self.rows[y];
                (row.rgba[x], row.depth[x]) = (value.rgba, value.depth);
            }
        }
        Ok(())
    }

    /// Marks the corners of cells, which lie so many pixels apart, at which the picture bends by more than `threshold`, row by row.
    pub(super) fn bent(&self, cells: &Cells, spacing: usize, threshold: f32) -> Vec<Vec<bool>> {
        let [nx, ny] = self.points(spacing);
        let row = |y: usize| &self.rows[y * spacing].rgba;
        let bent = |y: usize| {
            let mut marks = cells.corners_in_row(y);
            let (here, [above, below]) = (row(y), neighbours(y, ny).map(row));
            for (k, mark) in marks.iter_mut().enumerate().filter(|(_, mark)| **mark) {
                let (x, [left, right]) = (k * spacing, neighbours(k, nx).map(|k| k * spacing));
                let across = bend(&here[left], &here[x], &here[right]);
                let down = bend(&above[x], &here[x], &below[x]);
                *mark = (0..4).any(|c| across[c] + down[c] > threshold);
            }
            marks
        };
        self.control.run(|| (0..ny).into_par_iter().with_min_len(8).map(bent).collect())
    }

    /// Marks the points so many pixels apart at which anything shows, row by row.
    pub(super) fn seen(&self, spacing: usize) -> Vec<Vec<bool>> {
        let shows = |rgba: &[f32; 4]| rgba.iter().any(|&c| c > 0.0);
        let row = |row: &Row| row.rgba.iter().step_by(spacing).map(shows).collect();
        self.rows.iter().step_by(spacing).map(row).collect()
    }

    /// Returns the cells between points so many pixels apart in which an opaque layer shows.
    pub(super) fn cells_with_layer(&self, spacing: usize) -> Vec<[usize; 2]> {
        let Some(layer) = self.layer else { return Vec::new() };
        let [w, h] = self.view.size.map(|n| n as usize);
        let [nx, ny] = self.points(spacing).map(|n| n - 1);
        let shows = |&[x, y]: &[usize; 2]| {
            let (x, y) = (x * spacing, y * spacing);
            let pixels =
                (y..=(y + spacing).min(h - 1)).flat_map(|y| (x..=(x + spacing).min(w - 1)).map(move |x| [x, y]));
            pixels.into_iter().any(|[x, y]| layer.depth(y * w + x) < f64::INFINITY)
        };
        (0..ny).flat_map(|y| (0..nx).map(move |x| [x, y])).filter(shows).collect()
    }

    /// Fills the points so many pixels apart through which no ray goes, from those twice as far apart.
    pub(super) fn interpolate(&mut self, spacing: usize) {
        let Self { control, rows, .. } = self;
        control.run(|| {
            rows.par_iter_mut().step_by(2 * spacing).with_min_len(8).for_each(|row| row.fill_between(spacing));
            // The rows between are taken out, so that they can be written while the others are read.
            let step = 2 * spacing;
            let mut between: Vec<Row> = rows.iter_mut().skip(spacing).step_by(step).map(std::mem::take).collect();
            let count = rows.len().div_ceil(step);
            let known = |k: usize| &rows[k * step];
            between
                .par_iter_mut()
                .with_min_len(8)
                .enumerate()
                .for_each(|(k, row)| row.fill_from(known, k, count, spacing));
            rows.iter_mut().skip(spacing).step_by(step).zip(between).for_each(|(place, row)| *place = row);
        });
    }

    /// Returns the pixels of the view.
    pub(super) fn into_frame(self) -> Frame {
        let [w, h] = self.view.size.map(|n| n as usize);
        let (mut rgba, mut depth) = (vec![[0.0; 4]; w * h], vec![0.0; w * h]);
        self.control.run(|| {
            let rows = rgba.par_chunks_mut(w).zip(depth.par_chunks_mut(w)).zip(&self.rows);
            rows.with_min_len(32).for_each(|((rgba, depth), row)| {
                rgba.copy_from_slice(&row.rgba[..w]);
                depth.copy_from_slice(&row.depth[..w]);
            });
        });
        Frame::new(self.view.size, rgba, Some(depth))
    }
}

impl Row {
    /// Fills the points between each two that are twice as far apart, where no ray goes.
    fn fill_between(&mut self, spacing: usize) {
        let step = 2 * spacing;
        let count = self.rgba.len().div_ceil(step);
        for k in 0..count - 1 {
            let x = k * step + spacing;
            if !self.traced[x] {
                self.rgba[x] = midway(|k| self.rgba[k * step], k, count);
                self.depth[x] = depth_midway(self.depth[x - spacing], self.depth[x + spacing]);
            }
        }
    }

    /// Fills the points between the rows `k` and `k + 1`, of so many.
    fn fill_from<'r>(&mut self, rows: impl Fn(usize) -> &'r Self, k: usize, count: usize, spacing: usize) {
        for x in (0..self.rgba.len()).step_by(spacing) {
            if !self.traced[x] {
                self.rgba[x] = midway(|k| rows(k).rgba[x], k, count);
                self.depth[x] = depth_midway(rows(k).depth[x], rows(k + 1).depth[x]);
            }
        }
    }
}

/// Returns twice the distance of the middle one of three colours from the straight line through the others.
fn bend(a: &[f32; 4], middle: &[f32; 4], b: &[f32; 4]) -> [f32; 4] {
    std::array::from_fn(|c| (a[c] + b[c] - 2.0 * middle[c]).abs())
}

/// Returns the neighbours whose mean shows a bend: those beside `i`, of so many; at the ends, where there is none, those of the next point's do.
/// With only two points, any difference is a bend.
fn neighbours(i: usize, count: usize) -> [usize; 2] {
    match () {
        () if count < 3 => [0, count - 1],
        () if i == 0 || i + 1 == count => [i, i],
        () => [i - 1, i + 1],
    }
}

/// Returns the colour midway between `k` and `k + 1`, of so many at equal distances: on the cubic through those and the next on both sides. Beyond
/// the ends, it goes on straight.
///
/// From the mean of the two it is away by a sixteenth of the sum of the second differences there, so where nothing bends by more than
/// the threshold by an eighth of that at most. Light and opacity stay what they are: not negative, and no more than opaque.
fn midway(at: impl Fn(usize) -> [f32; 4], k: usize, count: usize) -> [f32; 4] {
    let (a, b) = (at(k), at(k + 1));
    let before = if k > 0 { at(k - 1) } else { straight_on(b, a) };
    let after = if k + 2 < count { at(k + 2) } else { straight_on(a, b) };
    std::array::from_fn(|c| {
        let cubic = (9.0 * (a[c] + b[c]) - (before[c] + after[c])) * (1.0 / 16.0);
        cubic.max(0.0).min(MOST[c].max(a[c].max(b[c])))
    })
}

/// Upper bounds of a colour: opacity is 1 at the most, but for rounding; light has no bound.
const MOST: [f32; 4] = [f32::INFINITY, f32::INFINITY, f32::INFINITY, 1.0];

/// Returns the next term of an arithmetic series.
fn straight_on(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|c| 2.0 * b[c] - a[c])
}

/// Returns the mean of two depths, or the first.
fn depth_midway(a: f32, b: f32) -> f32 {
    if a.is_finite() && b.is_finite() { 0.5 * (a + b) } else { a }
}
