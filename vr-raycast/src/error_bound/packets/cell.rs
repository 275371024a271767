//! Trilinear field along steps, each inside a cell.

use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{Field, Pairs, Stage};

/// Field along a step inside a cell.
pub(super) struct Along<S: Simd> {
    pub(super) begin: f32x16<S>,
    pub(super) middle: f32x16<S>,
    pub(super) end: f32x16<S>,
    /// Third difference of the cell's corners: what the cubic part is made of.
    pub(super) third: f32x16<S>,
}

impl<S: Simd> Along<S> {
    /// Evaluates the trilinear field of staged cells at three places in each.
    #[inline(always)]
    pub(super) fn new<T: Pairs>(simd: S, field: &Field<'_, T>, stage: &Stage<T>, places: [&[f32x16<S>; 3]; 3]) -> Self {
        let [[a00, b00, a10, b10], [a01, b01, a11, b11]] = field.faces(simd, 2, stage);
        let (d00, d10, d01, d11) = (b00 - a00, b10 - a10, b01 - a01, b11 - a11);
        let third = (d11 - d01) - (d10 - d00);
        let mut values = [a00; 3];
        for i in 0..3 {
            let [x, y, z] = *places[i];
            let (f00, f10, f01, f11) = (a00 + x * d00, a10 + x * d10, a01 + x * d01, a11 + x * d11);
            let (f0, f1) = (f00 + y * (f10 - f00), f01 + y * (f11 - f01));
            values[i] = f0 + z * (f1 - f0);
        }
        let [begin, middle, end] = values;
        Self { begin, middle, end, third }
    }
}
