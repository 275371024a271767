//! Fragments onto pixels.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{LANES, Lanes, Operator, Sums, pick, splat};

use super::chunk::{Chunk, SampleSet};
use super::state::State;
use crate::fragments::Fragments;

/// Inputs of a blend besides fragments.
#[derive(Clone, Copy)]
pub(crate) struct Blending<'a> {
    pub(crate) operator: Operator,
    /// True if samples are on the faces of slabs.
    pub(crate) on_faces: bool,
    /// A pixel is done when no more than this could be added to any component; below 0: never.
    pub(crate) negligible: f32,
    /// True if samples have colours, which are averaged as values are.
    pub(crate) tinted: bool,
    /// The largest light, or opacity, that can come from behind, by what is left clear.
    pub(crate) max_behind: &'a Lanes,
}

/// Blends the samples of a chunk onto pixels; returns how many there were. Rays whose pixels are done stop.
#[inline(never)]
pub(crate) fn blend<S: Simd>(
    simd: S,
    how: &Blending<'_>,
    which: SampleSet<'_>,
    rays: &mut Fragments,
    chunk: &Chunk,
    state: &mut State,
) -> u32 {
    simd.vectorize(
        #[inline(always)]
        || {
            let mut drawn = 0;
            match how.operator {
                // Light behind what is there, up to the level; opaque pixels stop.
                Operator::Under { level } => {
                    let mut sums = Sums::load(simd, &state.sums);
                    for j in 0..chunk.len {
                        let Sample { mut live, begin, length } = sample(simd, how, which, rays, j);
                        let mut light = fragment_light(simd, chunk, j);
                        // Vacuum is NaN, and nothing times that is NaN, too.
                        let defined = light[3].simd_eq(light[3]);
                        if !defined.all_true() {
                            live &= defined;
                            let zero = splat(simd, 0.0);
                            light = [
                                pick(defined, light[0], zero),
                                pick(defined, light[1], zero),
                                pick(defined, light[2], zero),
                                pick(defined, light[3], zero),
                            ];
                        }
                        drawn += live.to_bitmask().count_ones();
                        let reached = sums.add_up_to(simd, level, live, [begin, length], light);
                        if level < 1.0 {
                            stop(rays, reached.to_bitmask() as u32);
                        }
                        if how.negligible >= 0.0 {
                            // Only where something was added: what else waits, for another slice or brick, has its own time.
                            let left = sums.clear(simd) * how.max_behind.load(simd);
                            let done = live & left.simd_le(splat(simd, how.negligible));
                            stop(rays, done.to_bitmask() as u32);
                        }
                    }
                    sums.store(&mut state.sums);
                }
                // Light over what is there.
                Operator::Over => {
                    let [r, g, b, a] = &state.sums[0];
                    let mut sum = [r.load(simd), g.load(simd), b.load(simd), a.load(simd)];
                    for j in 0..chunk.len {
                        let light = fragment_light(simd, chunk, j);
                        let Sample { live, begin, length } = sample(simd, how, which, rays, j);
                        let live = live & light[3].simd_eq(light[3]);
                        drawn += live.to_bitmask().count_ones();
                        sum = over(simd, live, [begin, length], light, sum, &mut state.over);
                    }
                    let [r, g, b, a] = sum;
                    state.sums[0] = [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(a)];
                }
                // The largest of values, or of negated values for a minimum.
                Operator::Extreme { sign } => {
                    let (mut best, mut place) = (state.value.load(simd), state.other.load(simd));
                    for j in 0..chunk.len {
                        let value = chunk.value[j].load(simd) * sign;
                        let Sample { live, begin, length } = sample(simd, how, which, rays, j);
                        drawn += live.to_bitmask().count_ones();
                        [best, place] = extreme(live, [value, begin + length], [best, place]);
                    }
                    (state.value, state.other) = (Lanes::new(best), Lanes::new(place));
                }
                Operator::Average => drawn += averages(simd, how, which, rays, chunk, state),
                // The slab in which the threshold is passed; its ray stops.
                Operator::First { sign, threshold } => {
                    for j in 0..chunk.len {
                        let Sample { live, begin, length } = sample(simd, how, which, rays, j);
                        drawn += live.to_bitmask().count_ones();
                        let value = chunk.value[j].load(simd);
                        let passed = live & (value * sign).simd_ge(splat(simd, threshold * sign));
                        if passed.any_true() {
                            state.value = Lanes::new(pick(passed, begin + length, state.value.load(simd)));
                            state.other = Lanes::new(pick(passed, begin, state.other.load(simd)));
                            stop(rays, passed.to_bitmask() as u32);
                        }
                    }
                }
            }
            drawn
        },
    )
}

/// One sample of sixteen rays: which of them have it, and the number at which its slab begins, and how much of a whole one it is.
struct Sample<S: Simd> {
    live: mask32x16<S>,
    begin: f32x16<S>,
    length: f32x16<S>,
}

