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
        let row = &table[index[i] as u32 as usize];
        let rate = f32x4::load_array_ref(simd, &row.rate);
        integrals[i] = f32x4::load_array_ref(simd, &row.start) + f32x4::splat(simd, fraction[i]) * rate;
        rates[i] = rate;
    }
    // Integrals stay packed: only differences of them are wanted.
    Found { integrals: packed(integrals), rates: transpose(rates) }
}

/// Severity of a segment (see [`severity`]) up to which it is taken at once, and of a part of a more severe one; parts at most: one behind the first few is
/// dark, or has one colour.
const AT_ONCE: f32 = 0.008;
const PART: f32 = 0.002;
const MAX_PARTS: u32 = 16;
/// Parts of a part that is severe by itself.
const FINE_PARTS: u32 = 8;
/// Severity of light that changes in a straight line, by the square of its optical depth.
const STRAIGHT: f32 = 0.15;
/// Intervals of the table, below which a difference of two integrals is more rounding than integral.
const NARROW: f32 = 4.0;

/// Segments, or parts of them, of one length each.
#[derive(Clone, Copy)]
struct Steps<S: Simd> {
    length: f32x16<S>,
    /// Length for each interval of the table; 0 where the range of values is narrow.
    stretch: f32x16<S>,
    is_narrow: mask32x16<S>,
    any_narrow: bool,
}

impl<S: Simd> Steps<S> {
    /// Steps from one place to another in the table, by `rise`.
    #[inline(always)]
    fn new(simd: S, rise: f32x16<S>, length: f32x16<S>) -> Self {
        let is_narrow = rise.abs().simd_lt(splat(simd, NARROW));
        let stretch = pick(is_narrow, splat(simd, 0.0), length / pick(is_narrow, splat(simd, 1.0), rise));
        Self { length, stretch, is_narrow, any_narrow: is_narrow.any_true() }
    }

    /// Optical depth, and the light that is sent, of steps between two look-ups.
    #[inline(always)]
    fn sums(&self, simd: S, start: &Found<S>, end: &Found<S>) -> [f32x16<S>; 4] {
        // Without `map`, which is not inlined here and would lose the level's instructions.
        let [a, b, c, d] = end.integrals;
        let [e, f, g, h] = start.integrals;
        let [tau, red, green, blue] = transpose_packed([a - e, b - f, c - g, d - h]);
        let by = self.stretch;
        let mut sums = [tau * by, red * by, green * by, blue * by];
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

/// Measure of what a segment's light may be off by, at a transmittance: its optical depth by what of that does not follow from both ends, because a control
/// point lies between, and by itself.
#[inline(always)]
fn severity<S: Simd>(
    clear: f32x16<S>,
    tau: f32x16<S>,
    length: f32x16<S>,
    (start, end): (&Found<S>, &Found<S>),
) -> f32x16<S> {
    let straight = (start.rates[0] + end.rates[0]) * 0.5 * length;
    clear * tau * ((tau - straight).abs() + tau * STRAIGHT)
}

/// Light and transmittance while a cell is added.
#[derive(Clone, Copy)]
struct Sums<S: Simd> {
    light: [f32x16<S>; 3],
    clear: f32x16<S>,
}

impl<S: Simd> Sums<S> {
    /// Adds steps; returns the samples in which half becomes hidden, if there are any, and the transmittance before.
    #[inline(always)]
    fn add(
        &mut self,
        simd: S,
        steps: &Steps<S>,
        [tau, red, green, blue]: [f32x16<S>; 4],
        (start, end): (&Found<S>, &Found<S>),
    ) -> Option<(mask32x16<S>, f32x16<S>)> {
        let (weight, alpha) = source_weight_and_opacity(simd, tau);
        // Light from the far end is dimmed by more than that from the near end: to the first order, by what both change on the way.
        let scale = steps.length * (1.0 / 12.0);
        let change = |c: usize| (end.rates[c] - start.rates[c]) * scale;
        let deepens = change(0);
        let before = self.clear;
        let dimmed = before * weight;
        for (c, sum) in [red, green, blue].into_iter().enumerate() {
            let order = sum * deepens - change(c + 1) * tau;
            self.light[c] += dimmed * (sum + order).max(splat(simd, 0.0));
        }
        self.clear = before - before * alpha;
        let half = splat(simd, HALF);
        let hides = before.simd_ge(half) & self.clear.simd_lt(half);
        hides.any_true().then_some((hides, before))
    }
}

/// Segments on their way through the table.
#[derive(Clone, Copy)]
struct Course<'a, S: Simd> {
    table: &'a [Interval],
    /// Place in the table at the first end, and distance there.
    from: f32x16<S>,
    near: f32x16<S>,
}

impl Stamp {
    /// Adds the light of segments. Returns false once all samples are opaque: none is clearer than `min_clear`.
    #[inline(always)]
    pub(super) fn add<S: Simd>(&mut self, simd: S, table: &[Interval], segments: &Segments<S>, min_clear: f32) -> bool {
        let [from, to] = segments.ends;
        let rise = to - from;
        let [red, green, blue] = &self.light;
        let light = [red.load(simd), green.load(simd), blue.load(simd)];
        let mut sums = Sums { light, clear: self.clear.load(simd) };
        let start = look_up(simd, table, from);
        let end = look_up(simd, table, to);
        let whole = Steps::new(simd, rise, segments.length);
        let whole_sums = whole.sums(simd, &start, &end);
        let measure = severity(sums.clear, whole_sums[0], segments.length, (&start, &end));
        if !measure.simd_gt(splat(simd, AT_ONCE)).any_true() {
            if let Some((hides, before)) = sums.add(simd, &whole, whole_sums, (&start, &end)) {
                self.note_depth(hides, [before, sums.clear], segments.near, segments.length);
            }
        } else {
            let worst = measure.to_array().into_iter().fold(0.0, f32::max);
            let count = ((worst / PART).sqrt().ceil() as u32).clamp(2, MAX_PARTS);
            let course = Course { table, from, near: segments.near };
            self.add_parts(simd, &mut sums, course, (start, rise, segments.length), count, min_clear);
        }
        self.clear = Lanes::new(sums.clear);
        for c in 0..3 {
            self.light[c] = Lanes::new(sums.light[c]);
        }
        sums.clear.simd_gt(splat(simd, min_clear)).any_true()
    }

