//! March of packets in steps along which the value changes: the rules linear and quadratic.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{Cells, Lanes, PacketLights, Shade, Sums, pick, splat};

use super::course::{Course, TwoLights};
use super::fields::PacketField;
use super::gaps::{outside_holes, there};
use super::leap::Leaper;
use super::local::{LocalSteps, REST};
use super::march::{Medium, PacketResult, Path, finish, in_lanes, shaded};
use super::setup::Packet;
use crate::leap::ClearSpace;
use crate::step_map::StepMap;

/// Steps along which the value is a straight line or a parabola.
#[derive(Clone, Copy)]
pub(crate) struct SegmentSteps<'a> {
    pub(crate) course: Course<'a>,
    pub(crate) lengths: SegmentLengths<'a>,
}

/// Lengths of such steps.
#[derive(Clone, Copy)]
pub(crate) enum SegmentLengths<'a> {
    /// One length. With the space that is leaped over, if there is any.
    Lattice(Option<&'a ClearSpace>),
    /// The length that each place asks for.
    Local(LocalSteps<'a>),
}

/// Number of rounds between two looks for clear space, as in steps that one sample stands for.
const STRIDE: u32 = 2;

/// Takes the packet's rays to their ends: two lines a round, or one parabola. The sample at the end of a step is the one at the begin of the next;
/// after a leap it is taken anew, at the same place, so that no bit depends on the leap.
///
/// In steps of one length, samples in holes are NaN. Steps of local lengths end at the faces of holes: there the voxels that stand for missing ones make
/// the field go on beyond the face, and a step is in a hole if its middle is.
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
    let ray = Path::new(simd, medium.dims, packet);
    let mut lengths = Walker::new(simd, medium, steps.lengths, packet);
    let never = splat(simd, f32::NEG_INFINITY);
    let negligible = splat(simd, medium.negligible);
    let max_light = max_light.load(simd);
    let mut at = packet.first.load(simd);
    let mut end = lengths.end(simd, packet);
    // The value at the begin of the step, and the position at which it was taken.
    let (mut front, mut known) = (splat(simd, 0.0), splat(simd, f32::INFINITY));
    let mut sums = Sums::new(simd);
    let mut samples = 0;
    loop {
        // Leap to the next step of each ray; find its length, and that of the one behind it.
        let (live, length) = lengths.next(simd, &ray, &mut at, end);
        let bits = live.to_bitmask() as u32;
        if bits == 0 {
            break;
        }
        let behind = at + length;
        let (mut follows, mut length_behind) = (live & !live, length * 0.5);
        let mut points = [at + length_behind, behind];
        if !steps.course.is_parabola {
            (follows, length_behind) = lengths.behind(simd, &ray, behind, end);
            follows &= live;
            points = [behind, behind + length_behind];
        }
        // Sample the field at the points where the value is not known yet, both at once.
        let [now, next] = &mut *stages;
        let stale = live & !known.simd_eq(at);
        if stale.any_true() {
            samples += stale.to_bitmask().count_ones();
            let (_, cells) = ray.cells(simd, at);
            medium.field.fetch(simd, &cells, now);
            front = pick(stale, lengths.value(simd, medium, &cells, now), front);
        }
        let (_, cells) = ray.cells(simd, points[0]);
        medium.field.fetch(simd, &cells, now);
        let (_, cells_behind) = ray.cells(simd, points[1]);
        medium.field.fetch(simd, &cells_behind, next);
        let first = lengths.value(simd, medium, &cells, now);
        let second = lengths.value(simd, medium, &cells_behind, next);
        let values = [Lanes::new(front), Lanes::new(first), Lanes::new(second)];
        samples += bits.count_ones();
        // Integrate, shade and composite a parabola, or two lines.
        let step = Stretch { at, length, live };
        if steps.course.is_parabola {
            samples += bits.count_ones();
            let [light, _] = look(simd, medium, steps, lights, &ray, &values, [step, step], stages);
            end = pick(sums.add_up_to(simd, medium.level, live, [at, length], light), never, end);
            (front, known) = (second, behind);
        } else {
            samples += follows.to_bitmask().count_ones();
            let step_behind = Stretch { at: behind, length: length_behind, live: follows };
            let [light, light_behind] = look(simd, medium, steps, lights, &ray, &values, [step, step_behind], stages);
            end = pick(sums.add_up_to(simd, medium.level, live, [at, length], light), never, end);
            // A ray ends after the step that leaves too little of it, whichever step shares the round.
            end = pick((sums.clear(simd) * max_light).simd_le(negligible), never, end);
            let goes_on = follows & end.simd_gt(never);
            let reached = sums.add_up_to(simd, medium.level, goes_on, [behind, length_behind], light_behind);
            end = pick(reached, never, end);
            front = pick(follows, second, first);
            known = pick(follows, points[1], behind);
        }
        end = pick((sums.clear(simd) * max_light).simd_le(negligible), never, end);
        // Rays that wait stay where they are.
        at = pick(live, pick(follows, points[1], behind), at);
    }
    finish(simd, &sums, packet, end.simd_le(never), samples)
}

