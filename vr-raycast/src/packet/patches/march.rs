//! March of packets through patches.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};
use vr_core::{IndexRay, Ray};
use vr_kernels::vector::{
    LANES, Lanes, OpticsTable, PacketLights, PacketShading, Shade, Stage, StepOptics, Sums, pick, splat, step_light,
};

use super::lanes::{LaneSteps, WorldRay};
use super::steps::{Batch, Part, StepBatches};
use crate::packet::march::PacketResult;

/// Volume that is a regular lattice patch by patch.
pub(crate) trait Patches: Sync {
    /// Patches that sixteen lanes are in.
    type Lanes;

    /// Samples that gradients are made of.
    type Around: Default;

    /// Lanes in no patch.
    fn nowhere(&self) -> Self::Lanes;

    /// Parts of a ray that are not vacuum, in its own distances.
    fn parts(&self, ray: Ray, part: IndexRay) -> impl Iterator<Item = Part>;

    /// Leads a lane into the patch of a batch of steps, and gives it the steps.
    fn enter(&self, within: &mut Self::Lanes, steps: &mut LaneSteps, lane: usize, ray: &WorldRay, batch: &Batch);

    /// Stages the samples around the places of the lanes' steps of these numbers, where lanes are live; a place where there is no field gets NaN, and so
    /// may one that [`complete`](Self::complete) gives a value.
    fn fetch<S: Simd>(
        &self,
        simd: S,
        within: &Self::Lanes,
        steps: &LaneSteps,
        number: f32x16<S>,
        live: u32,
        stage: &mut Stage<f32>,
    ) -> Place<S>;

    /// Values at places of live lanes, from those that were interpolated between the staged samples.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "lanes in registers: what held them would be kept in memory")]
    fn complete<S: Simd>(
        &self,
        _: S,
        _: &Self::Lanes,
        _: &LaneSteps,
        _: f32x16<S>,
        _: &Place<S>,
        _: u32,
        value: f32x16<S>,
    ) -> f32x16<S> {
        value
    }

    /// Gradients at places of live lanes, in the units that the shading is made for.
    #[expect(clippy::too_many_arguments, reason = "lanes in registers: what held them would be kept in memory")]
    fn gradients<S: Simd>(
        &self,
        simd: S,
        within: &Self::Lanes,
        steps: &LaneSteps,
        number: f32x16<S>,
        place: &Place<S>,
        live: u32,
        around: &mut Self::Around,
    ) -> [Lanes; 3];
}

/// Places of sixteen samples among those of their patches.
pub(crate) struct Place<S: Simd> {
    /// Sample below, axis by axis.
    pub(crate) low: [i32x16<S>; 3],
    /// Fraction of the way to the next.
    pub(crate) fraction: [f32x16<S>; 3],
}

/// Volume, and all that a packet's rays share.
pub(crate) struct PatchMedium<'a, P> {
    pub(crate) patches: P,
    pub(crate) optics: &'a OpticsTable,
    /// Shading; `None` if unshaded.
    pub(crate) shading: Option<&'a PacketShading>,
    /// Amount at which a ray ends: no more than this could be added to any component.
    pub(crate) negligible: f32,
    /// Opacity at which rays are cut; 1 where they are not.
    pub(crate) level: f32,
    /// World length that lengths of steps are counted in.
    pub(crate) unit: f64,
}

/// Ray of a lane, and its steps to come.
pub(crate) struct LaneRay<'b, I> {
    pub(crate) world: WorldRay,
    pub(crate) parts: I,
    pub(crate) batches: &'b mut StepBatches,
    /// Distance of the sample before the batch that its lane works off.
    pub(crate) before: f64,
}

/// Working memory of the march.
pub(crate) struct Work<P: Patches> {
    pub(super) steps: LaneSteps,
    pub(super) within: P::Lanes,
    pub(super) stages: [Stage<f32>; 2],
    around: P::Around,
}

impl<P: Patches> Work<P> {
    pub(crate) fn new(patches: &P) -> Self {
        Self {
            steps: LaneSteps::NONE,
            within: patches.nowhere(),
            stages: [Stage::default(), Stage::default()],
            around: P::Around::default(),
        }
    }
}

