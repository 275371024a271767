//! March of sixteen rays that keep account of their error.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{Field, LANES, Lanes, PacketLights, Pairs, Stage, Sums, pick, splat};

use super::cell::{Ahead, Entry, Way};
use super::color_change::{ColorChange, PacketReflection, Places};
use super::cost_table::{CostTable, Here};
use super::step::{Absorption, Doubt, Step};
use super::stretch::{STEPS, Stretch};
use super::voxel_tints::VoxelTints;
use crate::leap::ClearSpace;

/// Medium that the rays of a frame go through.
#[derive(Clone, Copy)]
pub(super) struct Medium<'a, T> {
    pub(super) field: Field<'a, T>,
    pub(super) dims: [usize; 3],
    pub(super) clear: &'a ClearSpace,
    pub(super) costs: &'a CostTable,
    /// Difference of the largest and the smallest value of the field.
    pub(super) span: f32,
    /// Upper bound on the rounding error of the field's values at exact positions.
    pub(super) noise: f32,
    /// Error that a ray may have, relative to max(1, its radiance).
    pub(super) error: f32,
    /// `None` where colours reflect no light.
    pub(super) reflection: Option<&'a PacketReflection>,
    /// `None` where voxels have no colours of their own.
    pub(super) tints: Option<VoxelTints<'a>>,
}

impl<T> Medium<'_, T> {
    /// True if the transfer function's colours change from place to place.
    #[inline(always)]
    fn changes_colors(&self) -> bool {
        self.reflection.is_some() || self.tints.is_some()
    }
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
/// Share of the error allowed that the next step aims at: where colours stay as they are, and where they change from place to place.
const AIMS: [f32; 2] = [0.6, 0.4];
/// Largest number of rounds of a packet; rays that are not done then have no bound here.
const MAX_ROUNDS: u32 = 1 << 13;

/// Number of rounds after which the last rays of a packet are left to the cell-by-cell integrator, where colours change. It takes about as long for a ray as 3000 of these rounds do.
const MANY_ROUNDS: u32 = 1 << 12;

/// Numbers of rounds in a row with cheap steps, after which a stretch is tried: at first, and at most, as the number doubles with each stretch that costs more than its share.
const MIN_CALM: u32 = 4;
const MAX_CALM: u32 = 64;
/// Share of what a step may cost, up to which it is cheap enough for that.
const CHEAP: f32 = 1.0 / 16.0;

/// Largest number of rounds in which rays do not look for clear space, where few of them leaped: all others wait for these.
const MAX_PAUSE: u32 = 7;

/// Outcome of one round of sixteen rays.
struct Advance<S: Simd> {
    /// Rays that go on.
    taken: mask32x16<S>,
    to: f32x16<S>,
    /// Value and medium there.
    value: f32x16<S>,
    there: Here<S>,
    light: [f32x16<S>; 4],
    cost: f32x16<S>,
    /// Number of times that the transmittance is rounded.
    roundings: f32,
}

/// Takes sixteen rays to their ends.
#[inline(never)]
pub(super) fn march<S: Simd, T: Pairs>(
    simd: S,
    medium: &Medium<'_, T>,
    packet: &Packet,
    stages: &mut [Stage<T>; 2],
) -> Marched {
    simd.vectorize(
        #[inline(always)]
        || march_inlined(simd, medium, packet, stages),
    )
}

