//! Gradients of the trilinear interpolant itself.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{Cells, Lanes, pick, splat};

/// Derivative of the interpolant per step of texture coordinates, in cells whose corners are given: along an axis, those of its lower face and of its upper one, (0, 0), (1, 0),
/// (0, 1) and (1, 1) on the two other axes. On a face between two cells it is that of the upper one. Zero in vacuum.
///
/// Corners are subtracted first, and interpolated then: where the field is constant, the gradient is zero to the last bit.
#[inline(always)]
pub(super) fn slopes<S: Simd>(simd: S, at: &Cells<S>, faces: impl Fn(usize) -> [[f32x16<S>; 4]; 2]) -> [Lanes; 3] {
    let mut gradient = [Lanes::ZERO; 3];
    for (a, gradient) in gradient.iter_mut().enumerate() {
        let [low, high] = faces(a);
        let [b, c] = [[1, 2], [0, 2], [0, 1]][a];
        let (t, u) = (at.fraction[b], at.fraction[c]);
        let rises = [high[0] - low[0], high[1] - low[1], high[2] - low[2], high[3] - low[3]];
        let (row_0, row_1) = (rises[0] + t * (rises[1] - rises[0]), rises[2] + t * (rises[3] - rises[2]));
        let slope = row_0 + u * (row_1 - row_0);
        *gradient = Lanes::new(pick(slope.simd_eq(slope), slope, splat(simd, 0.0)));
    }
    gradient
}
