//! Depths of texels, resampled onto the screen.
//!
//! A pixel has a depth where the coverage, linear between the texels, is a half at least: the opacity of light, or 1 where a texel has a depth and
//! 0 elsewhere. It is the mean of the depths around it that lie on one sheet ([`crate::sheet`]), at the place of the pixel's own ray, and
//! the smallest of a pixel's subpixels.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::DVec2;

use super::line::{Block, Bounds, LANES};
use super::{Beside, Cells, Warp};
use crate::ray_distances::RayDistances;
use crate::sheet::mean_of_sheet;

/// Depths of the texels of a warp.
pub(crate) struct DepthWarp<'a> {
    pub(crate) warp: &'a Warp<'a>,
    /// Row by row of the texture; infinite where a texel has none.
    pub(crate) depths: &'a [f32],
    /// Smallest rectangle around the texels that have one: first column, first row, and those behind the last.
    pub(crate) seen: [usize; 4],
    /// True if a texel's opacity covers, and not whether it has a depth.
    pub(crate) light: bool,
    pub(crate) distances: &'a RayDistances,
    /// Largest difference of two depths of one sheet.
    pub(crate) tolerance: f32,
}

impl DepthWarp<'_> {
    /// Draws row `y` of the screen as [`Warp::row_and`] does, and lowers the world distances `out` of its pixels to those of this texture.
    #[inline(always)]
    pub(crate) fn row<S: Simd>(&self, simd: S, y: u32, pixels: &mut [[f32; 4]], out: &mut [f32]) {
        let near = self.near();
        let mut row = Row { warp: self, near, inner: near.and(&self.inner()), first: y as usize * out.len(), out };
        self.warp.row_and(simd, y, pixels, &mut row);
    }

    /// Positions with a texel around them that has a depth.
    #[inline(always)]
    fn near(&self) -> Bounds {
        let [x0, y0, x1, y1] = self.seen.map(|n| n as f64);
        self.warp.seen(1).and(&Bounds([x0 - 1.0, y0 - 1.0, x1, y1]))
    }

    /// Positions between four texels.
    #[inline(always)]
    fn inner(&self) -> Bounds {
        let [width, height] = self.warp.texture.size.map(|n| n as f64 - 1.0);
        Bounds([0.0, 0.0, width, height])
    }

    /// Depths of the two texels above each of sixteen positions, and of the two below; of those that are not `easy`, any.
    #[inline(always)]
    fn around<S: Simd>(&self, simd: S, easy: u32, column: &[i32; LANES], row: &[i32; LANES]) -> [[f32x16<S>; 2]; 2] {
        // From u32, so that the compiler sees that nothing overflows.
        let width = self.warp.texture.size[0] as u32 as usize;
        let (mut above, mut below) = ([[0.0; 2]; LANES], [[0.0; 2]; LANES]);
        for j in 0..LANES {
            let first = if easy >> j & 1 == 0 { 0 } else { row[j] as u32 as usize * width + column[j] as u32 as usize };
            let near = &self.depths[first..][..width + 2];
            (above[j], below[j]) = ([near[0], near[1]], [near[width], near[width + 1]]);
        }
        [pairs(simd, &above), pairs(simd, &below)]
    }

    /// Depth of a pixel between four texels.
    #[inline(always)]
    fn depth(&self, pixel: usize, [column, row]: [i32; 2], at: [f32; 2]) -> Option<f32> {
        let warp = self.warp;
        let weights = warp.weights_for(pixel, [column, row], at);
        let (mut depths, mut covers) = ([f32::INFINITY; 4], 0.0);
        for i in 0..4 {
            if let Some(texel) = warp.index_of([column + (i & 1) as i32, row + (i >> 1) as i32]) {
                depths[i] = self.depths[texel];
                let cover = if self.light {
                    warp.texture.pixels[texel][3]
                } else if depths[i].is_finite() {
                    1.0
                } else {
                    0.0
                };
                covers += weights[i] * cover;
            }
        }
        // Half of a cover of 1 is rounded.
        const HALF: f32 = 0.5 - 1e-6;
        if covers < HALF { None } else { mean_of_sheet(depths, weights, self.tolerance) }
    }
}

