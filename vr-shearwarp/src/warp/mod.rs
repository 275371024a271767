//! The last step of shear-warp: the composited slices, resampled onto the screen.
//!
//! The slices are composited in a plane of their own, parallel to the volume's faces; what is left is a projective map of that plane
//! (Lacroute & Levoy 1994, §2). Each pixel looks back through the map and takes a mean of the texels around the place where it lands.
//! Positions are f64, sixteen at once; colours are f32, one pixel at once, as the four components of a texel fill a vector.

mod bilinear;
mod cubic;
mod depths;
mod line;
mod surfaces;
#[cfg(test)]
mod tests;

use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16};
use glam::{DMat3, DVec2};

use bilinear::Bilinear;
use cubic::Cubic;
use line::{Block, Bounds, LANES, Line};

pub(crate) use depths::DepthWarp;

use crate::surface_depths::SurfaceDepths;

/// The composited slices, as the warp reads them: premultiplied linear RGBA.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Texture<'a> {
    /// Row by row.
    pub pixels: &'a [[f32; 4]],
    /// Columns and rows, each below 2²⁴.
    pub size: [usize; 2],
    /// Smallest rectangle around what is not empty: first column, first row, and those behind the last.
    pub filled: [usize; 4],
}

/// Interpolation of the warp between texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WarpFilter {
    /// Linear along each axis, over 2 × 2 texels.
    #[default]
    Bilinear,
    /// Cubic convolution over 4 × 4 texels (Keys 1981, *Cubic convolution interpolation for digital image processing*, a = −½; also
    /// known as Catmull-Rom): sharper. It may overshoot at edges, so colour is cut off below 0, and opacity outside [0, 1].
    Cubic,
}

/// A texture on its way to the screen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Warp<'a> {
    /// The texture to draw. Outside it, all is transparent black.
    pub texture: Texture<'a>,
    /// From (x, y, 1), in pixels of the screen from its top left corner, where pixel (i, j) has its centre at (i + ½, j + ½), to
    /// homogeneous positions in the texture, whose texel (i, j) lies at (i, j).
    ///
    /// Affine where the last row is (0, 0, 1). Positions whose weight is not positive are behind the eye, and are not drawn.
    pub to_texture: DMat3,
    /// Texture positions x0 ≤ x < x1, y0 ≤ y < y1, as [x0, y0, x1, y1], that may be drawn; `None`: all.
    pub within: Option<[f64; 4]>,
    /// Interpolation between texels.
    pub filter: WarpFilter,
    /// A pixel is the mean over `samples`² subpixel centres, as in [`vr_core::View`].
    pub samples: u32,
    /// Depths of opaque surfaces, where there are any.
    pub surfaces: Option<&'a SurfaceDepths>,
}

/// Work beside the drawing of colours, at the same positions of the texture.
trait Beside {
    /// Sixteen subpixels of neighbouring pixels, of which some are drawn. `at`: the first one's place on the screen, and the number of its pixel. Their positions are
    /// given as cells and places in these, too.
    fn lower<S: Simd>(&mut self, simd: S, block: &Block<S>, cells: &Cells<S>, drawn: u32, at: (DVec2, usize));
}

/// Columns and rows of texels before sixteen positions, and how far the positions lie behind them.
type Cells<S> = [([i32; LANES], f32x16<S>); 2];

/// No work beside colours.
#[cfg(test)]
struct Nothing;

#[cfg(test)]
impl Beside for Nothing {
    #[inline(always)]
    fn lower<S: Simd>(&mut self, _: S, _: &Block<S>, _: &Cells<S>, _: u32, _: (DVec2, usize)) {}
}

/// A filter of N × N texels: the N/2 on either side of a position, along each axis.
trait Kernel<const N: usize> {
    /// Weights of a row of taps, from the position's distance to the tap before it, in [0, 1].
    fn weights<S: Simd>(simd: S, t: f32x16<S>) -> [f32x16<S>; N];

    /// The mean of the taps, given row by row, with the weights of one lane.
    ///
    /// Rows are added first: the texels of a row lie side by side, and fill wider vectors than one. A weight is read from memory into all
    /// lanes at once, just before it is needed; by way of a scalar register it would take three instructions.
    fn blend<S: Simd>(
        simd: S,
        taps: [&[[f32; 4]; N]; N],
        x: &[f32x16<S>; N],
        y: &[f32x16<S>; N],
        lane: usize,
    ) -> f32x4<S>;
}

