//! March of packets in steps that are listed for each ray: where a field jumps, and steps must end.

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use vr_core::image_order::ImageSample;
use vr_core::{Ray, Rays};
use vr_kernels::vector::{LANES, Lanes, PacketLights, Sums, splat, step_light};

use super::fields::PacketField;
use super::march::{Medium, PacketResult, Path, finish, shaded};
use super::setup::Packet;

/// Steps of a ray, one by one.
pub(crate) trait RaySteps: Sync {
    /// Appends begin and length of each step of a part of a ray, in world units from the begin of the part.
    fn list(&self, ray: &Ray, part: [f64; 2], steps: &mut Vec<(f64, f64)>);
}

/// Steps that are listed for each ray.
#[derive(Clone, Copy)]
pub(crate) struct ListedSteps<'a> {
    pub(crate) steps: &'a dyn RaySteps,
    /// World length that lengths of steps are counted in: that of the packets' steps.
    pub(crate) unit: f64,
    /// Place of a step's sample, as a fraction of the step.
    pub(crate) offset: f64,
}

impl ListedSteps<'_> {
    /// Lists the steps of the rays of a packet through these places of the image.
    pub(super) fn fill(&self, rays: &Rays, spots: &[ImageSample], packet: &mut Packet) {
        for (lane, spot) in spots.iter().enumerate() {
            let steps = &mut packet.listed[lane];
            steps.clear();
            if packet.hits >> lane & 1 == 1 {
                let begin = packet.begin[lane];
                self.steps.list(&rays.at(spot.x, spot.y), [begin, begin + packet.length[lane]], steps);
            }
        }
    }
}

/// Takes the rays through their lists.
#[inline(always)]
pub(super) fn listed<S: Simd, T: PacketField>(
    simd: S,
    medium: &Medium<'_, T>,
    listed: ListedSteps<'_>,
    packet: &Packet,
    max_light: &Lanes,
    lights: &PacketLights,
    stages: &mut [T::Stage; 2],
) -> PacketResult {
    let ray = Path::new(simd, medium, packet);
    let zero = splat(simd, 0.0);
    let negligible = splat(simd, medium.negligible);
    let max_light = max_light.load(simd);
    let mut sums = Sums::new(simd);
    let mut samples = 0;
    // Rays that go on, by the number of their next steps; and those that ended before their last one.
    let (mut unfinished, mut next) = (packet.hits, [0; LANES]);
    let mut terminated = zero.simd_gt(zero);
    let [stage, _] = stages;
    while unfinished != 0 {
        // Next step of each ray, in the packet's steps from its middle one.
        let (mut begin, mut length, mut at) = (Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
        let mut has_more = Lanes::ZERO;
        let going_on = unfinished;
        for lane in (0..LANES).filter(|lane| going_on >> lane & 1 == 1) {
            let steps = &packet.listed[lane];
            let Some(&(from, long)) = steps.get(next[lane]) else {
                unfinished &= !(1 << lane);
                continue;
            };
            next[lane] += 1;
            let (from, long) = (from / listed.unit - packet.middle[lane], long / listed.unit);
            begin.0[lane] = from as f32;
            length.0[lane] = long as f32;
            at.0[lane] = (from + listed.offset * (long - 1.0)) as f32;
            has_more.0[lane] = if next[lane] < steps.len() { 1.0 } else { 0.0 };
        }
        let (begin, length) = (begin.load(simd), length.load(simd));
        let live = length.simd_gt(zero);
        samples += (live.to_bitmask() as u32).count_ones();
        let (_, cells) = ray.cells(simd, medium, at.load(simd));
        medium.field.fetch(simd, &cells, stage);
        let value = medium.field.value(simd, &cells, stage);
        let light = step_light(simd, medium.optics.rows().at(simd, value), length, medium.optics.emits);
        let light = medium.field.outside_vacuum(simd, light, stage);
        let light = shaded(simd, medium, lights, live, &ray, (&cells, length), light, stage);
        let cut = sums.add_up_to(simd, medium.level, live, [begin, length], light);
        let ended = cut | live & (sums.clear(simd) * max_light).simd_le(negligible);
        terminated |= ended & has_more.load(simd).simd_gt(zero);
        unfinished &= !(ended.to_bitmask() as u32);
    }
    finish(simd, &sums, packet, terminated, samples)
}
