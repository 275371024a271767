//! Gradients along steps, each inside a cell.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use vr_kernels::vector::{Field, Lanes, Pairs, Stage, pick, splat};

/// World gradients at the samples of sixteen cells, x fastest, but for their common length.
pub(super) struct Corners<S: Simd> {
    world: [[f32x16<S>; 8]; 3],
    /// Bound of the lengths of the vectors that they are sums of; 0 where the gradient is 0 throughout the cell.
    pub(super) reach: f32x16<S>,
}

/// Gradients along steps, by their derivatives in the middles: of the way from the begin of a step to its end, 0 to 1. The third is the same all along.
pub(super) struct Derivatives<S: Simd> {
    pub(super) value: [f32x16<S>; 3],
    pub(super) first: [f32x16<S>; 3],
    pub(super) second: [f32x16<S>; 3],
    pub(super) third: [f32x16<S>; 3],
}

impl<S: Simd> Corners<S> {
    /// Takes central differences at the samples of cells, one-sided at the faces of the volume. `to_world`: rows of the matrix from gradients per index step;
    /// `columns`: lengths of its columns.
    #[inline(always)]
    pub(super) fn new<T: Pairs>(
        simd: S,
        field: &Field<'_, T>,
        cell: &[Lanes; 3],
        to_world: &[[f32; 3]; 3],
        columns: &[f32; 3],
        stage: &mut Stage<T>,
    ) -> Self {
        let (zero, one, half) = (splat(simd, 0.0), splat(simd, 1.0), splat(simd, 0.5));
        let cell = [cell[0].load(simd), cell[1].load(simd), cell[2].load(simd)];
        let cells = [cell[0].to_int::<i32x16<S>>(), cell[1].to_int::<i32x16<S>>(), cell[2].to_int::<i32x16<S>>()];
        field.surround(simd, cells, &mut stage.around);
        let mut per_index = [[zero; 8]; 3];
        let mut reach = zero;
        for a in 0..3 {
            let last = splat(simd, field.last_cell[a] as f32);
            let (at_first, at_last) = (cell[a].simd_le(zero), cell[a].simd_ge(last));
            let (at_low, at_high) = (pick(at_first, one, half), pick(at_last, one, half));
            let [before, lower, upper, behind] = stage.around.planes(simd, a);
            let [b, c] = [[1, 2], [0, 2], [0, 1]][a];
            let mut largest = zero;
            for k in 0..4 {
                let (low, high) = (at_low * (upper[k] - before[k]), at_high * (behind[k] - lower[k]));
                let i = (k & 1) << b | (k >> 1) << c;
                (per_index[a][i], per_index[a][i | 1 << a]) = (low, high);
                largest = largest.max(low.abs()).max(high.abs());
            }
            reach += largest * columns[a];
        }
        let mut world = [[zero; 8]; 3];
        for (row, values) in to_world.iter().zip(&mut world) {
            for i in 0..8 {
                values[i] = per_index[0][i] * row[0] + per_index[1][i] * row[1] + per_index[2][i] * row[2];
            }
        }
        Self { world, reach }
    }

    /// Returns the gradients at a fraction of each cell, multiplied by a scale, and their derivatives along a way through it, `step` cells per axis.
    ///
    /// The derivatives are differences of the corners: what rounding makes of them is small beside them, however short the way is.
    #[inline(always)]
    pub(super) fn along(&self, middle: [f32x16<S>; 3], step: [f32x16<S>; 3], scale: f32x16<S>) -> Derivatives<S> {
        let [x, y, z] = middle;
        let [dx, dy, dz] = step;
        let (dxy, dyz, dxz) = (dx * dy * 2.0, dy * dz * 2.0, dx * dz * 2.0);
        let dxyz = dxy * dz * 3.0;
        let none = [scale; 3];
        let mut along = Derivatives { value: none, first: none, second: none, third: none };
        for a in 0..3 {
            let [c000, c100, c010, c110, c001, c101, c011, c111] = self.world[a];
            // Differences and interpolation along x, then along y, then along z.
            let (x00, x10, x01, x11) = (c100 - c000, c110 - c010, c101 - c001, c111 - c011);
            let (f00, f10, f01, f11) = (c000 + x * x00, c010 + x * x10, c001 + x * x01, c011 + x * x11);
            let (y0, y1) = (f10 - f00, f11 - f01);
            let (xy0, xy1) = (x10 - x00, x11 - x01);
            let (f0, f1) = (f00 + y * y0, f01 + y * y1);
            let (x0, x1) = (x00 + y * xy0, x01 + y * xy1);
            let (fz, fxz, fyz, fxyz) = (f1 - f0, x1 - x0, y1 - y0, xy1 - xy0);
            along.value[a] = (f0 + z * fz) * scale;
            along.first[a] = ((x0 + z * fxz) * dx + (y0 + z * fyz) * dy + fz * dz) * scale;
            along.second[a] = ((xy0 + z * fxyz) * dxy + fyz * dyz + fxz * dxz) * scale;
            along.third[a] = fxyz * dxyz * scale;
        }
        along
    }
}
