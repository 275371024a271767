//! Light of sixteen segments, and what it adds to their samples.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{LANES, pick, source_weight_and_opacity, splat};

use super::samples::{Numbers, Samples, Sums};
use super::segment_table::Intervals;
use super::severe_segments::SevereSegments;
use super::steps::{Found, Segments, Steps, look_up};

/// Opacity at which a sample's depth is told.
const HALF: f32 = 0.5;

/// Severity of a segment (see [`severity`]) up to which it is taken at once, and of a part of a more severe one; parts at most: one behind the first few is
/// dark, or has one colour.
const AT_ONCE: f32 = 0.008;
const PART: f32 = 0.002;
const MAX_PARTS: u32 = 16;
/// Parts of a part that is severe by itself.
const FINE_PARTS: u32 = 8;
/// Severity of light that changes in a straight line, by the square of its optical depth.
const STRAIGHT: f32 = 0.15;
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

/// The table, and the transmittance below which nothing is added.
#[derive(Clone, Copy)]
pub(super) struct LightTable<'a> {
    pub(super) intervals: &'a Intervals,
    pub(super) min_clear: f32,
}

impl LightTable<'_> {
    /// Adds the light of segments to their samples, of severe ones later.
    #[inline(always)]
    pub(super) fn add<S: Simd>(
        &self,
        simd: S,
        samples: &mut Samples,
        numbers: &Numbers,
        segments: &Segments<S>,
        severe: &mut SevereSegments,
    ) {
        let [from, to] = segments.ends;
        let mut sums = samples.load(simd, numbers);
        let before = sums.clear;
        let (start, end) = (look_up(simd, self.intervals, from), look_up(simd, self.intervals, to));
        let steps = Steps::new(simd, to - from, segments.length);
        let mut of_steps = steps.sums(simd, &start, &end);
        let is_severe = severity(before, of_steps[0], segments.length, (&start, &end)).simd_gt(splat(simd, AT_ONCE));
        if is_severe.any_true() {
            severe.keep(numbers, segments, is_severe);
            for c in 0..4 {
                of_steps[c] = pick(is_severe, splat(simd, 0.0), of_steps[c]);
            }
        }
        if let Some((hides, before)) = sums.add(simd, &steps, of_steps, (&start, &end)) {
            note_depth(samples, numbers, hides, [before, sums.clear], [segments.near, segments.length]);
        }
        samples.store(numbers, &sums);
        samples.close_dark(simd, numbers, [before, sums.clear], self.min_clear);
        if severe.count >= LANES {
            severe.flush(simd, self, samples);
        }
    }

    /// Adds segments in parts, apart from the code that most segments need.
    #[inline(never)]
    pub(super) fn add_parts<S: Simd>(&self, simd: S, samples: &mut Samples, numbers: &Numbers, segments: &Segments<S>) {
        simd.vectorize(
            #[inline(always)]
            || self.add_parts_here(simd, samples, numbers, segments),
        );
    }

    /// Adds segments in parts; a part that is still severe, because there is a control point in it, in parts of its own.
    #[inline(always)]
    fn add_parts_here<S: Simd>(&self, simd: S, samples: &mut Samples, numbers: &Numbers, segments: &Segments<S>) {
        let [from, to] = segments.ends;
        let mut sums = samples.load(simd, numbers);
        let before = sums.clear;
        let mut start = look_up(simd, self.intervals, from);
        let end = look_up(simd, self.intervals, to);
        let whole = Steps::new(simd, to - from, segments.length).sums(simd, &start, &end);
        let measure = severity(before, whole[0], segments.length, (&start, &end));
        let worst = measure.to_array().into_iter().fold(0.0, f32::max);
        let count = ((worst / PART).sqrt().ceil() as u32).clamp(2, MAX_PARTS);

        let share = 1.0 / count as f32;
        let (rise, length) = ((to - from) * share, segments.length * share);
        let steps = Steps::new(simd, rise, length);
        let fine_share = 1.0 / FINE_PARTS as f32;
        let (fine_rise, fine_length) = (rise * fine_share, length * fine_share);
        for part in 0..count {
            let (first, near) = (from + rise * part as f32, segments.near + length * part as f32);
            let end = look_up(simd, self.intervals, from + rise * (part + 1) as f32);
            let part_sums = steps.sums(simd, &start, &end);
            let measure = severity(sums.clear, part_sums[0], length, (&start, &end));
            if measure.simd_gt(splat(simd, AT_ONCE)).any_true() {
                let fine = Steps::new(simd, fine_rise, fine_length);
                for part in 1..=FINE_PARTS {
                    let end = look_up(simd, self.intervals, first + fine_rise * part as f32);
                    if let Some((hides, before)) = sums.add(simd, &fine, fine.sums(simd, &start, &end), (&start, &end))
                    {
                        let near = near + fine_length * (part - 1) as f32;
                        note_depth(samples, numbers, hides, [before, sums.clear], [near, fine_length]);
                    }
                    start = end;
                }
            } else if let Some((hides, before)) = sums.add(simd, &steps, part_sums, (&start, &end)) {
                note_depth(samples, numbers, hides, [before, sums.clear], [near, length]);
            }
            if !sums.clear.simd_gt(splat(simd, self.min_clear)).any_true() {
                break;
            }
            start = end;
        }
        samples.store(numbers, &sums);
        samples.close_dark(simd, numbers, [before, sums.clear], self.min_clear);
    }
}

/// Notes where the transmittance falls to a half, on the way between two.
#[inline(never)]
fn note_depth<S: Simd>(
    samples: &mut Samples,
    numbers: &Numbers,
    hides: mask32x16<S>,
    [clear, after]: [f32x16<S>; 2],
    [near, length]: [f32x16<S>; 2],
) {
    let (clear, after, near, length) = (clear.to_array(), after.to_array(), near.to_array(), length.to_array());
    for i in 0..LANES {
        if hides.test(i) {
            let whole = libm::logf(clear[i] / after[i].max(f32::MIN_POSITIVE));
            let part = (libm::logf(clear[i] / HALF) / whole).clamp(0.0, 1.0);
            samples.depths[numbers[i] as usize] = near[i] + length[i] * part;
        }
    }
}
