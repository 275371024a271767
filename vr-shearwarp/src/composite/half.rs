//! Places at which opacity reaches a half, within the samples in which it does.

use fearless_simd::Simd;
use vr_kernels::vector::{Lanes, share_of_half};

/// Largest fraction of an interval: its end is the next one's begin.
const BELOW_ONE: f32 = 0.9999;

/// Notes the places of the `crossing` ones among up to sixteen texels, whose opacity was `before`, in the samples of opacity `alpha` of a slice.
#[inline(always)]
pub(super) fn note_half<S: Simd>(
    simd: S,
    crossing: u32,
    before: &[f32],
    alpha: &[f32],
    slice: f32,
    places: &mut [f32],
) {
    let (mut opacities, mut own, mut share) = (Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
    opacities.0[..before.len()].copy_from_slice(before);
    own.0[..alpha.len()].copy_from_slice(alpha);
    share_of_half(simd, &opacities, &own, &mut share);
    let mut left = crossing;
    while left != 0 {
        let i = left.trailing_zeros() as usize;
        places[i] = slice + share.0[i].min(BELOW_ONE);
        left &= left - 1;
    }
}