/// Takes the rays to their ends. `max_light` is the largest light or opacity that can come from behind, per transmittance left.
#[inline(never)]
pub(crate) fn march<S: Simd, P: Patches, I: Iterator<Item = Part>>(
    simd: S,
    medium: &PatchMedium<'_, P>,
    rays: &mut [Option<LaneRay<'_, I>>; LANES],
    max_light: &Lanes,
    lights: &PacketLights,
    work: &mut Work<P>,
) -> PacketResult {
    simd.vectorize(
        #[inline(always)]
        || through(simd, medium, rays, max_light, lights, work),
    )
}

#[inline(always)]
fn through<S: Simd, P: Patches, I: Iterator<Item = Part>>(
    simd: S,
    medium: &PatchMedium<'_, P>,
    rays: &mut [Option<LaneRay<'_, I>>; LANES],
    max_light: &Lanes,
    lights: &PacketLights,
    work: &mut Work<P>,
) -> PacketResult {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let negligible = splat(simd, medium.negligible);
    let max_light = max_light.load(simd);
    let rows = medium.optics.rows();
    let mut sums = Sums::new(simd);
    let (mut samples, mut terminated) = (0, 0u32);
    work.steps = LaneSteps::NONE;
    // Lanes whose rays may have more steps.
    let mut unfinished = (1u32 << LANES) - 1;
    loop {
        // Lanes whose batch is done take the next one of their rays.
        let idle = unfinished & !(work.steps.left.load(simd).simd_gt(zero).to_bitmask() as u32);
        if idle != 0 {
            unfinished &= !refill(&medium.patches, rays, idle, work);
        }
        let left = work.steps.left.load(simd);
        let live = left.simd_gt(zero);
        let bits = live.to_bitmask() as u32;
        if bits == 0 {
            break;
        }
        // Two steps at once: while the first waits for its samples, those of the second are fetched.
        let (number, length) = (work.steps.number.load(simd), work.steps.length.load(simd));
        let begin = work.steps.begin.load(simd);
        let (then, twice) = (number + one, left.simd_gt(one));
        let bits_then = twice.to_bitmask() as u32;
        let Work { steps, within, stages: [now, next], around } = &mut *work;
        let place = medium.patches.fetch(simd, within, steps, number, bits, now);
        let place_then = medium.patches.fetch(simd, within, steps, then, bits_then, next);
        let value = now.trilinear(simd, place.fraction);
        let value_then = next.trilinear(simd, place_then.fraction);
        let value = medium.patches.complete(simd, within, steps, number, &place, bits, value);
        let value_then = medium.patches.complete(simd, within, steps, then, &place_then, bits_then, value_then);
        let light = light_of(simd, medium, rows.at(simd, known(simd, value)), value, length);
        let light_then = light_of(simd, medium, rows.at(simd, known(simd, value_then)), value_then, length);
        let optics = (value, length);
        let light = shaded(simd, medium, lights, (within, steps), (live, number, &place), optics, light, around);
        let (lanes, optics) = ((twice, then, &place_then), (value_then, length));
        let light_then = shaded(simd, medium, lights, (within, steps), lanes, optics, light_then, around);
        // Composite them front to back.
        samples += bits.count_ones();
        let step = [begin + number * length, length];
        let cut = sums.add_up_to(simd, medium.level, live, step, light);
        let ended = cut | live & (sums.clear(simd) * max_light).simd_le(negligible);
        let on = twice & !ended;
        samples += (on.to_bitmask() as u32).count_ones();
        let step = [begin + then * length, length];
        let cut = cut | sums.add_up_to(simd, medium.level, on, step, light_then);
        let ended = cut | live & (sums.clear(simd) * max_light).simd_le(negligible);
        steps.number = Lanes::new(number + 2.0);
        let after = left - 2.0;
        steps.left = Lanes::new(pick(ended, zero, after));
        let ended = ended.to_bitmask() as u32;
        if ended != 0 {
            unfinished &= !ended;
            terminated |= terminate(rays, ended, &Lanes::new(after));
        }
    }
    let [r, g, b, a] = sums.rgba();
    PacketResult {
        rgba: [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(a)],
        half: sums.half(simd),
        samples,
        terminated,
    }
}

/// Gives lanes that have nothing to do the next steps of their rays; returns the lanes whose rays have no more.
#[inline(never)]
pub(super) fn refill<P: Patches, I: Iterator<Item = Part>>(
    patches: &P,
    rays: &mut [Option<LaneRay<'_, I>>; LANES],
    idle: u32,
    work: &mut Work<P>,
) -> u32 {
    let mut finished = 0;
    for (lane, slot) in rays.iter_mut().enumerate().filter(|(lane, _)| idle >> lane & 1 == 1) {
        match slot.as_mut().and_then(|ray| Some((ray.batches.next(&mut ray.parts)?, ray))) {
            Some((batch, ray)) => {
                ray.before = batch.before;
                patches.enter(&mut work.within, &mut work.steps, lane, &ray.world, &batch);
            }
            None => {
                work.steps.left.0[lane] = 0.0;
                finished |= 1 << lane;
            }
        }
    }
    finished
}

/// Ends rays; returns those of which steps were left.
#[inline(never)]
pub(super) fn terminate<I: Iterator<Item = Part>>(
    rays: &mut [Option<LaneRay<'_, I>>; LANES],
    ended: u32,
    left: &Lanes,
) -> u32 {
    let mut early = 0;
    for (lane, slot) in rays.iter_mut().enumerate().filter(|(lane, _)| ended >> lane & 1 == 1) {
        if let Some(mut ray) = slot.take() {
            let has_more = left.0[lane] > 0.0 || ray.batches.next(&mut ray.parts).is_some();
            early |= u32::from(has_more) << lane;
        }
    }
    early
}

/// Values in the place of those that are none.
#[inline(always)]
fn known<S: Simd>(simd: S, value: f32x16<S>) -> f32x16<S> {
    pick(value.simd_eq(value), value, splat(simd, 0.0))
}

/// Light of steps of a length; none in vacuum.
#[inline(always)]
fn light_of<S: Simd, P>(
    simd: S,
    medium: &PatchMedium<'_, P>,
    optics: [f32x16<S>; 4],
    value: f32x16<S>,
    length: f32x16<S>,
) -> [f32x16<S>; 4] {
    let (is_value, zero) = (value.simd_eq(value), splat(simd, 0.0));
    let [r, g, b, a] = step_light(simd, optics, length, medium.optics.emits);
    [pick(is_value, r, zero), pick(is_value, g, zero), pick(is_value, b, zero), pick(is_value, a, zero)]
}

/// Light after shading, where something is shaded, of samples of live lanes: values at places, which stand for steps of a length.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "lanes in registers: what held them would be kept in memory")]
fn shaded<S: Simd, P: Patches>(
    simd: S,
    medium: &PatchMedium<'_, P>,
    lights: &PacketLights,
    (within, steps): (&P::Lanes, &LaneSteps),
    (live, number, place): (mask32x16<S>, f32x16<S>, &Place<S>),
    (value, length): (f32x16<S>, f32x16<S>),
    light: [f32x16<S>; 4],
    around: &mut P::Around,
) -> [f32x16<S>; 4] {
    let Some(shading) = medium.shading else { return light };
    let [r, g, b, alpha] = light;
    // What shines without absorbing has a row, too.
    let seen = if shading.rows.is_some() { r.max(g).max(b).max(alpha) } else { alpha };
    let bits = (live & seen.simd_gt(splat(simd, 0.0))).to_bitmask() as u32;
    if bits == 0 {
        return light;
    }
    let gradient = medium.patches.gradients(simd, within, steps, number, place, bits, around);
    let mut lanes = [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(alpha)];
    let shade = Shade { shading, lights };
    if shading.follows_gradients() {
        let value = known(simd, value);
        let [r, g, b, kappa] = medium.optics.rows().at(simd, value);
        let row = [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(kappa)];
        let (value, length) = (Lanes::new(value), Lanes::new(length));
        let optics = StepOptics { value, row, length, emits: medium.optics.emits };
        shade.modulate(simd, &gradient, &optics, &mut lanes);
    }
    if shading.reflects {
        shade.apply_to_gradients(simd, &gradient, &mut lanes);
    }
    [lanes[0].load(simd), lanes[1].load(simd), lanes[2].load(simd), lanes[3].load(simd)]
}
