//! A tile of the picture: its cells are drawn from front to back.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd};
use vr_core::{Counts, Layer, Rays, TransferFunction, View};
use vr_kernels::vector::{LANES, Lanes, Vectorized, pick, run, splat};

use crate::accumulators::Seen;

use super::classic::ClassicCell;
use super::lanes_of::{OutlineLanes, place_of};
use super::outline::Outline;
use super::projector::Attenuation;
use super::screen_mesh::{ScreenMesh, ScreenVertex};
use super::segment_table::SegmentTable;
use super::stamp::{SIDE, Segments, Stamp};
use super::tiling::Tiling;

/// Everything that a tile needs.
pub(super) struct Painter<'a> {
    pub(super) level: Level,
    pub(super) mesh: &'a ScreenMesh<'a>,
    pub(super) table: &'a SegmentTable,
    pub(super) transfer: &'a TransferFunction,
    pub(super) tiling: Tiling,
    pub(super) view: &'a View,
    pub(super) rays: &'a Rays,
    pub(super) layer: Option<&'a Layer>,
    /// Samples for each world unit at depth 1, in perspective; nothing in parallel projection.
    pub(super) focus: Option<f64>,
    /// True if rays are cut: by the clip, by opaque surfaces, or by the eye.
    pub(super) is_cut: bool,
    pub(super) attenuation: Attenuation,
    /// Transmittance below which nothing is added.
    pub(super) min_clear: f32,
}

/// Samples of a tile and the counts of the work.
pub(super) type TileResult = (Vec<Seen>, Counts);

impl Painter<'_> {
    /// Draws a tile of cells that are given from front to back; one value for each pixel.
    pub(super) fn draw(&self, tile: u32, cells: &[u32]) -> TileResult {
        run(self.level, TileJob { painter: self, tile, cells })
    }

    /// Length of the ray through a place in samples for a unit of depth.
    pub(super) fn along(&self, focus: f64, place: [f64; 2]) -> f64 {
        let away = [0, 1].map(|a| {
            let middle = 0.5 * f64::from(self.view.size[a] * self.tiling.per_pixel);
            (place[a] - middle) / focus
        });
        (1.0 + away[0] * away[0] + away[1] * away[1]).sqrt()
    }
}

/// The work on a tile.
struct TileJob<'a> {
    painter: &'a Painter<'a>,
    tile: u32,
    cells: &'a [u32],
}

/// Ends of the visible part of each ray of a stamp.
#[derive(Clone, Copy)]
struct Cut {
    near: Lanes,
    far: Lanes,
}

impl Vectorized for TileJob<'_> {
    type Output = TileResult;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> TileResult {
        let painter = self.painter;
        let tiling = &painter.tiling;
        let (first, pixels) = tiling.pixels_of(self.tile);
        let size = pixels.map(|n| n * tiling.per_pixel);
        let stamps = size.map(|n| n.div_ceil(SIDE));
        let origin = first.map(|n| n * tiling.per_pixel);
        let mut canvas = Canvas::new(painter, origin, size, stamps);
        let mut counts = Counts::default();
        let is_classic = painter.attenuation == Attenuation::Linear;

        for &cell in self.cells {
            if canvas.open == 0 {
                break;
            }
            let range = painter.mesh.range(cell as usize);
            let corners = painter
                .mesh
                .corners(cell as usize)
                .map(|c| ScreenVertex { at: [0, 1].map(|a| c.at[a] - f64::from(origin[a])), ..c });
            let Some([columns, rows]) = stamps_of(&corners, size) else { continue };
            let is_open = (rows[0]..rows[1]).any(|row| canvas.has_open(row, columns));
            if !is_open {
                counts.skipped += 1;
                continue;
            }
            let Some(outline) = Outline::new(&corners, painter.mesh.facing(cell as usize)) else { continue };
            let lanes = OutlineLanes::new(simd, &outline, range);
            let classic = is_classic.then(|| ClassicCell::new(simd, painter, (&outline, &corners), origin));
            for row in rows[0]..rows[1] {
                for column in columns[0]..columns[1] {
                    if !canvas.has_open(row, [column, column + 1]) {
                        continue;
                    }
                    let place = place_of([column, row]);
                    let Some(inside) = lanes.share(simd, place) else { continue };
                    let index = (row * stamps[0] + column) as usize;
                    counts.samples += u64::from(inside.0.to_bitmask().count_ones());
                    let stamp = &mut canvas.stamps[index];
                    let stays_open = if let Some(classic) = &classic {
                        classic.add(simd, stamp, &lanes, place, inside, painter.min_clear)
                    } else {
                        let mut segments = lanes.segments(simd, place, inside, canvas.along.get(index));
                        if let Some(cut) = canvas.cuts.get(index) {
                            segments = cut.applied(simd, &segments);
                        }
                        stamp.add(simd, &painter.table.intervals, &segments, painter.min_clear)
                    };
                    if !stays_open {
                        canvas.close(row, column);
                    }
                }
            }
        }
        let seen = canvas.pixels(painter, first, pixels, &mut counts);
        (seen, counts)
    }
}

/// Stamps whose samples a cell's box holds, along both axes; `None` if it holds no sample.
#[inline(always)]
fn stamps_of(corners: &[ScreenVertex; 4], size: [u32; 2]) -> Option<[[u32; 2]; 2]> {
    let mut stamps = [[0; 2]; 2];
    for a in 0..2 {
        let [p, q, r, s] = corners.map(|c| c.at[a]);
        let low = (p.min(q).min(r.min(s)) - 0.5).ceil().max(0.0);
        let high = (p.max(q).max(r.max(s)) - 0.5).floor().min(f64::from(size[a]) - 1.0);
        if low > high {
            return None;
        }
        stamps[a] = [low as u32 / SIDE, high as u32 / SIDE + 1];
    }
    Some(stamps)
}

