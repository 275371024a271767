//! Rows of a table, turned into vectors.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16};

use super::LANES;

/// Sixteen rows of four, four to a vector: what can be added and scaled before it is turned.
#[inline(always)]
pub fn packed<S: Simd>(rows: [f32x4<S>; LANES]) -> [f32x16<S>; 4] {
    let [r0, r1, r2, r3, r4, r5, r6, r7, r8, r9, r10, r11, r12, r13, r14, r15] = rows;
    [
        r0.combine(r1).combine(r2.combine(r3)),
        r4.combine(r5).combine(r6.combine(r7)),
        r8.combine(r9).combine(r10.combine(r11)),
        r12.combine(r13).combine(r14.combine(r15)),
    ]
}

/// Sixteen rows of four into one vector per component.
#[inline(always)]
pub fn transpose<S: Simd>(rows: [f32x4<S>; LANES]) -> [f32x16<S>; 4] {
    transpose_packed(packed(rows))
}

/// The same of [`packed`] rows.
#[inline(always)]
pub fn transpose_packed<S: Simd>([a, b, c, d]: [f32x16<S>; 4]) -> [f32x16<S>; 4] {
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
