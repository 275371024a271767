//! Sixteen samples of the picture, and what cells add to them.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, i32x16, mask32x16};
use vr_kernels::vector::{LANES, Lanes, packed, pick, source_weight_and_opacity, splat, transpose, transpose_packed};

use super::segment_table::Interval;

/// Samples along the edge of a stamp.
pub(super) const SIDE: u32 = 4;

/// Opacity at which a sample's depth is told.
const HALF: f32 = 0.5;

/// Sixteen samples so far.
#[derive(Clone, Copy)]
pub(super) struct Stamp {
    pub(super) light: [Lanes; 3],
    /// Transmittance.
    pub(super) clear: Lanes,
    /// Distance at which half of what is behind is hidden.
    pub(super) depth: Lanes,
}

impl Stamp {
    /// Samples that have met nothing.
    pub(super) const EMPTY: Self =
        Self { light: [Lanes::ZERO; 3], clear: Lanes([1.0; LANES]), depth: Lanes([f32::INFINITY; LANES]) };
}

/// Segments of sixteen rays in one cell, on each of which the value is linear; of no length where a ray does not meet the cell.
#[derive(Clone, Copy)]
pub(super) struct Segments<S: Simd> {
    /// Places in the table of the values at both ends.
    pub(super) ends: [f32x16<S>; 2],
    /// Distance at the first end.
    pub(super) near: f32x16<S>,
    pub(super) length: f32x16<S>,
}

/// A look-up: integrals up to sixteen places, and what is integrated there, row by row.
struct Found<S: Simd> {
    integrals: [f32x16<S>; 4],
    rates: [f32x16<S>; 4],
}

#[inline(always)]
fn look_up<S: Simd>(simd: S, table: &[Interval], place: f32x16<S>) -> Found<S> {
    let last = splat(simd, (table.len() - 1) as f32);
    let place = place.max(splat(simd, 0.0));
    let index: i32x16<S> = place.min(last).to_int();
    let fraction = (place - index.to_float::<f32x16<S>>()).to_array();
    let index = index.to_array();
    let zero = f32x4::splat(simd, 0.0);
    let (mut integrals, mut rates) = ([zero; LANES], [zero; LANES]);
    for i in 0..LANES {
        let row = &table[(index[i] as u32 as usize).min(table.len() - 1)];
        let fraction = f32x4::splat(simd, fraction[i]);
        let rate = f32x4::load_array_ref(simd, &row.rate);
        let bent = f32x4::load_array_ref(simd, &row.bend) * fraction;
        integrals[i] = f32x4::load_array_ref(simd, &row.start) + fraction * (rate + bent);
        rates[i] = rate + (bent + bent);
    }
    // Integrals stay packed: only differences of them are wanted.
    Found { integrals: packed(integrals), rates: transpose(rates) }
}

/// Optical depth of a part of a segment that is taken at once.
const AT_ONCE: f32 = 0.15;
/// Parts of a segment at most.
const MAX_PARTS: u32 = 24;
/// Intervals of the table, below which a difference of two integrals is more rounding than integral.
const NARROW: f32 = 2.0;

/// Number of parts in which segments are taken, the longest of which has an optical depth of at most this.
#[inline(always)]
fn parts<S: Simd>(simd: S, length: f32x16<S>, extinction: f32) -> u32 {
    if !(length * extinction).simd_gt(splat(simd, AT_ONCE)).any_true() {
        return 1;
    }
    let longest = length.to_array().into_iter().fold(0.0, f32::max);
    ((longest * extinction / AT_ONCE).ceil() as u32).clamp(1, MAX_PARTS)
}

impl Stamp {
    /// Adds the light of segments whose extinction is at most `extinction`. Returns false once all samples are opaque: none is clearer than `min_clear`.
    #[inline(always)]
    pub(super) fn add<S: Simd>(
        &mut self,
        simd: S,
        table: &[Interval],
        segments: &Segments<S>,
        extinction: f32,
        min_clear: f32,
    ) -> bool {
        let (zero, one, narrow) = (splat(simd, 0.0), splat(simd, 1.0), splat(simd, NARROW));
        let count = parts(simd, segments.length, extinction);
        let share = 1.0 / count as f32;
        let [from, to] = segments.ends;
        let (step, length) = ((to - from) * share, segments.length * share);
        let is_narrow = step.abs().simd_lt(narrow);
        // Length for each interval of the table.
        let stretch = pick(is_narrow, zero, length / pick(is_narrow, one, step));
        let any_narrow = is_narrow.any_true();
        let mut start = look_up(simd, table, from);
        let mut clear = self.clear.load(simd);
        let mut light = [0, 1, 2].map(|c| self.light[c].load(simd));
        for part in 1..=count {
            let end = look_up(simd, table, from + step * part as f32);
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| end.integrals[i] - start.integrals[i]);
            let mut sums = transpose_packed([a, b, c, d]).map(|sum| sum * stretch);
            if any_narrow {
                // On a narrow range what is integrated is linear.
                for c in 0..4 {
                    let mean = (start.rates[c] + end.rates[c]) * 0.5;
                    sums[c] = pick(is_narrow, mean * length, sums[c]);
                }
            }
            let [tau, red, green, blue] = sums;
            let tau = tau.max(zero);
            let (weight, alpha) = source_weight_and_opacity(simd, tau);
            // Light from the far end is dimmed by more than that from the near end: to the first order, by what both change on the way.
            let change = |c: usize| (end.rates[c] - start.rates[c]) * length * (1.0 / 12.0);
            let deepens = change(0);
            let dimmed = clear * weight;
            for (c, sum) in [red, green, blue].into_iter().enumerate() {
                let order = sum * deepens - change(c + 1) * tau;
                light[c] += dimmed * (sum + order).max(zero);
            }
            let after = clear * (one - alpha);
            let hides = clear.simd_ge(splat(simd, HALF)) & after.simd_lt(splat(simd, HALF));
            if hides.any_true() {
                let at = segments.near + length * (part - 1) as f32;
                self.note_depth(hides, [clear, after], at, length);
            }
            clear = after;
            if count > 1 && !clear.simd_gt(splat(simd, min_clear)).any_true() {
                break;
            }
            start = end;
        }
        self.clear = Lanes::new(clear);
        for c in 0..3 {
            self.light[c] = Lanes::new(light[c]);
        }
        clear.simd_gt(splat(simd, min_clear)).any_true()
    }

    /// Notes where the transmittance falls to a half, on the way between two.
    #[inline(never)]
    fn note_depth<S: Simd>(
        &mut self,
        hides: mask32x16<S>,
        [clear, after]: [f32x16<S>; 2],
        near: f32x16<S>,
        length: f32x16<S>,
    ) {
        let (clear, after, near, length) = (clear.to_array(), after.to_array(), near.to_array(), length.to_array());
        for i in 0..LANES {
            if hides.test(i) {
                let whole = libm::logf(clear[i] / after[i].max(f32::MIN_POSITIVE));
                self.depth.0[i] = near[i] + length[i] * (libm::logf(clear[i] / HALF) / whole).clamp(0.0, 1.0);
            }
        }
    }
}