impl Cut {
    /// The parts of segments between both ends.
    #[inline(always)]
    fn applied<S: Simd>(&self, simd: S, segments: &Segments<S>) -> Segments<S> {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let (near, length) = (segments.near, segments.length);
        let is_empty = length.simd_le(zero);
        let per_length = pick(is_empty, zero, one / pick(is_empty, one, length));
        let part = |at: &Lanes| ((at.load(simd) - near) * per_length).max(zero).min(one);
        let (start, end) = (part(&self.near), part(&self.far));
        let [a, b] = segments.ends;
        let rise = b - a;
        Segments {
            ends: [a + rise * start, a + rise * end],
            near: near + length * start,
            length: (length * (end - start)).max(zero),
        }
    }
}

/// Samples of a tile, stamp by stamp.
struct Canvas {
    stamps: Vec<Stamp>,
    across: u32,
    /// Stamps of each row that are not opaque, and their number.
    rows: Vec<u32>,
    open: u32,
    /// In perspective, length of each ray for a unit of depth.
    along: Vec<Lanes>,
    cuts: Vec<Cut>,
}

impl Canvas {
    fn new(painter: &Painter<'_>, origin: [u32; 2], size: [u32; 2], [across, down]: [u32; 2]) -> Self {
        let count = (across * down) as usize;
        let mut canvas = Self {
            stamps: vec![Stamp::EMPTY; count],
            across,
            rows: vec![((1u64 << across) - 1) as u32; down as usize],
            open: across * down,
            along: Vec::new(),
            cuts: Vec::new(),
        };
        if painter.focus.is_some() {
            canvas.along = vec![Lanes::ZERO; count];
        }
        if painter.is_cut {
            canvas.cuts = vec![Cut { near: Lanes::ZERO, far: Lanes::ZERO }; count];
        }
        for index in 0..count {
            for lane in 0..LANES {
                let local = [
                    index as u32 % across * SIDE + lane as u32 % SIDE,
                    index as u32 / across * SIDE + lane as u32 / SIDE,
                ];
                if local[0] >= size[0] || local[1] >= size[1] {
                    // Beyond the picture: opaque from the beginning.
                    canvas.stamps[index].clear.0[lane] = 0.0;
                    continue;
                }
                canvas.set_up(painter, [0, 1].map(|a| origin[a] + local[a]), (index, lane));
            }
        }
        canvas
    }

    /// Notes the length and the ends of a sample's ray.
    fn set_up(&mut self, painter: &Painter<'_>, sample: [u32; 2], (index, lane): (usize, usize)) {
        let per_pixel = painter.tiling.per_pixel;
        if let Some(focus) = painter.focus {
            self.along[index].0[lane] = painter.along(focus, sample.map(|n| f64::from(n) + 0.5)) as f32;
        }
        if painter.is_cut {
            let [x, y] = sample.map(|n| (f64::from(n) + 0.5) / f64::from(per_pixel));
            let pixel = sample.map(|n| n / per_pixel);
            let number = (pixel[1] * painter.view.size[0] + pixel[0]) as usize;
            let far = painter.layer.map_or(f64::INFINITY, |layer| layer.depth(number));
            // Where nothing is left, both ends are the eye.
            if let Some([from, to]) = painter.rays.at(x, y).inside(&painter.view.clip) {
                self.cuts[index].near.0[lane] = from as f32;
                self.cuts[index].far.0[lane] = to.min(far) as f32;
            }
        }
    }

    /// True if one of some stamps of a row is not opaque.
    #[inline(always)]
    fn has_open(&self, row: u32, [from, to]: [u32; 2]) -> bool {
        let mask = ((1u64 << to) - (1u64 << from)) as u32;
        self.rows[row as usize] & mask != 0
    }

    /// Notes that a stamp is opaque.
    #[inline(always)]
    fn close(&mut self, row: u32, column: u32) {
        self.rows[row as usize] &= !(1 << column);
        self.open -= 1;
    }

    /// The pixels of the tile.
    fn pixels(&self, painter: &Painter<'_>, first: [u32; 2], pixels: [u32; 2], counts: &mut Counts) -> Vec<Seen> {
        let n = painter.tiling.per_pixel;
        let share = 1.0 / f64::from(n * n);
        let mut seen = Vec::with_capacity((pixels[0] * pixels[1]) as usize);
        for y in 0..pixels[1] {
            for x in 0..pixels[0] {
                let number = ((first[1] + y) * painter.view.size[0] + first[0] + x) as usize;
                let mut mean = Seen { rgba: [0.0; 4], depth: f64::INFINITY };
                for k in 0..n * n {
                    let [column, row] = [x * n + k % n, y * n + k / n];
                    let stamp = &self.stamps[(row / SIDE * self.across + column / SIDE) as usize];
                    let lane = (row % SIDE * SIDE + column % SIDE) as usize;
                    let clear = f64::from(stamp.clear.0[lane]);
                    let alpha = 1.0 - clear;
                    let [r, g, b] = [0, 1, 2].map(|c| f64::from(stamp.light[c].0[lane]));
                    counts.rays += u64::from(alpha > 0.0);
                    counts.terminated += u64::from(clear <= f64::from(painter.min_clear));
                    let seen = Seen { rgba: [r, g, b, alpha], depth: f64::from(stamp.depth.0[lane]) };
                    let seen = seen.before(painter.layer, number);
                    (0..4).for_each(|c| mean.rgba[c] += seen.rgba[c] * share);
                    mean.depth = mean.depth.min(seen.depth);
                }
                seen.push(mean);
            }
        }
        seen
    }
}
