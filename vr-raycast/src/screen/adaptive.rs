//! Sparse rays, refined where the colours differ; the rest interpolated.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use vr_core::image_order::Spot;
use vr_core::{Control, Counts, Frame, Layer, RenderError, RenderStats, Rendered, View};

use super::every_pixel::{every_pixel, spots_of_pixel};
use crate::tracer::{Traced, Tracer};

/// Pixels between the first rays. What is smaller than this and lies between them is missed, whatever the threshold. With 8 instead, a
/// twentieth of the rays was saved at most, and more was missed.
const COARSE: u32 = 4;
/// Pixels that one task traces.
const BATCH: usize = 512;

/// Draws a view by adaptive refinement (Levoy, *Volume rendering by adaptive refinement*, The Visual Computer 6, 1990).
///
/// Rays go through the corners of cells of 4×4 pixels first. A cell is quartered where a component of its corners' premultiplied
/// colours differs by more than `threshold`, or where one of the cells that touch it is, down to single pixels. What lies
/// between the corners of the cells that are left is interpolated bilinearly.
///
/// That all corners of a cell agree to `threshold` bounds what is inside it by no law: it does where the picture is monotone in the
/// cell (then the error is at most `threshold`), and something small may stand between the rays where it is not. The refined
/// neighbours are there because edges rarely end at a cell's side: where one is found, it is followed. The tests measure the
/// rest.
///
/// A threshold of 0 traces every pixel. Cells in which an opaque layer shows are traced whole: layers have edges that no corner
/// tells of. Depth is interpolated where all four corners have one, and taken from the nearest corner elsewhere.
///
/// The picture depends on scene, view and threshold alone, not on the number of threads.
pub(crate) fn adaptive(
    tracer: &impl Tracer,
    view: &View,
    threshold: f64,
    control: &Control,
) -> Result<Rendered, RenderError> {
    if threshold == 0.0 {
        return every_pixel(tracer, view, control);
    }
    let mut stats = RenderStats::default();
    let mut canvas = Canvas::new(view, control);
    let layer = view.layer.as_deref();
    let mut cells = Cells::first(view.size);
    // Per size, the largest first: smaller cells know better what lies on a common side.
    let mut left = Vec::new();
    stats.time("rays", || {
        while !cells.list.is_empty() {
            canvas.trace(tracer, cells.list.iter().flat_map(Cell::corners))?;
            let differing = cells.list.iter().map(|c| canvas.differs(c, threshold) || shows_layer(c, layer, view.size));
            let refined = cells.with_neighbours(differing.collect());
            let (split, whole): (Vec<_>, Vec<_>) = cells.list.iter().zip(refined).partition(|(_, refined)| *refined);
            left.push(whole.into_iter().map(|(cell, _)| *cell).collect::<Vec<_>>());
            cells = cells.quartered(split.into_iter().map(|(cell, _)| cell));
        }
        Ok::<_, RenderError>(())
    })?;
    stats.time("interpolation", || left.iter().flatten().for_each(|cell| canvas.fill(cell)));
    control.report(1.0);
    stats.counts = canvas.counts;
    Ok(Rendered { frame: Frame::new(view.size, canvas.rgba, Some(canvas.depth)), stats })
}

/// A rectangle of pixels whose corners are traced; the corners belong to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Cell {
    low: [u32; 2],
    high: [u32; 2],
    /// Place among the cells of its size.
    place: [u32; 2],
}

impl Cell {
    fn corners(&self) -> [[u32; 2]; 4] {
        let ([x0, y0], [x1, y1]) = (self.low, self.high);
        [[x0, y0], [x1, y0], [x0, y1], [x1, y1]]
    }

    /// Whether there is a pixel that is no corner.
    fn is_divisible(&self) -> bool {
        (0..2).any(|a| self.high[a] - self.low[a] > 1)
    }
}

/// The cells of one size that are looked at.
struct Cells {
    list: Vec<Cell>,
    /// How many there would be across the whole picture.
    across: [u32; 2],
}