#[inline(always)]
fn sample<S: Simd>(simd: S, how: &Blending<'_>, which: SampleSet<'_>, rays: &Fragments, j: usize) -> Sample<S> {
    let zero = splat(simd, 0.0);
    match which {
        SampleSet::Outer(end) => {
            let live = rays.has[end].load(simd).simd_gt(zero);
            let [begin, length] = &rays.outer_span[end];
            let (begin, length) = (begin.load(simd), length.load(simd));
            // Where a ray enters, nothing lies before the sample.
            let length = if how.on_faces && end == 0 { zero } else { length };
            Sample { live, begin, length }
        }
        SampleSet::From(number) => {
            let n = number.load(simd) + j as f32;
            let live = n.simd_lt(rays.end.load(simd));
            if how.on_faces {
                let first = n.simd_le(rays.begin.load(simd));
                let [begin, length] = &rays.outer_span[0];
                let begin = pick(first, begin.load(simd), n - 1.0);
                let length = pick(first, length.load(simd), splat(simd, 1.0));
                Sample { live, begin, length }
            } else {
                Sample { live, begin: n - 0.5, length: splat(simd, 1.0) }
            }
        }
    }
}

#[inline(always)]
fn fragment_light<S: Simd>(simd: S, chunk: &Chunk, j: usize) -> [f32x16<S>; 4] {
    let [r, g, b, a] = &chunk.light[j];
    [r.load(simd), g.load(simd), b.load(simd), a.load(simd)]
}

/// Puts light over the sum so far, and notes the place of each fragment that hides something.
#[inline(always)]
fn over<S: Simd>(
    simd: S,
    live: mask32x16<S>,
    [begin, length]: [f32x16<S>; 2],
    light: [f32x16<S>; 4],
    mut sum: [f32x16<S>; 4],
    fragments: &mut Vec<[Lanes; 3]>,
) -> [f32x16<S>; 4] {
    let alpha = pick(live, light[3], splat(simd, 0.0));
    if alpha.simd_gt(splat(simd, 0.0)).any_true() {
        fragments.push([Lanes::new(begin), Lanes::new(length), Lanes::new(alpha)]);
    }
    let clear = splat(simd, 1.0) - light[3];
    for c in 0..4 {
        sum[c] = pick(live, light[c] + clear * sum[c], sum[c]);
    }
    sum
}

/// Returns the larger of a value and the best one so far, and its place.
#[inline(always)]
fn extreme<S: Simd>(live: mask32x16<S>, [value, at]: [f32x16<S>; 2], [best, place]: [f32x16<S>; 2]) -> [f32x16<S>; 2] {
    // False for NaN.
    let better = live & value.simd_gt(best);
    [pick(better, value, best), pick(better, at, place)]
}

/// Adds a value to a sum weighted by length, to the sum of lengths, and to the rounding error of the first.
#[inline(always)]
fn average<S: Simd>(
    simd: S,
    live: mask32x16<S>,
    [value, ratio]: [f32x16<S>; 2],
    [sum, length, lost]: [f32x16<S>; 3],
) -> [f32x16<S>; 3] {
    let zero = splat(simd, 0.0);
    let added = pick(live, value * ratio, zero);
    let next = sum + added;
    [next, length + pick(live, ratio, zero), lost + ((next - sum) - added)]
}

/// Adds a chunk's values, weighted by length, with the rounding error of the sum.
#[inline(always)]
fn averages<S: Simd>(
    simd: S,
    how: &Blending<'_>,
    which: SampleSet<'_>,
    rays: &Fragments,
    chunk: &Chunk,
    state: &mut State,
) -> u32 {
    let (mut sum, mut length, mut lost) = (state.value.load(simd), state.other.load(simd), state.lost.load(simd));
    let ratio = match which {
        SampleSet::Outer(end) => rays.outer_ratio[end].load(simd),
        SampleSet::From(_) => rays.ratio.load(simd),
    };
    let mut drawn = 0;
    for j in 0..chunk.len {
        let value = chunk.value[j].load(simd);
        let live = sample(simd, how, which, rays, j).live & value.simd_eq(value);
        drawn += live.to_bitmask().count_ones();
        [sum, length, lost] = average(simd, live, [value, ratio], [sum, length, lost]);
        if how.tinted {
            for (sum, light) in state.sums[0].iter_mut().zip(&chunk.light[j]) {
                *sum = Lanes::new(sum.load(simd) + pick(live, light.load(simd) * ratio, splat(simd, 0.0)));
            }
        }
    }
    (state.value, state.other, state.lost) = (Lanes::new(sum), Lanes::new(length), Lanes::new(lost));
    drawn
}

#[inline(always)]
fn stop(rays: &mut Fragments, which: u32) {
    if which & rays.hits != 0 {
        for i in 0..LANES {
            if which >> i & 1 == 1 {
                rays.stop(i);
            }
        }
    }
}
