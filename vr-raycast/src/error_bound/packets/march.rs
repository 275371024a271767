//! March of sixteen rays that keep account of their error.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{Field, LANES, Lanes, PacketLights, Pairs, Stage, Sums, pick, splat};

use super::cell::Along;
use super::clear_blocks::ClearBlocks;
use super::color_change::{ColorChange, PacketReflection, Places};
use super::cost_table::CostTable;
use super::path::{Exits, Path};
use super::step::{Absorption, Course, Step};

/// Medium that the rays of a frame go through.
#[derive(Clone, Copy)]
pub(super) struct Medium<'a, T> {
    pub(super) field: Field<'a, T>,
    pub(super) dims: [usize; 3],
    pub(super) blocks: &'a ClearBlocks,
    pub(super) costs: &'a CostTable,
    /// Difference of the largest and the smallest value of the field.
    pub(super) span: f32,
    /// Upper bound on the rounding error of the field's values at exact positions.
    pub(super) noise: f32,
    /// Error that a ray may have, relative to max(1, its radiance).
    pub(super) error: f32,
    /// `None` where colours stay as they are.
    pub(super) reflection: Option<&'a PacketReflection>,
}

/// Sixteen rays in index space. Distances are in units of the smallest voxel edge, from where each ray enters.
pub(super) struct Packet {
    /// Mask of the rays that meet the volume.
    pub(super) hits: u32,
    /// Position where each ray enters, axis by axis.
    pub(super) base: [[f64; LANES]; 3],
    /// Cells per unit.
    pub(super) delta: [[f64; LANES]; 3],
    /// The same, rounded.
    pub(super) rounded_delta: [Lanes; 3],
    /// Distances from which something may be visible, and at which each ray ends; −∞ for one that does not meet the volume.
    pub(super) first: Lanes,
    pub(super) end: Lanes,
    /// Largest component of what stands behind the volume.
    pub(super) backdrop: Lanes,
    /// Lights as the rays see them; none where colours stay as they are.
    pub(super) lights: PacketLights,
}

/// Results of sixteen rays.
pub(super) struct Marched {
    pub(super) rgba: [Lanes; 4],
    /// Distance at which opacity reaches a half; +∞ where it does not.
    pub(super) half: Lanes,
    /// Masks of the rays whose bound is kept, and of those that ended early.
    pub(super) kept: u32,
    pub(super) ended: u32,
    pub(super) samples: u32,
}

/// Length of the shortest steps, which are taken whatever they cost.
const SHORTEST: f32 = 1.0 / 16384.0;
/// Share of the error allowed that the next step aims at: where colours stay as they are, and where they reflect.
const AIMS: [f32; 2] = [0.8, 0.4];
/// Error of a position, in cells: its three fractions are rounded to f32.
const MISPLACED: f32 = 4.0 / (1 << 24) as f32;
/// Largest number of rounds of a packet; rays that are not done then have no bound here.
const MAX_ROUNDS: u32 = 1 << 13;

/// Takes sixteen rays to their ends.
#[inline(never)]
pub(super) fn march<S: Simd, T: Pairs>(
    simd: S,
    medium: &Medium<'_, T>,
    packet: &Packet,
    stage: &mut Stage<T>,
) -> Marched {
    simd.vectorize(
        #[inline(always)]
        || march_inlined(simd, medium, packet, stage),
    )
}

