//! March of packets in steps that are listed for each ray: where a field jumps, and steps must end.

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use vr_core::image_order::ImageSample;
use vr_core::{Ray, Rays};
use vr_kernels::vector::{LANES, Lanes, PacketLights, Sums, splat, step_light};

use super::fields::PacketField;
use super::march::{Medium, PacketResult, Path, finish, shaded};
use super::setup::Packet;

/// Largest number of steps of a ray that are listed: 1 MiB.
pub(crate) const MAX_LISTED: f64 = (1 << 16) as f64;

/// Steps of a ray, one by one.
#[derive(Clone, Debug)]
pub(crate) struct StepList {
    /// Begin and length of each, in world units from the begin of the part of the ray.
    pub(crate) steps: Vec<(f64, f64)>,
    /// Kind of each, in fields that have several; else empty.
    pub(crate) kinds: Vec<u16>,
}

impl StepList {
    pub(crate) const EMPTY: Self = Self { steps: Vec::new(), kinds: Vec::new() };
}

/// Source of the listed steps of rays.
pub(crate) trait RaySteps: Sync {
    /// Appends the steps of a part of a ray to an empty list.
    fn list(&self, ray: &Ray, part: [f64; 2], list: &mut StepList);
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
            let list = &mut packet.listed[lane];
            list.steps.clear();
            list.kinds.clear();
            if packet.hits >> lane & 1 == 1 {
                let begin = packet.begin[lane];
                self.steps.list(&rays.at(spot.x, spot.y), [begin, begin + packet.length[lane]], list);
            }
        }
    }
}

/// Steps of the rays of a packet that are to be taken next, in the packet's steps from its middle ones; of length 0 where a ray has none.
pub(super) struct NextSteps {
    pub(super) begin: Lanes,
    pub(super) length: Lanes,
    /// Places of their samples.
    pub(super) at: Lanes,
    /// 1 where a ray has more steps behind.
    pub(super) has_more: Lanes,
    /// Kind of each step, in fields that have several.
    pub(super) kinds: [u16; LANES],
}

/// Lists of the rays of a packet, as far as they are not taken yet.
pub(super) struct Lists<'a> {
    /// Steps of the packet's per world unit.
    per_unit: f64,
    offset: f64,
    packet: &'a Packet,
    /// Mask of the rays that go on.
    pub(super) unfinished: u32,
    /// Number of the next step of each.
    next: [usize; LANES],
}

impl<'a> Lists<'a> {
    pub(super) fn new(listed: ListedSteps<'_>, packet: &'a Packet) -> Self {
        Self { per_unit: 1.0 / listed.unit, offset: listed.offset, packet, unfinished: packet.hits, next: [0; LANES] }
    }

    /// Takes the next step of each ray that goes on; those that have none are finished.
    #[inline(always)]
    pub(super) fn take(&mut self) -> NextSteps {
        let mut taken = NextSteps {
            begin: Lanes::ZERO,
            length: Lanes::ZERO,
            at: Lanes::ZERO,
            has_more: Lanes::ZERO,
            kinds: [0; LANES],
        };
        let going_on = self.unfinished;
        for lane in (0..LANES).filter(|lane| going_on >> lane & 1 == 1) {
            let StepList { steps, kinds } = &self.packet.listed[lane];
            let Some(&(from, long)) = steps.get(self.next[lane]) else {
                self.unfinished &= !(1 << lane);
                continue;
            };
            taken.kinds[lane] = kinds.get(self.next[lane]).copied().unwrap_or_default();
            self.next[lane] += 1;
            let (from, long) = (from * self.per_unit - self.packet.middle[lane], long * self.per_unit);
            taken.begin.0[lane] = from as f32;
            taken.length.0[lane] = long as f32;
            taken.at.0[lane] = (from + self.offset * (long - 1.0)) as f32;
            taken.has_more.0[lane] = if self.next[lane] < steps.len() { 1.0 } else { 0.0 };
        }
        taken
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
    let ray = Path::new(simd, medium.dims, packet);
    let zero = splat(simd, 0.0);
    let negligible = splat(simd, medium.negligible);
    let max_light = max_light.load(simd);
    let mut sums = Sums::new(simd);
    let mut samples = 0;
    let mut lists = Lists::new(listed, packet);
    // Rays that ended before their last step.
    let mut terminated = zero.simd_gt(zero);
    let [stage, _] = stages;
    while lists.unfinished != 0 {
        let next = lists.take();
        let (begin, length) = (next.begin.load(simd), next.length.load(simd));
        let live = length.simd_gt(zero);
        samples += (live.to_bitmask() as u32).count_ones();
        let (_, cells) = ray.cells(simd, next.at.load(simd));
        medium.field.set_kinds(stage, &next.kinds);
        medium.field.fetch(simd, &cells, stage);
        let value = medium.field.value(simd, &cells, stage);
        let light = step_light(simd, medium.optics.rows().at(simd, value), length, medium.optics.emits);
        let light = medium.field.outside_vacuum(simd, light, stage);
        let light = shaded(simd, medium, lights, live, &ray, (&cells, length), light, stage);
        let cut = sums.add_up_to(simd, medium.level, live, [begin, length], light);
        let ended = cut | live & (sums.clear(simd) * max_light).simd_le(negligible);
        terminated |= ended & next.has_more.load(simd).simd_gt(zero);
        lists.unfinished &= !(ended.to_bitmask() as u32);
    }
    finish(simd, &sums, packet, terminated, samples)
}
