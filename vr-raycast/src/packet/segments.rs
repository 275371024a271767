//! March of packets in steps of one length along which the value changes: the rules linear and quadratic.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{Lanes, PacketLights, SegmentTable, Sums, pick, splat};

use super::fields::PacketField;
use super::leap::{Distances, Leaper};
use super::march::{Medium, PacketResult, Path, finish, shaded};
use super::setup::Packet;

/// Steps of one length along which the value is a straight line or a parabola.
#[derive(Clone, Copy)]
pub(crate) struct SegmentSteps<'a> {
    pub(crate) table: &'a SegmentTable,
    /// Distances to the nearest visible blocks; `None` if nothing is leaped over.
    pub(crate) distances: Option<&'a Distances>,
    /// True if the value is a parabola through the middle of the step, too.
    pub(crate) is_parabola: bool,
    /// Length of a step in world units.
    pub(crate) step: f32,
}

/// Number of rounds between two looks for invisible blocks, as in steps that one sample stands for.
const STRIDE: u32 = 2;

/// Takes the packet's rays to their ends: two lines a round, or one parabola. The sample at the end of a step is the one at the begin of the next;
/// after a leap it is taken anew, at the same place, so that no bit depends on the leap.
#[inline(always)]
pub(crate) fn segments<S: Simd, T: PacketField>(
    simd: S,
    medium: &Medium<'_, T>,
    steps: SegmentSteps<'_>,
    packet: &Packet,
    max_light: &Lanes,
    lights: &PacketLights,
    stages: &mut [T::Stage; 2],
) -> PacketResult {
    let ray = Path::new(simd, medium, packet);
    let (one, never) = (splat(simd, 1.0), splat(simd, f32::NEG_INFINITY));
    let negligible = splat(simd, medium.negligible);
    let max_light = max_light.load(simd);
    let mut at = packet.first.load(simd);
    let mut end = packet.end.load(simd);
    let leaper = Leaper::over(simd, steps.distances, packet, medium.dims);
    // Distance of two samples, in steps.
    let stride = if steps.is_parabola { 0.5 } else { 1.0 };
    let length = Lanes([steps.step; vr_kernels::vector::LANES]);
    // The value at the begin of the step, and the position at which it was taken.
    let (mut front, mut known) = (splat(simd, 0.0), splat(simd, f32::INFINITY));
    let mut sums = Sums::new(simd);
    let (mut samples, mut until_look) = (0, 0);
    loop {
        let mut live = at.simd_lt(end);
        if let Some(leaper) = &leaper {
            if until_look == 0 {
                until_look = STRIDE;
                loop {
                    let clear = clear_steps(simd, medium, &ray, leaper, at);
                    let invisible = live & clear.simd_ge(one);
                    if invisible.all_false() {
                        break;
                    }
                    let visible = live & !invisible;
                    at = pick(invisible, at + clear, at);
                    live = at.simd_lt(end);
                    let (seen, all) = (visible.to_bitmask().count_ones(), live.to_bitmask().count_ones());
                    if seen * 2 >= all {
                        break;
                    }
                }
            }
            until_look -= 1;
        }
        let bits = live.to_bitmask() as u32;
        if bits == 0 {
            break;
        }
        let [now, next] = &mut *stages;
        let stale = live & !known.simd_eq(at);
        if stale.any_true() {
            samples += stale.to_bitmask().count_ones();
            front = pick(stale, value(simd, medium, &ray, at, now), front);
        }
        let (middle, then) = (at + stride, at + 2.0 * stride);
        let (_, cells) = ray.cells(simd, medium, middle);
        medium.field.fetch(simd, &cells, now);
        let (_, cells_then) = ray.cells(simd, medium, then);
        medium.field.fetch(simd, &cells_then, next);
        let middle_value = medium.field.value(simd, &cells, now);
        let back = medium.field.value(simd, &cells_then, next);
        let values = [Lanes::new(front), Lanes::new(middle_value), Lanes::new(back)];
        front = back;
        known = then;
        if steps.is_parabola {
            samples += 2 * bits.count_ones();
            let mut light = [Lanes::ZERO; 4];
            steps.table.parabola(simd, &values, &length, bits, &mut light);
            let light = look(simd, medium, lights, live, &ray, [middle, one], &light, now);
            end = pick(sums.add_up_to(simd, medium.level, live, [at, one], light), never, end);
        } else {
            let two = middle.simd_lt(end);
            samples += bits.count_ones() + (live & two).to_bitmask().count_ones();
            let mut light = [[Lanes::ZERO; 4]; 2];
            steps.table.lines(simd, &values, &length, bits, &mut light);
            let first = look(simd, medium, lights, live, &ray, [at + 0.5, one], &light[0], now);
            end = pick(sums.add_up_to(simd, medium.level, live, [at, one], first), never, end);
            live = middle.simd_lt(end);
            let second = look(simd, medium, lights, live, &ray, [middle + 0.5, one], &light[1], next);
            end = pick(sums.add_up_to(simd, medium.level, live, [middle, one], second), never, end);
        }
        end = pick((sums.clear(simd) * max_light).simd_le(negligible), never, end);
        at = then;
    }
    // The last steps of all rays at once: shorter ones.
    let mut live = end.simd_gt(never);
    if let Some(leaper) = &leaper {
        live &= clear_steps(simd, medium, &ray, leaper, end).simd_lt(one);
    }
    let bits = live.to_bitmask() as u32;
    if bits != 0 {
        let ratio = packet.ratio.load(simd);
        let [now, next] = stages;
        let front = value(simd, medium, &ray, end, now);
        let back = value(simd, medium, &ray, end + ratio, now);
        let length = Lanes::new(ratio * steps.step);
        let mut light = [[Lanes::ZERO; 4]; 2];
        samples += 2 * bits.count_ones();
        if steps.is_parabola {
            samples += bits.count_ones();
            let middle = value(simd, medium, &ray, end + ratio * 0.5, next);
            let values = [Lanes::new(front), Lanes::new(middle), Lanes::new(back)];
            steps.table.parabola(simd, &values, &length, bits, &mut light[0]);
        } else {
            let values = [Lanes::new(front), Lanes::new(back), Lanes::new(back)];
            steps.table.lines(simd, &values, &length, bits, &mut light);
        }
        let light = look(simd, medium, lights, live, &ray, [end + ratio * 0.5, ratio], &light[0], now);
        sums.add_up_to(simd, medium.level, live, [end, ratio], light);
    }
    finish(simd, &sums, packet, end.simd_le(never), samples)
}

