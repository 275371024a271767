//! Positions along sixteen rays, the cells that they lie in, and where rays leave these.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, f64x8, i32x16, mask32x16};
use vr_kernels::vector::{Cells, LANES, pick, splat};

use super::march::Packet;
use crate::leap::ClearSpace;

/// Positions along the rays, in f64.
pub(super) struct Path<S: Simd> {
    base: [[f64x8<S>; 2]; 3],
    delta: [[f64x8<S>; 2]; 3],
    last_cell: [f64; 3],
    max: [f64; 3],
}

impl<S: Simd> Path<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, packet: &Packet, dims: [usize; 3]) -> Self {
        let halves =
            |lanes: &[f64; LANES]| [f64x8::from_slice(simd, &lanes[..8]), f64x8::from_slice(simd, &lanes[8..])];
        Self {
            base: [halves(&packet.base[0]), halves(&packet.base[1]), halves(&packet.base[2])],
            delta: [halves(&packet.delta[0]), halves(&packet.delta[1]), halves(&packet.delta[2])],
            last_cell: [dims[0] as f64 - 2.0, dims[1] as f64 - 2.0, dims[2] as f64 - 2.0],
            max: [dims[0] as f64 - 1.0, dims[1] as f64 - 1.0, dims[2] as f64 - 1.0],
        }
    }

    /// Returns the cells of positions along one axis, and the fractions in them.
    #[inline(always)]
    fn axis(&self, simd: S, a: usize, [s0, s1]: [f64x8<S>; 2]) -> (f32x16<S>, f32x16<S>) {
        let (zero, max) = (f64x8::splat(simd, 0.0), f64x8::splat(simd, self.max[a]));
        let last = f64x8::splat(simd, self.last_cell[a]);
        let p0 = (self.base[a][0] + self.delta[a][0] * s0).max(zero).min(max);
        let p1 = (self.base[a][1] + self.delta[a][1] * s1).max(zero).min(max);
        let (c0, c1) = (p0.floor().min(last), p1.floor().min(last));
        (c0.narrow(c1), (p0 - c0).narrow(p1 - c1))
    }

    #[inline(always)]
    pub(super) fn cells(&self, simd: S, s: f32x16<S>) -> ([f32x16<S>; 3], Cells<S>) {
        let (s0, s1) = s.widen();
        let (cx, fx) = self.axis(simd, 0, [s0, s1]);
        let (cy, fy) = self.axis(simd, 1, [s0, s1]);
        let (cz, fz) = self.axis(simd, 2, [s0, s1]);
        let cell = [cx.to_int::<i32x16<S>>(), cy.to_int::<i32x16<S>>(), cz.to_int::<i32x16<S>>()];
        ([cx, cy, cz], Cells { cell, fraction: [fx, fy, fz] })
    }
}

/// Solver for the points at which rays leave boxes of cells.
pub(super) struct Exits<S: Simd> {
    /// Units per cell along each axis; a large number where a ray is parallel.
    per_cell: [f32x16<S>; 3],
    /// 1 where a ray goes up an axis, 0 where it goes down, and 2 where it does neither.
    up: [f32x16<S>; 3],
    /// 1 and −1.
    sign: [f32x16<S>; 3],
}

impl<S: Simd> Exits<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, delta: &[f32x16<S>; 3]) -> Self {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let (mut per_cell, mut up, mut sign) = ([zero; 3], [zero; 3], [zero; 3]);
        for a in 0..3 {
            // A ray that is parallel to faces may lie in one: it leaves by none.
            let parallel = delta[a].abs().simd_lt(splat(simd, 1e-12));
            let rising = delta[a].simd_gt(zero);
            up[a] = pick(parallel, splat(simd, 2.0), pick(rising, one, zero));
            sign[a] = pick(rising | parallel, one, -one);
            per_cell[a] = pick(parallel, splat(simd, 1e30), one / pick(parallel, one, delta[a]));
        }
        Self { per_cell, up, sign }
    }

    /// Returns the distances to where rays leave their cells.
    #[inline(always)]
    pub(super) fn of_cell(&self, simd: S, fraction: &[f32x16<S>; 3]) -> f32x16<S> {
        let mut length = splat(simd, 1e6);
        for a in 0..3 {
            length = length.min(((self.up[a] - fraction[a]) * self.per_cell[a]).abs());
        }
        length
    }

    /// Returns the distances to where rays leave the boxes of blocks, or the cells, that a code of [`ClearSpace`] tells of.
    #[inline(always)]
    pub(super) fn of_box(
        &self,
        simd: S,
        numbers: &[f32x16<S>; 3],
        fraction: &[f32x16<S>; 3],
        code: f32x16<S>,
    ) -> f32x16<S> {
        const EDGE: f32 = ClearSpace::EDGE as f32;
        let one = splat(simd, 1.0);
        let distance = pick(code.simd_gt(splat(simd, 0.0)), code, code * -1.0 + ClearSpace::VISIBLE_BLOCK as f32);
        // No block is nearer than the ray's own.
        let is_cell = distance.simd_lt(one);
        let (reach, edge) = (pick(is_cell, one, distance * EDGE), pick(is_cell, one, splat(simd, EDGE)));
        let mut length = splat(simd, 1e6);
        for a in 0..3 {
            let corner = pick(is_cell, numbers[a], (numbers[a] * (1.0 / EDGE)).floor() * EDGE);
            // Whole numbers but for the fraction: nothing is rounded that could be cancelled.
            let face = corner + self.up[a] * edge + self.sign[a] * (reach - edge);
            length = length.min((((face - numbers[a]) - fraction[a]) * self.per_cell[a]).max(splat(simd, 0.0)));
        }
        length
    }

    /// Returns true for rays that have crossed the faces of cells along one axis at most since a distance ago.
    #[inline(always)]
    pub(super) fn crossed_one(&self, simd: S, fraction: &[f32x16<S>; 3], since: f32x16<S>) -> mask32x16<S> {
        let zero = splat(simd, 0.0);
        let mut crossed = [zero; 3];
        for a in 0..3 {
            let ago = ((splat(simd, 1.0) - self.up[a] - fraction[a]) * self.per_cell[a]).abs();
            crossed[a] = pick(ago.simd_le(since), splat(simd, 1.0), zero);
        }
        (crossed[0] + crossed[1] + crossed[2]).simd_le(splat(simd, 1.0))
    }
}
