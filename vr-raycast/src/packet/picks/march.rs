//! March of packets that pick values.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_core::VacuumCells;
use vr_kernels::ranges::RangeBlocks;
use vr_kernels::vector::{Cells, LANES, Lanes, Operator, pick, splat};

use super::choice::{Choice, MeanColor};
use super::listed::listed;
use crate::packet::fields::PacketField;
use crate::packet::gaps::there;
use crate::packet::leap::{Leaper, block_index};
use crate::packet::listed::ListedSteps;
use crate::packet::march::Path;
use crate::packet::setup::Packet;

/// Volume that all packets of a frame march through, and what they pick.
#[derive(Clone, Copy)]
pub(crate) struct PickMedium<'a, T> {
    pub(crate) field: T,
    /// Cells without a field; `None` if there are none.
    pub(crate) vacuum: Option<&'a VacuumCells>,
    pub(crate) dims: [usize; 3],
    pub(crate) operator: Operator,
    /// Place of a step's sample, as a fraction of the step.
    pub(crate) offset: f32,
    /// Bounds of what blocks have; `None` where everything counts.
    pub(crate) peaks: Option<&'a Peaks>,
    /// Steps that are listed for each ray, of fields that jump; `None` where all are of one length.
    pub(crate) listed: Option<ListedSteps<'a>>,
}

/// Upper bounds of the field times a sign, block by block.
#[derive(Clone, Debug)]
pub(crate) struct Peaks {
    shift: u32,
    blocks: [usize; 3],
    peak: Vec<f32>,
}

impl Peaks {
    /// Bounds of sign·field in blocks whose edge is a power of two.
    pub(crate) fn new(ranges: &RangeBlocks, sign: f32) -> Self {
        let of = |range: &vr_kernels::ranges::BlockRange| if sign > 0.0 { range.high } else { -range.low };
        let peak = ranges.ranges().iter().map(of).collect();
        Self { shift: ranges.edge().trailing_zeros(), blocks: ranges.blocks(), peak }
    }

    /// Bounds of the blocks of sixteen cells.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, cells: &Cells<S>) -> f32x16<S> {
        let index = block_index(cells, self.shift, self.blocks);
        let mut peak = Lanes::ZERO;
        for i in 0..LANES {
            peak.0[i] = *self.peak.get(index[i] as u32 as usize).unwrap_or(&f32::INFINITY);
        }
        peak.load(simd)
    }
}

/// Values that the rays of a packet picked.
pub(super) struct Picked {
    /// Extreme or first value; of a mean, the sum of values by length.
    pub(crate) value: Lanes,
    /// Sum of lengths, in steps; 0 where nothing was picked.
    pub(crate) length: Lanes,
    /// Position of the sample picked, in steps from the middle one's.
    pub(crate) at: Lanes,
    pub(crate) samples: u32,
    /// Mask of the rays that met a threshold before their last step.
    pub(crate) ended: u32,
    /// Sums of the colours of places by length; `None` but of means of what has colours.
    pub(super) color: Option<MeanColor>,
}

/// Halvings of the step in which a threshold is reached: a millionth of it is left, which is what f32 resolves.
pub(crate) const HALVINGS: u32 = 20;

/// Number of pairs of steps between two looks for blocks in which there is nothing to pick.
const STRIDE: u32 = 2;

/// Takes the packet's rays to their ends.
#[inline(never)]
pub(super) fn march<S: Simd, T: PacketField>(
    simd: S,
    medium: &PickMedium<'_, T>,
    packet: &Packet,
    stages: &mut [T::Stage; 2],
) -> Picked {
    match medium.listed {
        Some(steps) if T::STEPS.has_lists => simd.vectorize(
            #[inline(always)]
            || listed(simd, medium, steps, packet, stages),
        ),
        _ => simd.vectorize(
            #[inline(always)]
            || lattice(simd, medium, packet, stages),
        ),
    }
}

