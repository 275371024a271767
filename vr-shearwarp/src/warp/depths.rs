//! Depths of texels, resampled onto the screen.
//!
//! A pixel has a depth where the coverage, linear between the texels, is a half at least: the opacity of light, or 1 where a texel has a depth and
//! 0 elsewhere. It is the mean of the depths around it that lie on one sheet ([`crate::sheet`]), at the place of the pixel's own ray, and
//! the smallest of a pixel's subpixels.

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use glam::DVec2;

use super::Warp;
use super::line::{Block, LANES};
use crate::ray_distances::RayDistances;
use crate::sheet::mean_of_sheet;

/// Depths of the texels of a warp.
pub(crate) struct DepthWarp<'a> {
    pub(crate) warp: &'a Warp<'a>,
    /// Row by row of the texture; infinite where a texel has none.
    pub(crate) depths: &'a [f32],
    /// True if a texel's opacity covers, and not whether it has a depth.
    pub(crate) light: bool,
    pub(crate) distances: &'a RayDistances<'a>,
    /// Largest difference of two depths of one sheet.
    pub(crate) tolerance: f32,
}

/// Opacity of a subpixel below which coverage cannot be a half, whichever filter made it: the cubic one falls short by a little.
const FAINT: f32 = 0.25;

impl DepthWarp<'_> {
    /// Lowers the world distances `out` of row `y` of the screen to those of this texture. `pixels`: the row, warped.
    #[inline(always)]
    pub(crate) fn row<S: Simd>(&self, simd: S, y: u32, pixels: &[[f32; 4]], out: &mut [f32]) {
        let warp = self.warp;
        let seen = warp.seen(1);
        let columns = warp.columns_within(&seen, y, out.len());
        let n = warp.samples;
        let faint = FAINT / (n * n) as f32;
        let mut x = columns.start;
        while x < columns.end {
            let end = columns.end.min(x + LANES);
            let mut wanted = 0;
            for (i, pixel) in pixels[x..end].iter().enumerate() {
                wanted |= u32::from(!self.light || pixel[3] >= faint) << i;
            }
            for sample in 0..if wanted == 0 { 0 } else { n * n } {
                let [dx, dy] = [sample % n, sample / n].map(|i| warp.subpixel(i));
                let block = warp.line(y, sample / n).block(simd, x as f64 + dx);
                let within = block.within(simd, &seen) & wanted;
                let screen = DVec2::new(x as f64 + dx, f64::from(y) + dy);
                self.lower(simd, &block, within, screen, y as usize * out.len() + x, &mut out[x..end]);
            }
            x += LANES;
        }
    }

    /// Lowers the distances of the pixels `within`, the first of which lies at a point of the screen and is number `pixel`.
    #[inline(always)]
    fn lower<S: Simd>(&self, simd: S, block: &Block<S>, within: u32, screen: DVec2, pixel: usize, out: &mut [f32]) {
        let [(column, tx), (row, ty)] = block.cells(simd);
        let (tx, ty) = (tx.to_array(), ty.to_array());
        for (j, out) in out.iter_mut().enumerate() {
            if within >> j & 1 == 0 {
                continue;
            }
            let (cell, at) = ([column[j], row[j]], [tx[j], ty[j]]);
            if let Some(depth) = self.depth(pixel + j, cell, at) {
                let texel = DVec2::new(f64::from(cell[0]) + f64::from(at[0]), f64::from(cell[1]) + f64::from(at[1]));
                let screen = DVec2::new(screen.x + j as f64, screen.y);
                *out = out.min(self.distances.distance(screen, texel, depth.into()) as f32);
            }
        }
    }

    /// Depth of a pixel between four texels.
    #[inline(always)]
    fn depth(&self, pixel: usize, [column, row]: [i32; 2], at: [f32; 2]) -> Option<f32> {
        let warp = self.warp;
        if let Some(depth) = self.within_sheet([column, row], at) {
            return Some(depth);
        }
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

    /// The depth, linear between four texels of one sheet; `None` where they are not, or a surface may tell them apart. All four have a depth,
    /// and so cover at least a half.
    #[inline(always)]
    fn within_sheet(&self, [column, row]: [i32; 2], [x, y]: [f32; 2]) -> Option<f32> {
        // The last of the four; the first must be inside, too, which a negative place is not.
        let last = self.warp.index_of([column + 1, row + 1])?;
        if column < 0 || row < 0 || self.warp.surfaces.is_some() {
            return None;
        }
        let below = &self.depths[last - 1..=last];
        let above = &self.depths[last - 1 - self.warp.texture.size[0]..][..2];
        let (nearest, farthest) =
            (above[0].min(above[1]).min(below[0].min(below[1])), above[0].max(above[1]).max(below[0].max(below[1])));
        // False where one is infinite.
        let sheet = farthest - nearest <= self.tolerance;
        let (upper, lower) = (above[0] + x * (above[1] - above[0]), below[0] + x * (below[1] - below[0]));
        sheet.then_some(upper + y * (lower - upper))
    }
}