/// Walk of a packet's rays from step to step.
enum Walker<'a, S: Simd> {
    Lattice {
        leaper: Option<(&'a ClearSpace, Leaper<S>)>,
        /// Length of the last step of each ray, as a fraction of a whole one.
        last: f32x16<S>,
        until_look: u32,
    },
    Local(LocalSteps<'a>, Leaper<S>),
}

impl<'a, S: Simd> Walker<'a, S> {
    #[inline(always)]
    fn new<T>(simd: S, medium: &Medium<'_, T>, lengths: SegmentLengths<'a>, packet: &Packet) -> Self {
        match lengths {
            SegmentLengths::Lattice(clear) => Self::Lattice {
                leaper: Leaper::over(simd, clear, packet, medium.dims),
                last: packet.ratio.load(simd),
                until_look: 0,
            },
            SegmentLengths::Local(steps) => {
                Self::Local(steps, Leaper::new(simd, StepMap::EDGE.trailing_zeros(), packet, medium.dims))
            }
        }
    }

    /// Returns the number of each ray's last step, in steps of one length; else the position of its end.
    #[inline(always)]
    fn end(&self, simd: S, packet: &Packet) -> f32x16<S> {
        match self {
            Self::Lattice { .. } => packet.end.load(simd),
            Self::Local(..) => packet.stop.load(simd),
        }
    }

    /// Leaps over clear space, until at least half of the rays that go on have a step to take. Returns those, and the lengths of the steps.
    #[inline(always)]
    fn next(&mut self, simd: S, ray: &Path<S>, at: &mut f32x16<S>, end: f32x16<S>) -> (mask32x16<S>, f32x16<S>) {
        match self {
            Self::Lattice { leaper, last, until_look } => {
                let one = splat(simd, 1.0);
                let mut live = at.simd_le(end);
                if let Some(leaper) = leaper {
                    if *until_look == 0 {
                        *until_look = STRIDE;
                        loop {
                            let clear = clear_steps(simd, ray, leaper, *at);
                            let invisible = live & clear.simd_ge(one);
                            if invisible.all_false() {
                                break;
                            }
                            let visible = live & !invisible;
                            *at = pick(invisible, *at + clear, *at);
                            live = at.simd_le(end);
                            let (seen, all) = (visible.to_bitmask().count_ones(), live.to_bitmask().count_ones());
                            if seen * 2 >= all {
                                break;
                            }
                        }
                    }
                    *until_look -= 1;
                }
                (live, pick(at.simd_lt(end), one, *last))
            }
            Self::Local(steps, leaper) => {
                // No rule over all values of a step crosses nodes at a mean.
                let mut no_means = Lanes::ZERO;
                let (live, length) = steps.leap(simd, ray, leaper, at, end, &mut no_means);
                (live, length.max(splat(simd, 0.0)).min(end - *at).max(splat(simd, 0.0)))
            }
        }
    }

    /// Returns the rays that can take a step from a position on, without a leap, and its length; 0 for the others.
    #[inline(always)]
    fn behind(&self, simd: S, ray: &Path<S>, at: f32x16<S>, end: f32x16<S>) -> (mask32x16<S>, f32x16<S>) {
        let zero = splat(simd, 0.0);
        let (follows, length) = match self {
            Self::Lattice { last, .. } => (at.simd_le(end), pick(at.simd_lt(end), splat(simd, 1.0), *last)),
            Self::Local(steps, leaper) => {
                let mut no_means = Lanes::ZERO;
                let length = steps.length(simd, ray, leaper, at, &mut no_means);
                (length.simd_ge(zero) & at.simd_lt(end - REST), length.min(end - at))
            }
        };
        (follows, pick(follows, length, zero))
    }

    /// Returns the field at places that were fetched; NaN in holes at whose faces steps do not end.
    #[inline(always)]
    fn value<T: PacketField>(&self, simd: S, medium: &Medium<'_, T>, cells: &Cells<S>, stage: &T::Stage) -> f32x16<S> {
        let value = medium.field.value(simd, cells, stage);
        if medium.vacuum.is_none() || matches!(self, Self::Local(..)) {
            return value;
        }
        let all = value.simd_eq(value);
        pick(there(simd, medium.vacuum, cells, all), value, splat(simd, f32::NAN))
    }
}

/// Step of each ray.
#[derive(Clone, Copy)]
struct Stretch<S: Simd> {
    at: f32x16<S>,
    length: f32x16<S>,
    live: mask32x16<S>,
}

/// Returns the number of whole steps from a position on in which nothing is visible: 0 in a visible cell.
///
/// A step must end in the clear cell or box of blocks, not only begin there. All that the field goes through in it is clear, and so is what lies between the
/// values at the ends of such a step.
#[inline(always)]
fn clear_steps<S: Simd>(
    simd: S,
    ray: &Path<S>,
    (clear, leaper): &(&ClearSpace, Leaper<S>),
    at: f32x16<S>,
) -> f32x16<S> {
    let (position, cells) = ray.cells(simd, at);
    let code = clear.at(simd, &cells);
    let steps = leaper.steps(simd, position, &cells, code) - 1.0;
    pick(code.simd_gt(0) | code.simd_eq(ClearSpace::CLEAR_CELL), steps, splat(simd, 0.0))
}

/// Returns the light of a parabola, or of two lines, after shading by the gradients in the middles of the steps.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "lanes in registers: what held them would be kept in memory")]
fn look<S: Simd, T: PacketField>(
    simd: S,
    medium: &Medium<'_, T>,
    steps: SegmentSteps<'_>,
    lights: &PacketLights,
    ray: &Path<S>,
    values: &[Lanes; 3],
    taken: [Stretch<S>; 2],
    stages: &mut [T::Stage; 2],
) -> [[f32x16<S>; 4]; 2] {
    let course = &steps.course;
    let lengths = [Lanes::new(taken[0].length * course.unit), Lanes::new(taken[1].length * course.unit)];
    let bits = taken[0].live.to_bitmask() as u32;
    let mut light = [[Lanes::ZERO; 4]; 2];
    course.light(simd, values, &lengths, bits, &mut light);
    let zero = splat(simd, 0.0);
    let mut seen = [[zero; 4]; 2];
    let ends_at_holes = medium.vacuum.is_some() && matches!(steps.lengths, SegmentLengths::Local(_));
    if medium.shading.is_none() && !ends_at_holes {
        for k in 0..2 {
            for c in 0..4 {
                seen[k][c] = light[k][c].load(simd);
            }
        }
        return seen;
    }
    let (_, middle) = ray.cells(simd, taken[0].at + taken[0].length * 0.5);
    let (_, middle_behind) = ray.cells(simd, taken[1].at + taken[1].length * 0.5);
    let middles = [middle, middle_behind];
    let count = if course.is_parabola { 1 } else { 2 };
    let modulated = medium.shading.filter(|shading| shading.modulation.is_some());
    if let Some(shading) = modulated {
        let places = [in_lanes(&middles[0]), in_lanes(&middles[1])];
        let extents = [ray.extent(medium, taken[0].length), ray.extent(medium, taken[1].length)];
        let shade = Shade { shading, lights };
        modulate(simd, medium, course, shade, values, &lengths, bits, (&places, &extents), &mut light, stages);
    }
    for k in 0..count {
        let Stretch { length, live, .. } = taken[k];
        let [r, g, b, alpha] = &light[k];
        seen[k] = [r.load(simd), g.load(simd), b.load(simd), alpha.load(simd)];
        if modulated.is_none() {
            seen[k] = shaded(simd, medium, lights, live, ray, (&middles[k], length), seen[k], &mut stages[k]);
        }
        if ends_at_holes {
            seen[k] = outside_holes(simd, medium.vacuum, &middles[k], live, seen[k]);
        }
    }
    seen
}

/// Changes light by the gradients in the middles of the steps: what absorbs is integrated anew, its extinction times the factors there, and then reflects.
///
/// κ times a factor over a length is κ over that length times the factor, but emission of its own must not be multiplied along.
#[inline(never)]
#[expect(clippy::too_many_arguments, reason = "what a step is integrated by, and the gradients")]
fn modulate<S: Simd, T: PacketField>(
    simd: S,
    medium: &Medium<'_, T>,
    course: &Course<'_>,
    shade: Shade<'_>,
    values: &[Lanes; 3],
    lengths: &[Lanes; 2],
    live: u32,
    (places, extents): (&[[[Lanes; 3]; 2]; 2], &[[Lanes; 3]; 2]),
    light: &mut TwoLights,
    stages: &mut [T::Stage; 2],
) {
    /// Factor that stands for 0 where emission is given on its own: the absorption that it leaves is lost in rounding.
    const FAINT: f32 = 1e-7;
    simd.vectorize(
        #[inline(always)]
        || {
            let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
            let count = if course.is_parabola { 1 } else { 2 };
            let emits = medium.optics.emits;
            let smallest = if emits { FAINT } else { 0.0 };
            // Find the gradients, where anything absorbs, and the lengths over which κ itself would absorb as much.
            let (mut gradients, mut turns) = ([[Lanes::ZERO; 3]; 2], [[Lanes::ZERO; 3]; 2]);
            let mut factors = [Lanes::ZERO; 2];
            let mut scaled = [Lanes::ZERO; 2];
            for k in 0..count {
                if light[k][3].load(simd).simd_gt(zero).all_false() {
                    continue;
                }
                [gradients[k], turns[k]] = medium.field.gradients(simd, &places[k], &extents[k], &mut stages[k]);
                factors[k] = shade.factors(simd, &gradients[k]);
                scaled[k] = Lanes::new(lengths[k].load(simd) * factors[k].load(simd).max(splat(simd, smallest)));
            }
            // Integrate over these, and take from the light what a longer or shorter source would add.
            let mut changed = [[Lanes::ZERO; 4]; 2];
            course.light(simd, values, &scaled, live, &mut changed);
            for k in 0..count {
                let factor = factors[k].load(simd);
                let absorbs = light[k][3].load(simd).simd_gt(zero);
                let is_clear = factor.simd_le(zero);
                let share = if emits { one / factor.max(splat(simd, smallest)) } else { one };
                for c in 0..4 {
                    let mut new = changed[k][c].load(simd);
                    new = if c < 3 { new * share } else { new };
                    if c == 3 || !emits {
                        new = pick(is_clear, zero, new);
                    }
                    light[k][c] = Lanes::new(pick(absorbs, new, light[k][c].load(simd)));
                }
                if shade.shading.reflects {
                    shade.apply_to_turning(simd, &gradients[k], &turns[k], &mut light[k]);
                }
            }
        },
    );
}