impl Warp<'_> {
    /// Draws row `y` of the screen, into as many pixels as `out` has.
    ///
    /// With one sample a pixel, sets the pixels that see some of the texture. With more, adds to each the share of this texture: samples
    /// that are not within, or see nothing, count as nothing. Pixels that see nothing are left as they are.
    #[cfg(test)]
    #[inline(always)]
    pub(crate) fn row<S: Simd>(&self, simd: S, y: u32, out: &mut [[f32; 4]]) {
        self.row_and(simd, y, out, &mut Nothing);
    }

    /// The same, with work beside it.
    #[inline(always)]
    fn row_and<S: Simd, B: Beside>(&self, simd: S, y: u32, out: &mut [[f32; 4]], beside: &mut B) {
        match self.filter {
            WarpFilter::Bilinear => self.row_of::<S, Bilinear, B, 2>(simd, y, out, beside),
            WarpFilter::Cubic => self.row_of::<S, Cubic, B, 4>(simd, y, out, beside),
        }
    }

    /// Columns of row `y`, of a screen of `width`, that can see anything: all that do, and at most a few more.
    #[cfg(test)]
    pub(crate) fn columns(&self, y: u32, width: usize) -> Range<usize> {
        let reach = match self.filter {
            WarpFilter::Bilinear => 1,
            WarpFilter::Cubic => 2,
        };
        self.columns_within(&self.seen(reach), y, width)
    }

    #[inline(always)]
    fn columns_within(&self, seen: &Bounds, y: u32, width: usize) -> Range<usize> {
        if seen.is_empty() {
            return 0..0;
        }
        let (mut first, mut end) = (width, 0);
        for i in 0..self.samples {
            let columns = self.line(y, i).columns(seen, width);
            if !columns.is_empty() {
                (first, end) = (first.min(columns.start), end.max(columns.end));
            }
        }
        first.min(end)..end
    }

    /// The texture positions that a row of subpixel centres sees.
    #[inline(always)]
    fn line(&self, y: u32, sample: u32) -> Line {
        Line::new(&self.to_texture, f64::from(y) + self.subpixel(sample))
    }

    /// Position of a subpixel's centre in its pixel, along either axis.
    #[inline(always)]
    fn subpixel(&self, sample: u32) -> f64 {
        (f64::from(sample) + 0.5) / f64::from(self.samples)
    }

    /// Positions that may be drawn, and have a filled texel among the `reach` ones on either side.
    #[inline(always)]
    fn seen(&self, reach: usize) -> Bounds {
        let Texture { size, filled, .. } = self.texture;
        let filled = [filled[0], filled[1], filled[2].min(size[0]), filled[3].min(size[1])].map(|x| x as f64);
        if !(filled[0] < filled[2] && filled[1] < filled[3]) {
            return Bounds::EMPTY;
        }
        let (before, after) = (reach as f64, reach as f64 - 1.0);
        let near = Bounds([filled[0] - before, filled[1] - before, filled[2] + after, filled[3] + after]);
        self.within.map_or(near, |within| near.and(&Bounds(within)))
    }

    #[inline(always)]
    fn row_of<S: Simd, K: Kernel<N>, B: Beside, const N: usize>(
        &self,
        simd: S,
        y: u32,
        out: &mut [[f32; 4]],
        beside: &mut B,
    ) {
        let seen = self.seen(N / 2);
        // All taps are texels here.
        let [width, height] = self.texture.size.map(|n| n as f64);
        let (before, after) = ((N / 2 - 1) as f64, (N / 2) as f64);
        let inner = seen.and(&Bounds([before, before, width - after, height - after]));
        let columns = self.columns_within(&seen, y, out.len());

        let mut x = columns.start;
        while x < columns.end {
            let pixel = y as usize * out.len() + x;
            let pixels = &mut out[x..columns.end.min(x + LANES)];
            if self.samples == 1 {
                let screen = DVec2::new(x as f64 + 0.5, f64::from(y) + 0.5);
                let block = self.line(y, 0).block(simd, screen.x);
                self.draw::<S, K, B, N, false>(simd, &block, [&seen, &inner], (screen, pixel), pixels, beside);
            } else {
                let mut sums = [[0.0; 4]; LANES];
                for j in 0..self.samples {
                    let line = self.line(y, j);
                    for i in 0..self.samples {
                        let screen = DVec2::new(x as f64 + self.subpixel(i), f64::from(y) + self.subpixel(j));
                        let block = line.block(simd, screen.x);
                        let sums = &mut sums[..pixels.len()];
                        self.draw::<S, K, B, N, true>(simd, &block, [&seen, &inner], (screen, pixel), sums, beside);
                    }
                }
                // Divided at the end, so that the mean of opaque samples is opaque.
                let count = f32x4::splat(simd, (self.samples * self.samples) as f32);
                for (pixel, sum) in pixels.iter_mut().zip(&sums) {
                    let share = f32x4::load_array_ref(simd, sum) / count;
                    *pixel = (f32x4::load_array_ref(simd, pixel) + share).to_array();
                }
            }
            x += LANES;
        }
    }

    /// One sample of each pixel, set or added; the first lies at a point of the screen and is number `first` there.
    #[inline(always)]
    fn draw<S: Simd, K: Kernel<N>, B: Beside, const N: usize, const ADD: bool>(
        &self,
        simd: S,
        block: &Block<S>,
        [seen, inner]: [&Bounds; 2],
        (screen, first): (DVec2, usize),
        pixels: &mut [[f32; 4]],
        beside: &mut B,
    ) {
        let wanted = (1u32 << pixels.len()) - 1;
        let easy = block.within(simd, inner) & wanted;
        let all = if easy == wanted { easy } else { block.within(simd, seen) & wanted };
        if all == 0 {
            return;
        }
        let cells = block.cells(simd);
        beside.lower(simd, block, &cells, all, (screen, first));
        let [(column, tx), (row, ty)] = cells;
        let (wx, wy) = (K::weights(simd, tx), K::weights(simd, ty));
        let texture = self.texture;
        for j in 0..pixels.len() {
            let (place, at) = ([column[j], row[j]], [tx.as_array()[j], ty.as_array()[j]]);
            let beside = match self.surfaces {
                Some(_) if all >> j & 1 != 0 => self.beside_outline::<N>(first + j, place, at),
                _ => None,
            };
            let value = if let Some(mean) = beside {
                f32x4::load_array_ref(simd, &mean)
            } else if easy >> j & 1 != 0 {
                K::blend(simd, texture.inner_taps(column[j], row[j]), &wx, &wy, j)
            } else if all >> j & 1 != 0 {
                let taps = texture.taps::<N>(column[j], row[j]);
                K::blend(simd, taps.each_ref(), &wx, &wy, j)
            } else {
                continue;
            };
            pixels[j] = if ADD { f32x4::load_array_ref(simd, &pixels[j]) + value } else { value }.to_array();
        }
    }
}