#[inline(always)]
fn march_inlined<S: Simd, T: Pairs>(
    simd: S,
    medium: &Medium<'_, T>,
    packet: &Packet,
    stages: &mut [Stage<T>; 2],
) -> Marched {
    let Medium { field, clear: space, costs, .. } = medium;
    let way = Way::new(simd, medium, packet);
    let Way { path, exits, margin, beyond, .. } = &way;
    let (margin, beyond) = (*margin, *beyond);
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let never = splat(simd, f32::NEG_INFINITY);
    let whole = packet.end.load(simd);
    let mut end = whole;
    let shortest = (margin * 8.0).max(splat(simd, SHORTEST));
    let per_length = splat(simd, 0.45 * medium.error) / whole.max(splat(simd, f32::MIN_POSITIVE));
    let brightest = splat(simd, costs.brightest);
    let mut sums = Sums::new(simd);
    let mut spent = zero;
    // Transmittance, and the place of the colours in a step, are rounded to half a unit beside 1: each may cost as much of the brightest light.
    let (mut rounded, unit) = (zero, splat(simd, 2.0 * f32::EPSILON * costs.brightest));
    let changes_colors = medium.changes_colors();
    let aim = AIMS[usize::from(changes_colors)];
    let mut failed = packet.backdrop.load(simd).simd_gt(brightest);
    end = pick(failed, never, end);
    let (mut at, mut out) = (packet.first.load(simd), never);
    // Rays that leap stand before a face, and look beyond it: what is there tells whether they leap on.
    let mut ahead = at;
    let mut step = one;
    let mut value = zero;
    let mut here = [zero; 5];
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
    // Rounds in which rays do not look for clear space yet, and how many there were of them last.
    let (mut pause, mut last_pause) = (0u32, 0u32);
    // Rounds in a row with cheap steps, and how many there have to be before the next stretch.
    let (mut calm, mut patience) = (0, MIN_CALM);
    loop {
        let mut live = at.simd_lt(end);
        if live.all_false() {
            break;
        }
        rounds += 1;
        // The last few rays of many steps are quicker one by one, where a step costs much.
        let few = changes_colors && rounds > MANY_ROUNDS && live.to_bitmask().count_ones() <= 2;
        if few || rounds > MAX_ROUNDS {
            failed |= live;
            break;
        }
        // Look up the cells that rays have come to, and leap over those in which nothing can be seen.
        let mut seeking = live & at.simd_ge(out);
        if pause > 0 {
            // Those in the middle of a leap look all the same.
            seeking &= ahead.simd_gt(at);
        }
        let (looks, mut leaped) = (pause == 0 && seeking.any_true(), live & !live);
        while seeking.any_true() {
            let (numbers, cells) = path.cells(simd, ahead);
            let code = space.at(simd, &cells);
            let exit = exits.of_box(simd, &numbers, &cells.fraction, code.to_float());
            let is_clear = code.simd_gt(0) | code.simd_eq(ClearSpace::CLEAR_CELL);
            // Where a ray crosses two faces at once, there may be a cell between those that were looked up: it goes on from before them, cell by cell.
            let follows = ahead.simd_le(at) | exits.crossed_one(simd, &cells.fraction, margin * 8.0);
            let leaping = seeking & is_clear & follows;
            // As far as no cell is clear, none is looked up.
            out = pick(seeking & !leaping, ahead + exit.max(margin), out);
            at = pick(leaping, at.max(ahead + exit - margin * 2.0), at);
            ahead = pick(leaping, ahead + exit + margin * 2.0, pick(seeking & !follows, at, ahead));
            fresh |= leaping;
            leaped |= leaping;
            live = at.simd_lt(end);
            seeking = live & leaping;
            let ready = live & !seeking;
            if 2 * ready.to_bitmask().count_ones() >= live.to_bitmask().count_ones() {
                break;
            }
        }
        if looks {
            let is_worth_it = 4 * leaped.to_bitmask().count_ones() >= live.to_bitmask().count_ones();
            last_pause = if is_worth_it { 0 } else { (2 * last_pause + 1).min(MAX_PAUSE) };
            pause = last_pause;
        } else {
            pause = pause.saturating_sub(1);
        }
        let active = live & !seeking;
        if active.all_false() {
            continue;
        }
        let clear = sums.clear(simd);
        // The cell of a ray that has leaped is that beyond the face.
        let within = (at + margin).max(ahead);
        let advance = if calm >= patience && !changes_colors {
            // Several steps under one account, where that has gone well of late.
            let stretch = Stretch::new(simd, medium, &way, [at, within, value, end], &here, [active, fresh], stages);
            samples += stretch.samples;
            let cost = clear * stretch.missed;
            let left = clear * (one - stretch.light[3]);
            // The depth at which opacity reaches a half is found within one step.
            let is_halved = clear.simd_gt(splat(simd, 0.5)) & left.simd_le(splat(simd, 0.5));
            let taken =
                active & cost.simd_le(allowed(simd, medium.error, [per_length * stretch.to, left, spent])) & !is_halved;
            let is_whole = (active & !taken).all_false();
            (calm, patience) = if is_whole { (MIN_CALM, MIN_CALM) } else { (0, (2 * patience).min(MAX_CALM)) };
            Advance {
                taken,
                to: stretch.to,
                value: stretch.value,
                there: stretch.there,
                light: stretch.light,
                cost,
                roundings: 1.0 + STEPS as f32,
            }
        } else {
            samples += active.to_bitmask().count_ones();
            let [stage, _] = &mut *stages;
            let entry = Entry::new(simd, medium, &way, [at, within, (at + step).min(end)], active, stage);
            let next = entry.step(simd, medium, &way, (value, fresh), stage);
            let Ahead { to, length, course, .. } = &next;
            let here = costs.entered(simd, &here, fresh, course.values[0]);
            let (to, length) = (*to, *length);
            let absorption = Absorption::new(simd, costs, &here, course, length);
            let doubt = Doubt::of_step(simd, costs, course, length);
            // Colours are asked for only where some can be seen.
            let mut color_change = None;
            if changes_colors && (active & doubt.is_seen(simd, absorption.opacity)).any_true() {
                places.cell = lanes(next.cell);
                places.middle = lanes(next.middle);
                places.length = Lanes::new(length);
                if let Some(reflection) = medium.reflection {
                    reflection.along(simd, field, &packet.lights, &places, stage, &mut found);
                } else {
                    found = ColorChange::NONE;
                }
                if let Some(tints) = &medium.tints {
                    tints.multiply(simd, &places, &mut found);
                }
                color_change = Some(&found);
            }
            let stepping = Step::new(simd, costs, &here, course, (absorption, doubt), [beyond, margin], color_change);
            let cost = clear * stepping.missed;
            let rounding = clear * stepping.rounding * 2.0;
            // Reject steps that cost more than their share; they are tried again, shorter.
            let left = clear * (one - stepping.light[3]);
            let allowed = allowed(simd, medium.error, [per_length * to, left, spent]);
            let is_cheap = cost.simd_le(rounding);
            let fits = is_cheap | cost.simd_le(allowed) | length.simd_le(shortest * 1.01);
            let taken = active & fits;
            let is_calm = (active & !(is_cheap | cost.simd_le(allowed * CHEAP))).all_false();
            calm = if is_calm { calm + 1 } else { 0 };
            // Costs grow with the cube of the length; those of what is reflected nearly with its fourth power, and what is allowed falls by what is spent.
            let mut ratio = (allowed * aim / cost.max(splat(simd, f32::MIN_POSITIVE))).sqrt();
            if changes_colors {
                ratio = ratio.sqrt();
                ratio *= ratio.sqrt();
            }
            let ratio = pick(is_cheap, splat(simd, 2.0), ratio.max(splat(simd, 0.125)).min(splat(simd, 2.0)));
            let grown = (length * ratio).max(shortest);
            // A step that ended at a face says nothing about longer ones: keep the length that was tried.
            let grown = pick(taken, grown.max(pick(length.simd_lt(step * 0.99), step, zero)), grown);
            step = pick(active, grown, step);
            Advance {
                taken,
                to,
                value: course.values[2],
                there: stepping.there,
                light: stepping.light,
                cost,
                roundings: 1.0,
            }
        };
        let Advance { taken, to, light, cost, .. } = advance;
        sums.add(simd, taken, [at, to - at], light);
        spent = pick(taken, spent + cost, spent);
        rounded = pick(taken & light[3].simd_gt(zero), rounded + clear * unit * advance.roundings, rounded);
        at = pick(taken, to, at);
        ahead = pick(taken, to, ahead);
        value = pick(taken, advance.value, value);
        for c in 0..5 {
            here[c] = pick(taken, advance.there[c], here[c]);
        }
        fresh &= !taken;
        // A ray ends where what is left of it is worth less than what is left of the error; or where the error is spent.
        let [r, g, b, _] = sums.rgba();
        let budget = (r.max(g).max(b) - spent).max(one) * medium.error;
        let rest = sums.clear(simd) * brightest;
        let over = taken & !(spent + rounded).simd_le(budget);
        failed |= over;
        let done = taken & (spent + rounded + rest).simd_le(budget * 0.99);
        spent = pick(done, spent + rest, spent);
        end = pick(done | over, never, end);
    }
    // The end of the ray is rounded to f32.
    spent += rounded + here[3] * sums.clear(simd) * whole.max(zero) * (f32::EPSILON * costs.brightest);
    finish(simd, packet, &sums, [spent, end], failed, samples, [medium.error, costs.brightest])
}

/// Returns half of what is left of the error that rays may have spent, behind which transmittances are left: a share by the distance, and one by the opacity gained.
#[inline(always)]
fn allowed<S: Simd>(simd: S, error: f32, [by_distance, left, spent]: [f32x16<S>; 3]) -> f32x16<S> {
    let share = by_distance + (splat(simd, 1.0) - left) * (0.45 * error);
    ((share - spent) * 0.5).max(splat(simd, 0.0))
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