/// Steps of one length.
#[inline(always)]
fn lattice<S: Simd, T: PacketField>(
    simd: S,
    medium: &PickMedium<'_, T>,
    packet: &Packet,
    stages: &mut [T::Stage; 2],
) -> Picked {
    let (zero, one, never) = (splat(simd, 0.0), splat(simd, 1.0), splat(simd, f32::NEG_INFINITY));
    let ray = Path::new(simd, medium.dims, packet);
    let operator = medium.operator;
    let mut choice = Choice::new(simd, operator);
    let mut color = (medium.field.has_colors() && operator == Operator::Average).then_some(MeanColor::NONE);
    let [now, next] = stages;
    let mut at = packet.first.load(simd);
    let mut end = packet.end.load(simd);
    let hit = end.simd_gt(never);
    let mut samples = 0;
    // Ends of the ray are samples, too, where one may be picked.
    let has_ends = operator != Operator::Average;
    let begin = at - medium.offset;
    if has_ends {
        let (met, value) = sample(simd, medium, &ray, begin, hit, now);
        choice.take(simd, operator, met, [begin, begin, zero], value);
        samples += hit.to_bitmask().count_ones();
    }
    #[allow(clippy::manual_map)]
    let leaper = match medium.peaks {
        Some(peaks) => Some((peaks, Leaper::new(simd, peaks.shift, packet, medium.dims))),
        None => None,
    };
    let mut until_look = 0;
    loop {
        end = pick(choice.done(simd, operator), never, end);
        let mut live = at.simd_lt(end);
        if let Some((peaks, leaper)) = &leaper {
            if until_look == 0 {
                until_look = STRIDE;
                loop {
                    let (position, place) = ray.cells(simd, at);
                    let peak = peaks.at(simd, &place);
                    let dull = live
                        & match operator {
                            Operator::First { sign, threshold } => peak.simd_lt(splat(simd, threshold * sign)),
                            _ => peak.simd_le(choice.value),
                        };
                    if dull.all_false() {
                        break;
                    }
                    let known = live & !dull;
                    let steps = leaper.steps(simd, position, &place, fearless_simd::i32x16::splat(simd, 1));
                    at = pick(dull, at + steps, at);
                    live = at.simd_lt(end);
                    // Rays in blocks where there is something to pick outnumber those that have come to unknown ones.
                    if known.to_bitmask().count_ones() * 2 >= live.to_bitmask().count_ones() {
                        break;
                    }
                }
            }
            until_look -= 1;
        }
        let bits = live.to_bitmask();
        if bits == 0 {
            break;
        }
        // Two steps at once: while the first waits for its samples, those of the second are fetched.
        let (_, place) = ray.cells(simd, at);
        medium.field.fetch(simd, &place, now);
        let then = at + one;
        let (_, place_then) = ray.cells(simd, then);
        medium.field.fetch(simd, &place_then, next);
        let value = medium.field.value(simd, &place, now);
        let value_then = medium.field.value(simd, &place_then, next);
        let met = medium.field.has_field(simd, there(simd, medium.vacuum, &place, live), now);
        choice.take(simd, operator, met, [(at - 1.0).max(begin), at, one], value);
        let on = live & then.simd_lt(end);
        let met_then = medium.field.has_field(simd, there(simd, medium.vacuum, &place_then, on), next);
        choice.take(simd, operator, met_then, [at, then, one], value_then);
        if let Some(color) = &mut color {
            color.take(simd, &medium.field, met, (&place, one), now);
            color.take(simd, &medium.field, met_then, (&place_then, one), next);
        }
        samples += bits.count_ones() + on.to_bitmask().count_ones();
        at = pick(on, then + one, pick(live, then, at));
    }
    let ended = (hit & choice.done(simd, operator)).to_bitmask() as u32;

    // The last step, which may be a shorter one, and the end of the ray.
    let (last, ratio) = (packet.last.load(simd), packet.ratio.load(simd));
    let (_, place) = ray.cells(simd, last);
    medium.field.fetch(simd, &place, now);
    let before = (packet.end.load(simd) - 1.0).max(begin);
    let met = medium.field.has_field(simd, there(simd, medium.vacuum, &place, hit), now);
    choice.take(simd, operator, met, [before, last, ratio], medium.field.value(simd, &place, now));
    if let Some(color) = &mut color {
        color.take(simd, &medium.field, met, (&place, ratio), now);
    }
    samples += hit.to_bitmask().count_ones();
    if has_ends {
        let stop = packet.stop.load(simd) - medium.offset;
        let (met, value) = sample(simd, medium, &ray, stop, hit, next);
        choice.take(simd, operator, met, [last, stop, zero], value);
        samples += hit.to_bitmask().count_ones();
    }
    refine(simd, medium, &ray, &mut choice, now);
    Picked::new(&choice, operator, color, samples, ended)
}

/// Samples the field at positions; returns the live rays that have one there, and the values.
#[inline(always)]
pub(super) fn sample<S: Simd, T: PacketField>(
    simd: S,
    medium: &PickMedium<'_, T>,
    ray: &Path<S>,
    at: f32x16<S>,
    live: mask32x16<S>,
    stage: &mut T::Stage,
) -> (mask32x16<S>, f32x16<S>) {
    let (_, place) = ray.cells(simd, at);
    medium.field.fetch(simd, &place, stage);
    let value = medium.field.value(simd, &place, stage);
    (medium.field.has_field(simd, there(simd, medium.vacuum, &place, live), stage), value)
}

/// Halves the steps in which a threshold is reached, between two samples.
#[inline(always)]
pub(super) fn refine<S: Simd, T: PacketField>(
    simd: S,
    medium: &PickMedium<'_, T>,
    ray: &Path<S>,
    choice: &mut Choice<S>,
    stage: &mut T::Stage,
) {
    let Operator::First { sign, threshold } = medium.operator else { return };
    let found = choice.done(simd, medium.operator);
    if !found.any_true() {
        return;
    }
    let least = splat(simd, threshold * sign);
    for _ in 0..HALVINGS {
        let middle = (choice.before + choice.at) * 0.5;
        // Vacuum is below everything.
        let (is_field, value) = sample(simd, medium, ray, middle, found, stage);
        choice.halve(simd, is_field & (value * sign).simd_ge(least), middle, value);
    }
}

impl Picked {
    #[inline(always)]
    pub(super) fn new<S: Simd>(
        choice: &Choice<S>,
        operator: Operator,
        color: Option<MeanColor>,
        samples: u32,
        ended: u32,
    ) -> Self {
        let [value, length] = [Lanes::new(choice.number(operator)), Lanes::new(choice.length)];
        Self { value, length, at: Lanes::new(choice.at), samples, ended, color }
    }
}
