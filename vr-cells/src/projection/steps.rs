//! Integrals of sixteen segments, from the table.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};
use vr_kernels::vector::{packed_rows, pick, rows_at, splat, transpose_packed};

use super::segment_table::Intervals;

/// Segments of sixteen rays in one cell, on each of which the value is linear.
#[derive(Clone, Copy)]
pub(super) struct Segments<S: Simd> {
    /// Places in the table of the values at both ends.
    pub(super) ends: [f32x16<S>; 2],
    /// Distance at the first end.
    pub(super) near: f32x16<S>,
    pub(super) length: f32x16<S>,
}

/// A look-up of sixteen places: integrals up to the beginnings of their intervals, row by row, how much of the interval lies before each, and what is integrated
/// there.
#[derive(Clone, Copy)]
pub(super) struct Found<S: Simd> {
    /// Packed: only differences of them are wanted.
    starts: [f32x16<S>; 4],
    fraction: f32x16<S>,
    pub(super) rates: [f32x16<S>; 4],
}

#[inline(always)]
pub(super) fn look_up<S: Simd>(simd: S, table: &Intervals, place: f32x16<S>) -> Found<S> {
    let last = splat(simd, (table.count() - 1) as f32);
    let place = place.max(splat(simd, 0.0));
    let index: i32x16<S> = place.min(last).to_int();
    let fraction = place - index.to_float::<f32x16<S>>();
    let index = index.to_array();
    let starts = packed_rows(simd, index, |n| table.at(n as u32)[0]);
    Found { starts, fraction, rates: rows_at(simd, index, |n| table.at(n as u32)[1]) }
}

/// Intervals of the table, below which a difference of two integrals is more rounding than integral.
const NARROW: f32 = 4.0;

/// Segments, or parts of them, of one length each.
#[derive(Clone, Copy)]
pub(super) struct Steps<S: Simd> {
    pub(super) length: f32x16<S>,
    /// Length for each interval of the table; 0 where the range of values is narrow.
    stretch: f32x16<S>,
    is_narrow: mask32x16<S>,
    any_narrow: bool,
}

impl<S: Simd> Steps<S> {
    /// Steps from one place to another in the table, by `rise`.
    #[inline(always)]
    pub(super) fn new(simd: S, rise: f32x16<S>, length: f32x16<S>) -> Self {
        let is_narrow = rise.abs().simd_lt(splat(simd, NARROW));
        let stretch = pick(is_narrow, splat(simd, 0.0), length / pick(is_narrow, splat(simd, 1.0), rise));
        Self { length, stretch, is_narrow, any_narrow: is_narrow.any_true() }
    }

    /// Optical depth, and the light that is sent, of steps between two look-ups.
    #[inline(always)]
    pub(super) fn sums(&self, simd: S, start: &Found<S>, end: &Found<S>) -> [f32x16<S>; 4] {
        let [a, b, c, d] = end.starts;
        let [e, f, g, h] = start.starts;
        let mut sums = transpose_packed([a - e, b - f, c - g, d - h]);
        for c in 0..4 {
            let parts = end.rates[c] * end.fraction - start.rates[c] * start.fraction;
            sums[c] = (sums[c] + parts) * self.stretch;
        }
        if self.any_narrow {
            // On a narrow range what is integrated is linear.
            for c in 0..4 {
                let mean = (start.rates[c] + end.rates[c]) * 0.5;
                sums[c] = pick(self.is_narrow, mean * self.length, sums[c]);
            }
        }
        sums[0] = sums[0].max(splat(simd, 0.0));
        sums
    }
}
