//! Places at which opacity reaches a half, within the samples in which it does.
//!
//! Rows only note the sample in which a texel's opacity passes a half. The place within the sample takes two logarithms, which are computed for
//! sixteen texels at once after the last slice.

use fearless_simd::Simd;
use vr_kernels::vector::{LANES, Lanes, share_of_half};

use super::kernel::Row;

/// Largest fraction of an interval: its end is the next one's begin.
const BELOW_ONE: f32 = 0.9999;

/// Notes that the `crossing` ones among up to sixteen texels from x on, whose opacity was `before`, pass a half in samples of opacity `alpha` of a slice.
#[inline(always)]
pub(super) fn note_half(crossing: u32, x: usize, before: &[f32], alpha: &[f32], slice: f32, row: &mut Row<'_>) {
    let mut left = crossing;
    while left != 0 {
        let i = left.trailing_zeros() as usize;
        row.pass_half(x + i, slice, [before[i], alpha[i]]);
        left &= left - 1;
    }
}

/// Turns the numbers of the slices in which texels pass a half into places.
pub(super) fn place_halves<S: Simd>(simd: S, row: &mut Row<'_>) {
    for x in (0..row.width()).step_by(LANES) {
        let (places, [before, alpha]) = row.halves(x);
        if places.iter().all(|&place| place == 0.0) {
            continue;
        }
        let mut share = Lanes::ZERO;
        share_of_half(simd, &Lanes(*before), &Lanes(*alpha), &mut share);
        for (place, &share) in places.iter_mut().zip(&share.0) {
            if *place > 0.0 {
                *place += share.min(BELOW_ONE);
            }
        }
    }
}