impl Cells {
    /// The cells that every picture begins with. The last of a row or column may be narrower.
    fn first(size: [u32; 2]) -> Self {
        let across = size.map(|n| (n - 1).div_ceil(COARSE).max(1));
        let mut list = Vec::new();
        for y in 0..across[1] {
            for x in 0..across[0] {
                let place = [x, y];
                let low = place.map(|p| p * COARSE);
                list.push(Cell { low, high: [0, 1].map(|a| (low[a] + COARSE).min(size[a] - 1)), place });
            }
        }
        Self { list, across }
    }

    /// Marks the divisible cells that are marked themselves or touch one that is.
    fn with_neighbours(&self, marked: Vec<bool>) -> Vec<bool> {
        let [across, down] = self.across.map(i64::from);
        let mut near = vec![false; (across * down) as usize];
        for cell in self.list.iter().zip(marked).filter_map(|(cell, marked)| marked.then_some(cell)) {
            let [x, y] = cell.place.map(i64::from);
            for y in (y - 1).max(0)..=(y + 1).min(down - 1) {
                for x in (x - 1).max(0)..=(x + 1).min(across - 1) {
                    near[(y * across + x) as usize] = true;
                }
            }
        }
        let is_near = |c: &Cell| near[(i64::from(c.place[1]) * across + i64::from(c.place[0])) as usize];
        self.list.iter().map(|cell| cell.is_divisible() && is_near(cell)).collect()
    }

    /// The quarters of some of the cells; halves, where a cell is one pixel wide.
    fn quartered<'c>(&self, cells: impl Iterator<Item = &'c Cell>) -> Self {
        let mut list = Vec::new();
        for cell in cells {
            let halves = [0, 1].map(|a| {
                let (low, high) = (cell.low[a], cell.high[a]);
                let middle = low + (high - low) / 2;
                if high - low > 1 { vec![(low, middle, 0), (middle, high, 1)] } else { vec![(low, high, 0)] }
            });
            for &(y0, y1, py) in &halves[1] {
                for &(x0, x1, px) in &halves[0] {
                    let place = [2 * cell.place[0] + px, 2 * cell.place[1] + py];
                    list.push(Cell { low: [x0, y0], high: [x1, y1], place });
                }
            }
        }
        Self { list, across: self.across.map(|n| 2 * n) }
    }
}

/// Whether an opaque layer shows in a cell.
fn shows_layer(cell: &Cell, layer: Option<&Layer>, size: [u32; 2]) -> bool {
    let shows = |x: u32, y: u32, layer: &Layer| layer.depth((y * size[0] + x) as usize) < f64::INFINITY;
    layer.is_some_and(|layer| {
        (cell.low[1]..=cell.high[1]).any(|y| (cell.low[0]..=cell.high[0]).any(|x| shows(x, y, layer)))
    })
}

/// The picture as far as it is known.
struct Canvas<'a> {
    view: &'a View,
    control: &'a Control,
    rgba: Vec<[f32; 4]>,
    depth: Vec<f32>,
    traced: Vec<bool>,
    done: AtomicUsize,
    counts: Counts,
}

impl<'a> Canvas<'a> {
    fn new(view: &'a View, control: &'a Control) -> Self {
        let n = view.size[0] as usize * view.size[1] as usize;
        Self {
            view,
            control,
            rgba: vec![[0.0; 4]; n],
            depth: vec![f32::INFINITY; n],
            traced: vec![false; n],
            done: AtomicUsize::new(0),
            counts: Counts::default(),
        }
    }

    fn index(&self, [x, y]: [u32; 2]) -> usize {
        y as usize * self.view.size[0] as usize + x as usize
    }

