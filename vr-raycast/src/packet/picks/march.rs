//! March of packets that pick values.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_core::VacuumCells;
use vr_kernels::ranges::RangeBlocks;
use vr_kernels::vector::{Cells, LANES, Lanes, Operator, cells, inside, pick, splat};

use crate::packet::fields::PacketField;
use crate::packet::gaps::there;
use crate::packet::leap::{Leaper, block_index};
use crate::packet::setup::Packet;

/// Volume that all packets of a frame march through, and what they pick.
#[derive(Clone, Copy)]
pub(super) struct PickMedium<'a, T> {
    pub(super) field: T,
    /// Cells without a field; `None` if there are none.
    pub(super) vacuum: Option<&'a VacuumCells>,
    pub(super) dims: [usize; 3],
    pub(super) operator: Operator,
    /// Place of a step's sample, as a fraction of the step.
    pub(super) offset: f32,
    /// Bounds of what blocks have; `None` where everything counts.
    pub(super) peaks: Option<&'a Peaks>,
}

/// Upper bounds of the field times a sign, block by block.
#[derive(Clone, Debug)]
pub(super) struct Peaks {
    shift: u32,
    blocks: [usize; 3],
    peak: Vec<f32>,
}

impl Peaks {
    /// Bounds of sign·field in blocks whose edge is a power of two.
    pub(super) fn new(ranges: &RangeBlocks, sign: f32) -> Self {
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
    pub(super) value: Lanes,
    /// Sum of lengths, in steps; 0 where nothing was picked.
    pub(super) length: Lanes,
    /// Position of the sample picked, in steps from the middle one's.
    pub(super) at: Lanes,
    pub(super) samples: u32,
    /// Mask of the rays that met a threshold before their last step.
    pub(super) ended: u32,
}

/// What the rays have picked so far.
struct Choice<S: Simd> {
    value: f32x16<S>,
    /// Excess of a sum over what was added, by its roundings.
    lost: f32x16<S>,
    length: f32x16<S>,
    at: f32x16<S>,
    /// Position at which a threshold was not reached yet.
    before: f32x16<S>,
}

impl<S: Simd> Choice<S> {
    /// Takes the values of live rays at positions, each behind another one and standing for a length.
    #[inline(always)]
    fn take(
        &mut self,
        simd: S,
        operator: Operator,
        live: mask32x16<S>,
        [before, at, length]: [f32x16<S>; 3],
        value: f32x16<S>,
    ) {
        let zero = splat(simd, 0.0);
        match operator {
            Operator::Average => {
                // What roundings lose goes beside the sum, as in `Sums`.
                let added = pick(live, value * length, zero);
                let sum = self.value + added;
                self.lost += (sum - self.value) - added;
                self.value = sum;
                self.length += pick(live, length, zero);
            }
            Operator::Extreme { sign } => {
                let better = live & (value * sign).simd_gt(self.value);
                self.value = pick(better, value * sign, self.value);
                self.at = pick(better, at, self.at);
                self.length = pick(better, splat(simd, 1.0), self.length);
            }
            Operator::First { sign, threshold } => {
                let reached = live & (value * sign).simd_ge(splat(simd, threshold * sign)) & self.length.simd_le(zero);
                self.value = pick(reached, value, self.value);
                self.before = pick(reached, before, self.before);
                self.at = pick(reached, at, self.at);
                self.length = pick(reached, splat(simd, 1.0), self.length);
            }
            Operator::Under { .. } | Operator::Over => {}
        }
    }

    /// Rays that need not go on.
    #[inline(always)]
    fn done(&self, simd: S, operator: Operator) -> mask32x16<S> {
        let is_first = if matches!(operator, Operator::First { .. }) { 0.0 } else { f32::INFINITY };
        self.length.simd_gt(splat(simd, is_first))
    }
}

/// Halvings of the step in which a threshold is reached: a millionth of it is left, which is what f32 resolves.
const HALVINGS: u32 = 20;

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
    simd.vectorize(
        #[inline(always)]
        || through(simd, medium, packet, stages),
    )
}