#[inline(always)]
fn march_inlined<S: Simd, T: Pairs>(simd: S, medium: &Medium<'_, T>, packet: &Packet, stage: &mut Stage<T>) -> Marched {
    let Medium { field, blocks, costs, .. } = medium;
    let path = Path::new(simd, packet, medium.dims);
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let never = splat(simd, f32::NEG_INFINITY);
    let [dx, dy, dz] = &packet.rounded_delta;
    let delta = [dx.load(simd), dy.load(simd), dz.load(simd)];
    let exits = Exits::new(simd, &delta);
    // The cubic part is the third difference of the corners times dx dy dz h³ t(t − ½)(t − 1), the last of which is at most √3/36.
    let cubic = (delta[0] * delta[1] * delta[2]).abs() * 0.0482;
    let whole = packet.end.load(simd);
    let mut end = whole;
    // Distances are rounded to f32: steps end a little behind faces, and leaps a little before them, so that neither misses anything.
    let margin = whole.max(one) * (1.0 / (1 << 24) as f32);
    let shortest = (margin * 8.0).max(splat(simd, SHORTEST));
    // Behind its face a step follows the field of its own cell, over less than two margins. The two fields differ there by their slopes.
    let beyond = margin * margin * (8.0 * medium.span);
    let per_length = splat(simd, 0.45 * medium.error) / whole.max(splat(simd, f32::MIN_POSITIVE));
    let brightest = splat(simd, costs.brightest);
    let mut sums = Sums::new(simd);
    let mut spent = zero;
    // Transmittance, and the place of the colours in a step, are rounded to half a unit beside 1: each may cost as much of the brightest light.
    let (mut rounded, unit) = (zero, splat(simd, 2.0 * f32::EPSILON * costs.brightest));
    let aim = AIMS[usize::from(medium.reflection.is_some())];
    let mut failed = packet.backdrop.load(simd).simd_gt(brightest);
    end = pick(failed, never, end);
    let (mut at, mut out) = (packet.first.load(simd), never);
    let mut step = one;
    let mut value = zero;
    let mut here = [zero; 4];
    let mut noise = zero;
    let mut fresh = zero.simd_eq(zero);
    let mut found = ColorChange::NONE;
    let mut places = Places {
        cell: [Lanes::ZERO; 3],
        middle: [Lanes::ZERO; 3],
        length: Lanes::ZERO,
        margin: Lanes::new(margin),
        delta: packet.rounded_delta,
        whole: packet.end,
    };
    let (mut samples, mut rounds) = (0, 0);
    loop {
        let mut live = at.simd_lt(end);
        if live.all_false() {
            break;
        }
        rounds += 1;
        // The last few rays of many steps are quicker one by one, where a step costs much.
        let few = medium.reflection.is_some() && rounds > 1024 && live.to_bitmask().count_ones() <= 2;
        if few || rounds > MAX_ROUNDS {
            failed |= live;
            break;
        }
        // Look up the blocks that rays have come to, and leap over those in which nothing can be seen.
        let mut seeking = live & at.simd_ge(out);
        while seeking.any_true() {
            let (numbers, cells) = path.cells(simd, at);
            let [distance, span] = blocks.at(simd, &cells);
            let exit = exits.of_blocks(simd, &numbers, &cells.fraction, distance.max(one));
            let leaping = seeking & distance.simd_gt(zero) & exit.simd_gt(margin * 4.0);
            let found = seeking & !leaping;
            // Behind the next face another block is looked up.
            out = pick(found, at + exit.max(margin), out);
            // Fractions of a cell are rounded: at most this changes the value.
            noise = pick(found, span * MISPLACED + medium.noise, noise);
            at = pick(leaping, at + exit - margin * 2.0, at);
            fresh |= leaping;
            live = at.simd_lt(end);
            seeking = live & leaping;
            let ready = live & !seeking;
            if 2 * ready.to_bitmask().count_ones() >= live.to_bitmask().count_ones() {
                break;
            }
        }
        let active = live & !seeking;
        if active.all_false() {
            continue;
        }
        samples += active.to_bitmask().count_ones();
        // The step ends where the ray leaves the cell that lies ahead. A ray that has leaped first learns where it is, in a step of no length.
        let begin = at + margin;
        let (numbers, cells) = path.cells(simd, begin);
        field.fetch(simd, &cells, stage);
        let to = (begin + (exits.of_cell(simd, &cells.fraction) + margin)).min(at + step).min(end);
        let to = pick(fresh, at, to);
        let length = to - at;
        let back = at - begin;
        let (half, forth) = (back + length * 0.5, to - begin);
        let [x, y, z] = cells.fraction;
        let first = [x + delta[0] * back, y + delta[1] * back, z + delta[2] * back];
        let middle = [x + delta[0] * half, y + delta[1] * half, z + delta[2] * half];
        let last = [x + delta[0] * forth, y + delta[1] * forth, z + delta[2] * forth];
        let along = Along::new(simd, field, stage, [&first, &middle, &last]);
        let next = along.end;
        // The medium at the begin was looked up for the value that the last cell gave there.
        let off = pick(fresh, zero, (along.begin - value).abs());
        let course = Course {
            values: [pick(fresh, next, along.begin), along.middle, next],
            cubic: along.third.abs() * (cubic * length * length * length),
            unsure: noise + off + costs.misplaced,
        };
        let absorption = Absorption::new(simd, costs, &here, &course, length);
        // Colours are asked for only where some can be seen.
        let mut color_change = None;
        if let Some(reflection) = medium.reflection
            && (active & absorption.is_seen(simd)).any_true()
        {
            places.cell = lanes(numbers);
            places.middle = lanes(middle);
            places.length = Lanes::new(length);
            reflection.along(simd, field, &packet.lights, &places, stage, &mut found);
            color_change = Some(&found);
        }
        let behind_faces = [beyond, margin];
        let stepping = Step::new(simd, costs, &here, &course, absorption, behind_faces, color_change);
        let clear = sums.clear(simd);
        let cost = clear * stepping.missed;
        let rounding = clear * stepping.rounding * 2.0;
        let Step { light, there, .. } = stepping;
        let opacity = light[3];
        // Reject steps that cost more than their share; they are tried again, shorter.
        let left = clear * (one - opacity);
        let share = per_length * to + (one - left) * (0.45 * medium.error);
        let allowed = ((share - spent) * 0.5).max(zero);
        let is_cheap = cost.simd_le(rounding);
        let fits = fresh | is_cheap | cost.simd_le(allowed) | length.simd_le(shortest * 1.01);
        let taken = active & fits;
        let stepped = taken & !fresh;
        // Costs grow with the cube of the length; those of what is reflected nearly with its fourth power, and what is allowed falls by what is spent.
        let mut ratio = (allowed * aim / cost.max(splat(simd, f32::MIN_POSITIVE))).sqrt();
        if medium.reflection.is_some() {
            ratio = ratio.sqrt();
            ratio *= ratio.sqrt();
        }
        let ratio = pick(is_cheap, splat(simd, 2.0), ratio.max(splat(simd, 0.125)).min(splat(simd, 2.0)));
        let grown = (length * ratio).max(shortest);
        // A step that ended at a face says nothing about longer ones: keep the length that was tried.
        let grown = pick(stepped, grown.max(pick(length.simd_lt(step * 0.99), step, zero)), grown);
        step = pick(active & !fresh, grown, step);
        sums.add(simd, stepped, [at, length], light);
        spent = pick(stepped, spent + cost, spent);
        rounded = pick(stepped & opacity.simd_gt(zero), rounded + clear * unit, rounded);
        at = pick(taken, to, at);
        value = pick(taken, next, value);
        for c in 0..4 {
            here[c] = pick(taken, there[c], here[c]);
        }
        fresh &= !taken;
        // A ray ends where what is left of it is worth less than what is left of the error; or where the error is spent.
        let [r, g, b, _] = sums.rgba();
        let budget = (r.max(g).max(b) - spent).max(one) * medium.error;
        let rest = sums.clear(simd) * brightest;
        let over = stepped & !(spent + rounded).simd_le(budget);
        failed |= over;
        let done = stepped & (spent + rounded + rest).simd_le(budget * 0.99);
        spent = pick(done, spent + rest, spent);
        end = pick(done | over, never, end);
    }
    // The end of the ray is rounded to f32.
    spent += rounded + here[3] * sums.clear(simd) * whole.max(zero) * (f32::EPSILON * costs.brightest);
    finish(simd, packet, &sums, [spent, end], failed, samples, [medium.error, costs.brightest])
}

/// Stores three vectors. In the place of a closure, which is not inlined for certain.
#[inline(always)]
fn lanes<S: Simd>([x, y, z]: [f32x16<S>; 3]) -> [Lanes; 3] {
    [Lanes::new(x), Lanes::new(y), Lanes::new(z)]
}

/// Returns the results, and which rays have kept their bound after all roundings.
#[inline(always)]
fn finish<S: Simd>(
    simd: S,
    packet: &Packet,
    sums: &Sums<S>,
    [spent, end]: [f32x16<S>; 2],
    failed: mask32x16<S>,
    samples: u32,
    [error, brightest]: [f32; 2],
) -> Marched {
    let [r, g, b, a] = sums.rgba();
    let one = splat(simd, 1.0);
    let bright = r.max(g).max(b);
    // The sums are rounded once more.
    let kept = (spent + 16.0 * brightest * f32::EPSILON).simd_le((bright - spent).max(one) * error) & !failed;
    Marched {
        rgba: [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(a)],
        half: sums.half(simd),
        kept: packet.hits & kept.to_bitmask() as u32,
        ended: packet.hits & end.simd_le(splat(simd, f32::NEG_INFINITY)).to_bitmask() as u32,
        samples,
    }
}