    /// Traces the pixels among these that are not traced yet.
    fn trace(&mut self, tracer: &impl Tracer, pixels: impl Iterator<Item = [u32; 2]>) -> Result<(), RenderError> {
        let mut wanted = Vec::new();
        for pixel in pixels {
            let i = self.index(pixel);
            if !std::mem::replace(&mut self.traced[i], true) {
                wanted.push(pixel);
            }
        }
        // Neighbours together, in tiles of 32×32 and blocks of 4×4, as far as they are dense.
        wanted.sort_unstable_by_key(|&[x, y]| (y / 32, x / 32, y / 4, x / 4, y, x));
        let (view, control, done) = (self.view, self.control, &self.done);
        let all = self.rgba.len() as f64;
        let batch = |pixels: &[[u32; 2]]| {
            control.check()?;
            let spots: Vec<Spot> = pixels.iter().flat_map(|&pixel| spots_of_pixel(view, pixel)).collect();
            let (mut values, mut counts) = (Vec::with_capacity(spots.len()), Counts::default());
            tracer.trace(&spots, None, &mut values, &mut counts);
            let rays = (view.samples * view.samples) as usize;
            let means = values.chunks_exact(rays).map(Traced::mean).collect::<Vec<_>>();
            let finished = done.fetch_add(pixels.len(), Ordering::Relaxed) + pixels.len();
            control.report(finished as f64 / all);
            Ok((means, counts))
        };
        let batches: Result<Vec<_>, RenderError> =
            control.run(|| wanted.par_chunks(BATCH).with_max_len(1).map(batch).collect());
        for (pixels, (values, counts)) in wanted.chunks(BATCH).zip(batches?) {
            self.counts += counts;
            for (&pixel, value) in pixels.iter().zip(values) {
                let i = self.index(pixel);
                (self.rgba[i], self.depth[i]) = (value.rgba, value.depth);
            }
        }
        Ok(())
    }

    /// Whether a component differs between corners by more than `threshold`.
    fn differs(&self, cell: &Cell, threshold: f64) -> bool {
        let colors = cell.corners().map(|pixel| self.rgba[self.index(pixel)]);
        (0..4).any(|c| {
            let of = |f: fn(f32, f32) -> f32| f64::from(colors.iter().map(|color| color[c]).reduce(f).unwrap_or(0.0));
            of(f32::max) - of(f32::min) > threshold
        })
    }