#[inline(always)]
fn through<S: Simd, T: PacketField>(
    simd: S,
    medium: &PickMedium<'_, T>,
    packet: &Packet,
    stages: &mut [T::Stage; 2],
) -> Picked {
    let (zero, one, never) = (splat(simd, 0.0), splat(simd, 1.0), splat(simd, f32::NEG_INFINITY));
    let base = [packet.base[0].load(simd), packet.base[1].load(simd), packet.base[2].load(simd)];
    let delta = [packet.delta[0].load(simd), packet.delta[1].load(simd), packet.delta[2].load(simd)];
    let largest = medium.dims.map(|n| (n - 1) as f32);
    let last_cell = medium.dims.map(|n| n as i32 - 2);
    // A closure would not be inlined for certain.
    macro_rules! cells_at {
        ($at:expr) => {{
            let position = [
                inside(simd, base[0] + $at * delta[0], largest[0]),
                inside(simd, base[1] + $at * delta[1], largest[1]),
                inside(simd, base[2] + $at * delta[2], largest[2]),
            ];
            (position, cells(simd, position, last_cell))
        }};
    }
    let operator = medium.operator;
    let mut choice = Choice { value: zero, lost: zero, length: zero, at: zero, before: zero };
    if matches!(operator, Operator::Extreme { .. }) {
        choice.value = never;
    }
    let [now, next] = stages;
    let mut at = packet.first.load(simd);
    let mut end = packet.end.load(simd);
    let hit = end.simd_gt(never);
    let mut samples = 0;
    // Ends of the ray are samples, too, where one may be picked.
    let has_ends = operator != Operator::Average;
    let begin = at - medium.offset;
    if has_ends {
        let (_, place) = cells_at!(begin);
        medium.field.fetch(simd, &place, now);
        let met = there(simd, medium.vacuum, &place, hit);
        choice.take(simd, operator, met, [begin, begin, zero], medium.field.value(simd, &place, now));
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
                    let (position, place) = cells_at!(at);
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
        let (_, place) = cells_at!(at);
        medium.field.fetch(simd, &place, now);
        let then = at + one;
        let (_, place_then) = cells_at!(then);
        medium.field.fetch(simd, &place_then, next);
        let value = medium.field.value(simd, &place, now);
        let value_then = medium.field.value(simd, &place_then, next);
        let met = there(simd, medium.vacuum, &place, live);
        choice.take(simd, operator, met, [(at - 1.0).max(begin), at, one], value);
        let on = live & then.simd_lt(end);
        let met = there(simd, medium.vacuum, &place_then, on);
        choice.take(simd, operator, met, [at, then, one], value_then);
        samples += bits.count_ones() + on.to_bitmask().count_ones();
        at = pick(on, then + one, pick(live, then, at));
    }
    let ended = (hit & choice.done(simd, operator)).to_bitmask() as u32;

    // The last step, which may be a shorter one, and the end of the ray.
    let (last, ratio) = (packet.last.load(simd), packet.ratio.load(simd));
    let (_, place) = cells_at!(last);
    medium.field.fetch(simd, &place, now);
    let before = (packet.end.load(simd) - 1.0).max(begin);
    let met = there(simd, medium.vacuum, &place, hit);
    choice.take(simd, operator, met, [before, last, ratio], medium.field.value(simd, &place, now));
    samples += hit.to_bitmask().count_ones();
    if has_ends {
        let stop = packet.stop.load(simd) - medium.offset;
        let (_, place) = cells_at!(stop);
        medium.field.fetch(simd, &place, next);
        let met = there(simd, medium.vacuum, &place, hit);
        choice.take(simd, operator, met, [last, stop, zero], medium.field.value(simd, &place, next));
        samples += hit.to_bitmask().count_ones();
    }
    // Where a threshold is reached, between two samples.
    if let Operator::First { sign, threshold } = operator
        && choice.done(simd, operator).any_true()
    {
        let least = splat(simd, threshold * sign);
        for _ in 0..HALVINGS {
            let middle = (choice.before + choice.at) * 0.5;
            let (_, place) = cells_at!(middle);
            medium.field.fetch(simd, &place, now);
            let value = medium.field.value(simd, &place, now);
            // Vacuum is below everything.
            let reached = there(simd, medium.vacuum, &place, (value * sign).simd_ge(least));
            choice.value = pick(reached, value, choice.value);
            choice.at = pick(reached, middle, choice.at);
            choice.before = pick(reached, choice.before, middle);
        }
    }
    let value = match operator {
        Operator::Extreme { sign } => choice.value * sign,
        _ => choice.value - choice.lost,
    };
    Picked { value: Lanes::new(value), length: Lanes::new(choice.length), at: Lanes::new(choice.at), samples, ended }
}