impl<'a> Texture<'a> {
    /// The taps around cell (`column`, `row`), all of which are texels.
    #[inline(always)]
    fn inner_taps<const N: usize>(self, column: i32, row: i32) -> [&'a [[f32; 4]; N]; N] {
        // From u32, so that the compiler sees that nothing overflows below, and tests the first slice alone.
        let width = self.size[0] as u32 as usize;
        let first = (row as usize + 1 - N / 2) * width + (column as usize + 1 - N / 2);
        let near = &self.pixels[first..][..(N - 1) * width + N];
        let mut taps = [&[[0.0; 4]; N]; N];
        for j in 0..N {
            taps[j] = near[j * width..].first_chunk().expect("taps are texels");
        }
        taps
    }

    /// The taps around cell (`column`, `row`): zero outside the texture.
    #[inline(always)]
    fn taps<const N: usize>(self, column: i32, row: i32) -> [[[f32; 4]; N]; N] {
        let mut taps = [[[0.0; 4]; N]; N];
        let [width, height] = self.size;
        for j in 0..N {
            // What is negative wraps around, to beyond any size.
            let y = (row + 1 - (N / 2) as i32 + j as i32) as u32 as usize;
            for i in 0..N {
                let x = (column + 1 - (N / 2) as i32 + i as i32) as u32 as usize;
                if x < width && y < height {
                    taps[j][i] = self.pixels[y * width + x];
                }
            }
        }
        taps
    }
}
