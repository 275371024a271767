//! A row of the screen as a line through the texture.

use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8, i32x16};
use glam::DMat3;

/// Positions in a block.
pub(super) const LANES: usize = 16;

/// x0 ≤ x < x1, y0 ≤ y < y1, as [x0, y0, x1, y1].
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds(pub(super) [f64; 4]);

impl Bounds {
    pub(super) const EMPTY: Self = Self([0.0; 4]);

    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        let [x0, y0, x1, y1] = self.0;
        !(x0 < x1 && y0 < y1)
    }

    /// Intersection of the two.
    #[inline(always)]
    pub(super) fn and(&self, other: &Self) -> Self {
        let ([a, b, c, d], [e, f, g, h]) = (self.0, other.0);
        Self([a.max(e), b.max(f), c.min(g), d.min(h)])
    }
}

/// Homogeneous texture positions (u, v, w) along a row: each is `[at x = 0, per column]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    u: [f64; 2],
    v: [f64; 2],
    w: [f64; 2],
}

impl Line {
    /// The row at `y`.
    #[inline(always)]
    pub(super) fn new(to_texture: &DMat3, y: f64) -> Self {
        let start = to_texture.y_axis * y + to_texture.z_axis;
        let step = to_texture.x_axis;
        Self { u: [start.x, step.x], v: [start.y, step.y], w: [start.z, step.z] }
    }

    /// The positions of sixteen columns from `x` on.
    #[inline(always)]
    pub(super) fn block<S: Simd>(&self, simd: S, x: f64) -> Block<S> {
        let first = f64x8::load_array(simd, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let (low, high) = (self.at(simd, first + x), self.at(simd, first + (x + 8.0)));
        Block { x: [low[0], high[0]], y: [low[1], high[1]] }
    }

    /// Positions at eight places of the row: not numbers where behind the eye.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, x: f64x8<S>) -> [f64x8<S>; 2] {
        let (u, v) = (x * self.u[1] + self.u[0], x * self.v[1] + self.v[0]);
        if self.w == [1.0, 0.0] {
            return [u, v];
        }
        let w = x * self.w[1] + self.w[0];
        let one = f64x8::splat(simd, 1.0);
        let reciprocal = w.simd_gt(f64x8::splat(simd, 0.0)).select(one / w, f64x8::splat(simd, f64::NAN));
        [u * reciprocal, v * reciprocal]
    }

    /// Columns, of `width`, some of whose positions may lie within `bounds`: all that do, and at most a few more.
    ///
    /// Each side of the bounds is linear in x, as w > 0: u − x0·w ≥ 0 and so on. What rounding can do to u and w is granted to each, and
    /// a column to the solution.
    #[inline(always)]
    pub(super) fn columns(&self, bounds: &Bounds, width: usize) -> Range<usize> {
        let [x0, y0, x1, y1] = bounds.0;
        let (u, v, w) = (self.u, self.v, self.w);
        let sides = [(1.0, u, -x0), (-1.0, u, x1), (1.0, v, -y0), (-1.0, v, y1), (0.0, u, 1.0)];
        let n = width as f64;
        let (mut first, mut end) = (0.0f64, n);
        for (sign, p, q) in sides {
            let (at_zero, slope) = (sign * p[0] + q * w[0], sign * p[1] + q * w[1]);
            let size = (p[0].abs() + p[1].abs() * n) + q.abs() * (w[0].abs() + w[1].abs() * n);
            let at_zero = at_zero + 16.0 * f64::EPSILON * size;
            let root = -at_zero / slope;
            // Where numbers overflow, nothing is known, and nothing is left out.
            if !(at_zero.is_finite() && slope.is_finite()) {
                continue;
            }
            if slope > 0.0 {
                first = first.max(root - 2.0);
            } else if slope < 0.0 {
                end = end.min(root + 2.0);
            } else if at_zero < 0.0 {
                return 0..0;
            }
        }
        // A cast of what is negative gives 0.
        (first as usize)..width.min(end as usize + 1)
    }
}

/// Texture positions of sixteen pixels.
pub(super) struct Block<S: Simd> {
    /// The first eight and the last.
    x: [f64x8<S>; 2],
    y: [f64x8<S>; 2],
}

impl<S: Simd> Block<S> {
    /// A bit for each position within `bounds`, the first one lowest.
    #[inline(always)]
    pub(super) fn within(&self, simd: S, bounds: &Bounds) -> u32 {
        let [x0, y0, x1, y1] = bounds.0;
        let (x0, y0) = (f64x8::splat(simd, x0), f64x8::splat(simd, y0));
        let (x1, y1) = (f64x8::splat(simd, x1), f64x8::splat(simd, y1));
        let mut bits = [0; 2];
        for half in 0..2 {
            let (x, y) = (self.x[half], self.y[half]);
            let inside = (x.simd_ge(x0) & x.simd_lt(x1)) & (y.simd_ge(y0) & y.simd_lt(y1));
            bits[half] = inside.to_bitmask() as u32;
        }
        bits[0] | bits[1] << 8
    }

    /// The positions' x and y, eight and eight.
    #[inline(always)]
    pub(super) fn positions(&self) -> [[f64x8<S>; 2]; 2] {
        [self.x, self.y]
    }

    /// Columns of texels, and how far the positions lie behind them, in [0, 1]; and the same for rows. For positions within some
    /// bounds only; the others are anything.
    #[inline(always)]
    pub(super) fn cells(&self, simd: S) -> [([i32; LANES], f32x16<S>); 2] {
        [cells(simd, self.x), cells(simd, self.y)]
    }
}

#[inline(always)]
fn cells<S: Simd>(simd: S, [low, high]: [f64x8<S>; 2]) -> ([i32; LANES], f32x16<S>) {
    let (low_floor, high_floor) = (floor(simd, low), floor(simd, high));
    let cell: i32x16<S> = low_floor.narrow(high_floor).to_int();
    (cell.to_array(), (low - low_floor).narrow(high - high_floor))
}

/// Rounds down numbers of less than 2⁵¹, by adding a number so large that no bits are left for the fraction.
///
/// SSE2 has no instruction for it, and a call for each lane would take longer than the whole warp.
#[inline(always)]
fn floor<S: Simd>(simd: S, x: f64x8<S>) -> f64x8<S> {
    const LARGE: f64 = 1.5 * (1u64 << 52) as f64;
    let nearest = (x + LARGE) - LARGE;
    nearest.simd_gt(x).select(nearest - f64x8::splat(simd, 1.0), nearest)
}
