//! March of packets that pick values of patches.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{LANES, Lanes, Operator, pick, splat};

use super::lanes::LaneSteps;
use super::march::{LaneRay, Patches, Work, refill, terminate};
use super::steps::Part;
use crate::packet::picks::{Choice, HALVINGS};

/// Values that sixteen rays picked.
pub(super) struct PatchPicks {
    /// Extreme or first value; of a mean, the sum of values by length.
    pub(super) value: Lanes,
    /// Sum of lengths; 0 where nothing was picked.
    pub(super) length: Lanes,
    /// Distance from the begin of the ray to the sample picked, in units of length.
    pub(super) at: Lanes,
    /// For lanes whose threshold lies between samples of two batches, the distance along the ray of the sample before it.
    pub(super) before: [Option<f64>; LANES],
    pub(super) samples: u32,
    /// Mask of the rays that met a threshold before their last step.
    pub(super) terminated: u32,
}

/// Takes the rays to their ends.
#[inline(never)]
pub(super) fn pick_march<S: Simd, P: Patches, I: Iterator<Item = Part>>(
    simd: S,
    patches: &P,
    operator: Operator,
    rays: &mut [Option<LaneRay<'_, I>>; LANES],
    work: &mut Work<P>,
) -> PatchPicks {
    simd.vectorize(
        #[inline(always)]
        || through(simd, patches, operator, rays, work),
    )
}

#[inline(always)]
fn through<S: Simd, P: Patches, I: Iterator<Item = Part>>(
    simd: S,
    patches: &P,
    operator: Operator,
    rays: &mut [Option<LaneRay<'_, I>>; LANES],
    work: &mut Work<P>,
) -> PatchPicks {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let is_first = matches!(operator, Operator::First { .. });
    let mut choice = Choice::new(simd, operator);
    let mut before = [None; LANES];
    let (mut samples, mut terminated) = (0, 0u32);
    work.steps = LaneSteps::NONE;
    // Lanes whose rays may have more steps.
    let mut unfinished = (1u32 << LANES) - 1;
    loop {
        // Lanes whose batch is done take the next one of their rays.
        let idle = unfinished & !(work.steps.left.load(simd).simd_gt(zero).to_bitmask() as u32);
        if idle != 0 {
            unfinished &= !refill(patches, rays, idle, work);
        }
        let left = work.steps.left.load(simd);
        let live = left.simd_gt(zero);
        let bits = live.to_bitmask() as u32;
        if bits == 0 {
            break;
        }
        // Two steps at once: while the first waits for its samples, those of the second are fetched.
        let (number, length) = (work.steps.number.load(simd), work.steps.length.load(simd));
        let (then, twice) = (number + one, left.simd_gt(one));
        let bits_then = twice.to_bitmask() as u32;
        let Work { steps, within, stages: [now, next], .. } = &mut *work;
        let place = patches.fetch(simd, within, steps, number, bits, now);
        let place_then = patches.fetch(simd, within, steps, then, bits_then, next);
        let value = now.trilinear(simd, place.fraction);
        let value_then = next.trilinear(simd, place_then.fraction);
        let value = patches.complete(simd, within, steps, number, &place, bits, value);
        let value_then = patches.complete(simd, within, steps, then, &place_then, bits_then, value_then);
        // Positions are numbers of steps where a threshold is looked for, for it lies in one batch; else distances.
        let (at, at_then) = if is_first {
            (number, then)
        } else {
            let begin = steps.begin.load(simd);
            (begin + (number + 0.5) * length, begin + (then + 0.5) * length)
        };
        // Vacuum is not a number.
        choice.take(simd, operator, live & value.simd_eq(value), [at - 1.0, at, length.max(zero)], value);
        choice.take(simd, operator, twice & value_then.simd_eq(value_then), [at, at_then, length], value_then);
        samples += bits.count_ones() + bits_then.count_ones();
        steps.number = Lanes::new(number + 2.0);
        let after = left - 2.0;
        steps.left = Lanes::new(after);
        if is_first {
            let found = live & choice.done(simd, operator);
            let ended = found.to_bitmask() as u32;
            if ended != 0 {
                // The steps of such a lane are left as they are, to be halved.
                steps.left = Lanes::new(pick(found, zero, after));
                for lane in (0..LANES).filter(|lane| ended >> lane & 1 == 1) {
                    before[lane] = rays[lane].as_ref().map(|ray| ray.before);
                }
                unfinished &= !ended;
                terminated |= terminate(rays, ended, &Lanes::new(after));
            }
        }
    }
    if is_first {
        refine(simd, patches, operator, work, &mut choice, &mut before);
    }
    let [value, length] = [Lanes::new(choice.number(operator)), Lanes::new(choice.length)];
    PatchPicks { value, length, at: Lanes::new(choice.at), before, samples, terminated }
}

/// Halves the steps in which a threshold is reached, between two samples of a batch, and turns the numbers of steps into distances; leaves in `before` what is known of
/// those that lie between two batches.
#[inline(always)]
fn refine<S: Simd, P: Patches>(
    simd: S,
    patches: &P,
    operator: Operator,
    work: &mut Work<P>,
    choice: &mut Choice<S>,
    before: &mut [Option<f64>; LANES],
) {
    let Operator::First { sign, threshold } = operator else { return };
    let zero = splat(simd, 0.0);
    let inner = choice.done(simd, operator) & choice.before.simd_ge(zero);
    let bits = inner.to_bitmask() as u32;
    (0..LANES).filter(|lane| bits >> lane & 1 == 1).for_each(|lane| before[lane] = None);
    let Work { steps, within, stages: [stage, _], .. } = work;
    if bits != 0 {
        let least: f32x16<S> = splat(simd, threshold * sign);
        for _ in 0..HALVINGS {
            let middle = (choice.before + choice.at) * 0.5;
            let place = patches.fetch(simd, within, steps, middle, bits, stage);
            let value =
                patches.complete(simd, within, steps, middle, &place, bits, stage.trilinear(simd, place.fraction));
            // Vacuum is below everything.
            choice.halve(simd, inner & (value * sign).simd_ge(least), middle, value);
        }
    }
    choice.at = steps.begin.load(simd) + (choice.at + 0.5) * steps.length.load(simd);
}