/// Returns the number of whole steps from a position on in which nothing is visible: 0 in a visible block.
///
/// A step must end in the box of clear blocks, not only begin there. All that the field goes through in the box is clear, and so is what lies between the
/// values at the ends of such a step.
#[inline(always)]
fn clear_steps<S: Simd, T: PacketField>(
    simd: S,
    medium: &Medium<'_, T>,
    ray: &Path<S>,
    (distances, leaper): &(&Distances, Leaper<S>),
    at: f32x16<S>,
) -> f32x16<S> {
    let (position, cells) = ray.cells(simd, medium, at);
    let distance = distances.at(simd, &cells);
    let steps = leaper.steps(simd, position, &cells, distance) - 1.0;
    pick(distance.simd_gt(0), steps, splat(simd, 0.0))
}

/// Returns the field at positions along the rays.
#[inline(always)]
fn value<S: Simd, T: PacketField>(
    simd: S,
    medium: &Medium<'_, T>,
    ray: &Path<S>,
    at: f32x16<S>,
    stage: &mut T::Stage,
) -> f32x16<S> {
    let (_, cells) = ray.cells(simd, medium, at);
    medium.field.fetch(simd, &cells, stage);
    medium.field.value(simd, &cells, stage)
}

/// Returns the light of steps after shading, by the gradients in their middles.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "lanes in registers: what held them would be kept in memory")]
fn look<S: Simd, T: PacketField>(
    simd: S,
    medium: &Medium<'_, T>,
    lights: &PacketLights,
    live: mask32x16<S>,
    ray: &Path<S>,
    [middle, length]: [f32x16<S>; 2],
    light: &[Lanes; 4],
    stage: &mut T::Stage,
) -> [f32x16<S>; 4] {
    let light = [light[0].load(simd), light[1].load(simd), light[2].load(simd), light[3].load(simd)];
    if medium.shading.is_none() {
        return light;
    }
    let (_, cells) = ray.cells(simd, medium, middle);
    shaded(simd, medium, lights, live, ray, (&cells, length), light, stage)
}
