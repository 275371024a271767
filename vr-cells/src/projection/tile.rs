//! A tile of the picture: its cells are drawn from front to back.

use fearless_simd::{Level, Simd};
use vr_core::{Counts, Layer, Rays, TransferFunction, View};
use vr_kernels::vector::{LANES, Vectorized, run};

use crate::accumulators::Seen;

use super::cell_samples::CellSamples;
use super::classic::ClassicCell;
use super::outline::Outline;
use super::outline_lanes::OutlineLanes;
use super::projector::Attenuation;
use super::samples::Samples;
use super::screen_mesh::{Facing, ScreenMesh, ScreenVertex};
use super::segment_light::LightTable;
use super::segment_table::SegmentTable;
use super::severe_segments::SevereSegments;
use super::tile_rays::TileRays;
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

    /// Distances at which the ray of a sample begins and ends; `None` if nothing is left of it.
    pub(super) fn ends(&self, sample: [u32; 2]) -> Option<[f64; 2]> {
        let per_pixel = self.tiling.per_pixel;
        let [x, y] = sample.map(|n| (f64::from(n) + 0.5) / f64::from(per_pixel));
        let pixel = sample.map(|n| n / per_pixel);
        let far =
            self.layer.map_or(f64::INFINITY, |layer| layer.depth((pixel[1] * self.view.size[0] + pixel[0]) as usize));
        let [from, to] = self.rays.at(x, y).inside(&self.view.clip)?;
        Some([from, to.min(far)])
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

/// A cell's corners on the screen, how it faces the eye, and the range of its values.
#[derive(Clone, Copy, Default)]
struct FetchedCell {
    corners: [ScreenVertex; 4],
    facing: Facing,
    range: [f32; 2],
}

/// Cells that are fetched at a time.
const FETCHED: usize = 16;

impl FetchedCell {
    fn new(mesh: &ScreenMesh<'_>, cell: usize) -> Self {
        Self { corners: mesh.corners(cell), facing: mesh.facing(cell), range: mesh.range(cell) }
    }
}

impl Vectorized for TileJob<'_> {
    type Output = TileResult;
    const AVX2_ALONE: bool = cfg!(test);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> TileResult {
        let painter = self.painter;
        let tiling = &painter.tiling;
        let (first, pixels) = tiling.pixels_of(self.tile);
        let size = pixels.map(|n| n * tiling.per_pixel);
        let origin = first.map(|n| n * tiling.per_pixel);
        let rays = TileRays::new(painter, origin, size);
        let mut samples = Samples::new(size);
        let mut inside = CellSamples::new();
        let mut severe = SevereSegments::new();
        let light = LightTable { intervals: &painter.table.intervals, min_clear: painter.min_clear };
        let mut counts = Counts::default();
        let (perspective, is_classic) = (painter.focus.is_some(), painter.attenuation == Attenuation::Linear);

        // Cells are fetched some at a time: they lie here and there in memory, which is asked for all of them at once.
        let mut fetched = [FetchedCell::default(); FETCHED];
        for cells in self.cells.chunks(FETCHED) {
            for (place, &cell) in fetched.iter_mut().zip(cells) {
                *place = FetchedCell::new(painter.mesh, cell as usize);
            }
            if samples.open_count == 0 {
                break;
            }
            for FetchedCell { corners, facing, range } in &fetched[..cells.len()] {
                let corners = corners.map(|c| ScreenVertex { at: [0, 1].map(|a| c.at[a] - f64::from(origin[a])), ..c });
                if samples.has_opaque() && !samples.has_open(box_of(&corners, size)) {
                    counts.skipped += 1;
                    continue;
                }
                let Some(outline) = Outline::new(&corners, *facing) else { continue };
                inside.find(simd, &outline, &corners, size, &samples);
                if inside.count == 0 {
                    continue;
                }
                counts.samples += inside.count as u64;
                let lanes = OutlineLanes::new(&outline, &corners, *range, inside.sixteen(0)[0]);
                let classic = is_classic.then(|| ClassicCell::new(painter, (&outline, &corners), &lanes, origin));
                for first in (0..inside.count).step_by(LANES) {
                    let numbers = inside.sixteen(first);
                    let places = lanes.places(simd, numbers);
                    if let Some(classic) = &classic {
                        classic.add(simd, &mut samples, numbers, &lanes, places, painter.min_clear);
                        continue;
                    }
                    let ends = rays.as_ref().map(|rays| rays.load(simd, numbers));
                    let mut segments = lanes.segments(simd, places, ends.as_ref(), perspective);
                    if let (Some(ends), true) = (&ends, painter.is_cut) {
                        segments = ends.cut(simd, &segments);
                    }
                    light.add(simd, &mut samples, numbers, &segments, &mut severe);
                }
                severe.finish(simd, &light, &mut samples);
            }
        }
        let seen = samples.pixels(painter, first, pixels, &mut counts);
        (seen, counts)
    }
}

/// Columns and rows of samples whose centres a cell's box may hold.
#[inline(always)]
fn box_of(corners: &[ScreenVertex; 4], size: [u32; 2]) -> [[u32; 2]; 2] {
    let mut columns_rows = [[0; 2]; 2];
    for a in 0..2 {
        let [p, q, r, s] = corners.map(|c| c.at[a]);
        let most = f64::from(size[a]);
        let first = p.min(q).min(r.min(s)).clamp(0.0, most - 1.0) as u32;
        columns_rows[a] = [first, (p.max(q).max(r.max(s)).clamp(0.0, most) as u32 + 1).clamp(first + 1, size[a])];
    }
    columns_rows
}
