//! Values picked in steps that are listed for each ray.

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use vr_kernels::vector::{Operator, pick, splat};

use super::choice::{Choice, MeanColor};
use super::march::{PickMedium, Picked, refine, sample};
use crate::packet::fields::PacketField;
use crate::packet::listed::{ListedSteps, Lists};
use crate::packet::march::Path;
use crate::packet::setup::Packet;

/// Takes the rays through their lists.
#[inline(always)]
pub(super) fn listed<S: Simd, T: PacketField>(
    simd: S,
    medium: &PickMedium<'_, T>,
    steps: ListedSteps<'_>,
    packet: &Packet,
    [stage, _]: &mut [T::Stage; 2],
) -> Picked {
    let (zero, never) = (splat(simd, 0.0), splat(simd, f32::NEG_INFINITY));
    let ray = Path::new(simd, medium.dims, packet);
    let operator = medium.operator;
    let mut choice = Choice::new(simd, operator);
    let mut color = (medium.field.has_colors() && operator == Operator::Average).then_some(MeanColor::NONE);
    let hit = packet.end.load(simd).simd_gt(never);
    let (mut samples, mut ended) = (0, 0);
    // Ends of the ray are samples, too, where one may be picked.
    let has_ends = operator != Operator::Average;
    let begin = packet.first.load(simd) - medium.offset;
    let mut lists = Lists::new(steps, packet);
    if has_ends {
        let (met, value) = sample(simd, medium, &ray, begin, hit, stage);
        choice.take(simd, operator, met, [begin, begin, zero], value);
        samples += hit.to_bitmask().count_ones();
        let done = (hit & choice.done(simd, operator)).to_bitmask() as u32;
        lists.unfinished &= !done;
        ended |= done;
    }
    // Sample before: what lies between is vacuum, where it is not the step before.
    let mut last = begin;
    while lists.unfinished != 0 {
        let next = lists.take();
        let (at, length) = (next.at.load(simd), next.length.load(simd));
        let live = length.simd_gt(zero);
        samples += (live.to_bitmask() as u32).count_ones();
        let (_, place) = ray.cells(simd, at);
        medium.field.fetch(simd, &place, stage);
        let value = medium.field.value(simd, &place, stage);
        let met = medium.field.has_field(simd, live, stage);
        choice.take(simd, operator, met, [last.max(next.begin.load(simd) - 1.0), at, length], value);
        last = pick(live, at, last);
        if let Some(color) = &mut color {
            color.take(simd, &medium.field, met, (&place, length), stage);
        }
        let done = live & choice.done(simd, operator);
        lists.unfinished &= !(done.to_bitmask() as u32);
        ended |= (done & next.has_more.load(simd).simd_gt(zero)).to_bitmask() as u32;
    }
    if has_ends {
        let stop = packet.stop.load(simd) - medium.offset;
        let (met, value) = sample(simd, medium, &ray, stop, hit, stage);
        choice.take(simd, operator, met, [last.max(stop - 1.0), stop, zero], value);
        samples += hit.to_bitmask().count_ones();
    }
    refine(simd, medium, &ray, &mut choice, stage);
    Picked::new(&choice, operator, color, samples, ended)
}
