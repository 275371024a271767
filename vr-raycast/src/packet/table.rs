//! The transfer function's table, looked up for sixteen values at once.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, i32x16};
use vr_core::transfer::BakedTransfer;

use super::lanes::{LANES, splat};

/// A table of rows of four numbers over the field's stored numbers, interpolated linearly.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows<'a> {
    /// The last row is there twice, so that index + 1 always exists.
    rows: &'a [[f32; 4]],
    origin: f32,
    per_unit: f32,
    /// The largest index.
    last: f32,
}

impl<'a> Rows<'a> {
    pub(crate) fn of(table: &'a BakedTransfer<f32>) -> Self {
        let rows = table.entries();
        Self { rows, origin: table.origin(), per_unit: table.per_unit(), last: (rows.len() - 2) as f32 }
    }

    /// The interpolated rows of sixteen values, component by component.
    ///
    /// A row is one load into a register: through memory, a wide load would have to wait for the narrow stores before it.
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, simd: S, value: f32x16<S>) -> [f32x16<S>; 4] {
        let x = ((value - self.origin) * self.per_unit).max(splat(simd, 0.0)).min(splat(simd, self.last));
        let index: i32x16<S> = x.to_int();
        let t = x - index.to_float::<f32x16<S>>();
        let index = index.to_array();
        let zero = f32x4::splat(simd, 0.0);
        let (mut low, mut high) = ([zero; LANES], [zero; LANES]);
        for j in 0..LANES {
            let i = index[j] as u32 as usize;
            if let Some([a, b]) = self.rows.get(i..i + 2) {
                low[j] = f32x4::load_array_ref(simd, a);
                high[j] = f32x4::load_array_ref(simd, b);
            }
        }
        let (low, high) = (transpose(low), transpose(high));
        [
            low[0] + t * (high[0] - low[0]),
            low[1] + t * (high[1] - low[1]),
            low[2] + t * (high[2] - low[2]),
            low[3] + t * (high[3] - low[3]),
        ]
    }
}

/// Sixteen rows of four into one vector per component.
#[inline(always)]
fn transpose<S: Simd>(rows: [f32x4<S>; LANES]) -> [f32x16<S>; 4] {
    let [r0, r1, r2, r3, r4, r5, r6, r7, r8, r9, r10, r11, r12, r13, r14, r15] = rows;
    let a = r0.combine(r1).combine(r2.combine(r3));
    let b = r4.combine(r5).combine(r6.combine(r7));
    let c = r8.combine(r9).combine(r10.combine(r11));
    let d = r12.combine(r13).combine(r14.combine(r15));
    // Even components and odd ones, then each in two.
    let (even_low, odd_low) = (a.unzip_low(b), a.unzip_high(b));
    let (even_high, odd_high) = (c.unzip_low(d), c.unzip_high(d));
    [
        even_low.unzip_low(even_high),
        odd_low.unzip_low(odd_high),
        even_low.unzip_high(even_high),
        odd_low.unzip_high(odd_high),
    ]
}