    /// Interpolates what is not traced.
    fn fill(&mut self, cell: &Cell) {
        let corners = cell.corners().map(|pixel| self.index(pixel));
        let colors = corners.map(|i| self.rgba[i]);
        let depths = corners.map(|i| self.depth[i]);
        let seen_everywhere = depths.iter().all(|d| d.is_finite());
        let share = |a: usize, at: u32| {
            let (low, high) = (cell.low[a], cell.high[a]);
            if high == low { 0.0 } else { (at - low) as f32 / (high - low) as f32 }
        };
        for y in cell.low[1]..=cell.high[1] {
            for x in cell.low[0]..=cell.high[0] {
                let i = self.index([x, y]);
                if self.traced[i] {
                    continue;
                }
                let (u, v) = (share(0, x), share(1, y));
                // Weights that are not negative and sum to 1: nothing leaves the corners' range.
                let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
                let mean = |of: [f32; 4]| (0..4).map(|k| weights[k] * of[k]).sum::<f32>();
                self.rgba[i] = std::array::from_fn(|c| mean(colors.map(|color| color[c])));
                self.depth[i] = if seen_everywhere {
                    mean(depths)
                } else {
                    depths[usize::from(v > 0.5) * 2 + usize::from(u > 0.5)]
                };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::Camera;

    /// A picture given by a formula in pixels.
    struct Painting<F>(F);

    impl<F: Fn(f64, f64) -> f64 + Sync> Tracer for Painting<F> {
        fn trace(&self, spots: &[Spot], _: Option<&[u32]>, values: &mut Vec<Traced>, counts: &mut Counts) {
            counts.rays += spots.len() as u64;
            values.extend(spots.iter().map(|s| Traced { rgba: [self.0(s.x, s.y) as f32; 4], ..Traced::NOTHING }));
        }
    }

    fn view(size: [u32; 2]) -> View {
        View::new(Camera::framing((glam::DVec3::ZERO, glam::DVec3::ONE), 0.0, 0.0, None), size)
    }

    fn draw(size: [u32; 2], threshold: f64, f: impl Fn(f64, f64) -> f64 + Sync) -> Rendered {
        adaptive(&Painting(f), &view(size), threshold, &Control::default()).unwrap()
    }

    fn largest_error(size: [u32; 2], threshold: f64, f: impl Fn(f64, f64) -> f64 + Sync) -> f64 {
        let found = draw(size, threshold, &f).frame;
        let mut error: f64 = 0.0;
        for y in 0..size[1] {
            for x in 0..size[0] {
                let want = f(f64::from(x) + 0.5, f64::from(y) + 0.5);
                error = error.max((f64::from(found.pixel(x, y)[0]) - want).abs());
            }
        }
        error
    }

    #[test]
    fn a_plane_takes_the_first_rays_only() {
        let drawn = draw([65, 33], 0.5, |x, y| 0.001 * x + 0.002 * y);
        assert_eq!(drawn.stats.counts.rays, 17 * 9);
        assert!(largest_error([65, 33], 0.5, |x, y| 0.001 * x + 0.002 * y) < 1e-6);
    }

    #[test]
    fn monotone_pictures_are_within_the_threshold() {
        for size in [[1, 1], [1, 17], [23, 1], [2, 2], [97, 89], [64, 64]] {
            for threshold in [0.01, 0.1, 0.5] {
                let error = largest_error(size, threshold, |x, y| libm::erf(0.05 * (x + 0.3 * y - 30.0)));
                // The rest is rounding.
                assert!(error <= threshold + 1e-6, "{size:?} {threshold}: {error}");
            }
        }
    }

    #[test]
    fn an_edge_is_followed_and_costs_few_rays() {
        // A disc: constant but for its rim, which every ray-cell that it crosses refines to pixels.
        let disc = |x: f64, y: f64| f64::from(u8::from((x - 64.0).hypot(y - 70.0) < 40.0));
        assert_eq!(largest_error([128, 131], 0.1, disc), 0.0);
        let rays = draw([128, 131], 0.1, disc).stats.counts.rays;
        assert!(rays < 128 * 131 / 2, "{rays}");
    }

    #[test]
    fn threshold_zero_is_every_pixel() {
        let drawn = draw([37, 11], 0.0, |_, _| 1.0);
        assert_eq!(drawn.stats.counts.rays, 37 * 11);
    }

    #[test]
    fn cells_cover_every_pixel_once_all_are_refined() {
        for size in [[1, 1], [1, 40], [41, 1], [9, 10], [31, 57]] {
            let checkers = |x: f64, y: f64| f64::from((x as u32 * 7919 + y as u32 * 104_729) % 17);
            assert_eq!(largest_error(size, 1e-6, checkers), 0.0, "{size:?}");
        }
    }

    #[test]
    fn a_layer_is_traced_where_it_shows() {
        let mut view = view([64, 64]);
        let shown = |i: usize| i == 64 * 20 + 13;
        let pixel = |i: usize| ([1.0, 0.0, 0.0], if shown(i) { 1.0 } else { f32::INFINITY });
        view.layer = Some(std::sync::Arc::new(Layer { pixels: (0..64 * 64).map(pixel).collect() }));
        let layered = view.layer.clone().unwrap();
        struct Layered(std::sync::Arc<Layer>);
        impl Tracer for Layered {
            fn trace(&self, spots: &[Spot], _: Option<&[u32]>, values: &mut Vec<Traced>, _: &mut Counts) {
                values.extend(spots.iter().map(|s| Traced::NOTHING.over(&self.0, s.pixel)));
            }
        }
        let frame = adaptive(&Layered(layered), &view, 0.1, &Control::default()).unwrap().frame;
        for (i, p) in frame.pixels().iter().enumerate() {
            assert_eq!(p[0], f32::from(u8::from(shown(i))), "{i}");
        }
    }
}