    /// Adds segments in parts; a part that is still severe, because there is a control point in it, in parts of its own.
    #[inline(always)]
    fn add_parts<S: Simd>(
        &mut self,
        simd: S,
        sums: &mut Sums<S>,
        course: Course<'_, S>,
        (mut start, rise, length): (Found<S>, f32x16<S>, f32x16<S>),
        count: u32,
        min_clear: f32,
    ) {
        let share = 1.0 / count as f32;
        let (rise, length) = (rise * share, length * share);
        let steps = Steps::new(simd, rise, length);
        let fine_share = 1.0 / FINE_PARTS as f32;
        let (fine_rise, fine_length) = (rise * fine_share, length * fine_share);
        for part in 0..count {
            let (first, near) = (course.from + rise * part as f32, course.near + length * part as f32);
            let end = look_up(simd, course.table, course.from + rise * (part + 1) as f32);
            let part_sums = steps.sums(simd, &start, &end);
            let measure = severity(sums.clear, part_sums[0], length, (&start, &end));
            if measure.simd_gt(splat(simd, AT_ONCE)).any_true() {
                let fine = Steps::new(simd, fine_rise, fine_length);
                for part in 1..=FINE_PARTS {
                    let end = look_up(simd, course.table, first + fine_rise * part as f32);
                    if let Some((hides, before)) = sums.add(simd, &fine, fine.sums(simd, &start, &end), (&start, &end))
                    {
                        let near = near + fine_length * (part - 1) as f32;
                        self.note_depth(hides, [before, sums.clear], near, fine_length);
                    }
                    start = end;
                }
            } else if let Some((hides, before)) = sums.add(simd, &steps, part_sums, (&start, &end)) {
                self.note_depth(hides, [before, sums.clear], near, length);
            }
            if !sums.clear.simd_gt(splat(simd, min_clear)).any_true() {
                break;
            }
            start = end;
        }
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