/// The first ones of sixteen pairs, and the second ones.
#[inline(always)]
fn pairs<S: Simd>(simd: S, pairs: &[[f32; 2]; LANES]) -> [f32x16<S>; 2] {
    let (low, high) = pairs.as_flattened().split_at(LANES);
    let (low, high) = (f32x16::from_slice(simd, low), f32x16::from_slice(simd, high));
    [low.unzip_low(high), low.unzip_high(high)]
}

/// A row of the screen.
struct Row<'a, 'b> {
    warp: &'a DepthWarp<'a>,
    /// Positions with a texel around them that has a depth, and those of them that lie between four texels.
    near: Bounds,
    inner: Bounds,
    /// Number of its first pixel.
    first: usize,
    /// World distances of its pixels.
    out: &'b mut [f32],
}

impl Beside for Row<'_, '_> {
    #[inline(always)]
    fn lower<S: Simd>(
        &mut self,
        simd: S,
        block: &Block<S>,
        cells: &Cells<S>,
        drawn: u32,
        (screen, pixel): (DVec2, usize),
    ) {
        let Self { warp, near, inner, .. } = self;
        let mut easy = if warp.warp.surfaces.is_some() { 0 } else { block.within(simd, inner) & drawn };
        let mut doubtful = if easy == drawn { drawn } else { block.within(simd, near) & drawn };
        if doubtful == 0 {
            return;
        }
        let x = pixel - self.first;
        let end = self.out.len().min(x + LANES);
        let out = &mut self.out[x..end];
        let [(column, tx), (row, ty)] = cells;
        // Pixels between four texels of one sheet, or between four that see nothing: most of them are.
        if easy != 0 {
            let [above, below] = warp.around(simd, easy, column, row);
            let nearest = above[0].min(above[1]).min(below[0].min(below[1]));
            let farthest = above[0].max(above[1]).max(below[0].max(below[1]));
            let nothing = nearest.simd_eq(f32x16::splat(simd, f32::INFINITY));
            // False where one is infinite.
            let sheet = (farthest - nearest).simd_le(f32x16::splat(simd, warp.tolerance));
            doubtful &= !(easy & (sheet | nothing).to_bitmask() as u32);
            easy &= sheet.to_bitmask() as u32;
            let (upper, lower) = (above[0] + *tx * (above[1] - above[0]), below[0] + *tx * (below[1] - below[0]));
            let found = warp.distances.distances(simd, screen, block.positions(), upper + *ty * (lower - upper));
            if let (Ok(out), true) = (<&mut [f32; LANES]>::try_from(&mut *out), easy == (1 << LANES) - 1) {
                *out = f32x16::load_array_ref(simd, out).min(found).to_array();
            } else {
                let found = found.to_array();
                for (j, out) in out.iter_mut().enumerate() {
                    *out = if easy >> j & 1 == 0 { *out } else { out.min(found[j]) };
                }
            }
        }
        // The others, one by one.
        let (tx, ty) = (tx.to_array(), ty.to_array());
        while doubtful != 0 {
            let j = doubtful.trailing_zeros() as usize;
            doubtful &= doubtful - 1;
            let (cell, at) = ([column[j], row[j]], [tx[j], ty[j]]);
            if let Some(depth) = warp.depth(pixel + j, cell, at) {
                let texel = DVec2::new(f64::from(cell[0]) + f64::from(at[0]), f64::from(cell[1]) + f64::from(at[1]));
                let screen = DVec2::new(screen.x + j as f64, screen.y);
                out[j] = out[j].min(warp.distances.distance(screen, texel, depth.into()) as f32);
            }
        }
    }
}
