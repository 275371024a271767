//! Rays of a frame that pick values, sixteen after sixteen.

use fearless_simd::Simd;
use vr_core::image_order::ImageSample;
use vr_core::{Counts, Real};
use vr_kernels::vector::{LANES, Operator, Vectorized};

use super::look::{PickLook, PickedNumber};
use super::march::{PickMedium, Picked, march};
use crate::packet::fields::PacketField;
use crate::packet::setup::{FrameSetup, Packet};
use crate::pipeline::Pipeline;
use crate::tracer::RaySample;
use vr_core::Calibration;

/// Data that the rays of a frame share beside their medium.
pub(crate) struct PickRays<'a, 'p, R> {
    /// The plain engine, which shades surfaces.
    pub(crate) plain: &'p Pipeline<'a, R>,
    pub(crate) setup: FrameSetup<'p>,
    /// Calibration of the numbers that are picked.
    pub(crate) calibration: Calibration,
}

/// Arguments of [`Tracer::trace`](crate::tracer::Tracer::trace), for a medium.
pub(crate) struct PickTrace<'a, 'p, T, R> {
    pub(crate) rays: &'p PickRays<'a, 'p, R>,
    pub(crate) medium: &'p PickMedium<'p, T>,
    pub(crate) spots: &'p [ImageSample],
    pub(crate) starts: Option<&'p [u32]>,
    pub(crate) values: &'p mut Vec<RaySample>,
    pub(crate) counts: &'p mut Counts,
}

impl<T: PacketField, R: Real> Vectorized for PickTrace<'_, '_, T, R> {
    type Output = ();
    const AVX2_ALONE: bool = cfg!(test);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { rays, medium, spots, starts, values, counts } = self;
        let setup = &rays.setup;
        let mut packet = Packet::EMPTY;
        let mut stages = [T::Stage::default(), T::Stage::default()];
        let mut look = PickLook::new(rays.plain, medium.operator);
        for (group, spots) in spots.chunks(LANES).enumerate() {
            setup.packet(simd, spots, &[0.0; LANES], &mut packet);
            let mut traced = [RaySample::NOTHING; LANES];
            if packet.hits != 0 {
                if let Some(starts) = starts {
                    packet.begin_at(&starts[group * LANES..][..spots.len()]);
                }
                if let Some(listed) = &medium.listed {
                    listed.fill(setup.rays, spots, &mut packet);
                }
                let picked = march(simd, medium, &packet, &mut stages);
                counts.rays += u64::from(packet.hits.count_ones());
                counts.samples += u64::from(picked.samples);
                counts.terminated += u64::from(picked.ended.count_ones());
                for i in (0..spots.len()).filter(|&i| picked.length.0[i] > 0.0) {
                    traced[i] = look.sample(rays.number(medium.operator, &packet, &picked, i), &spots[i]);
                }
            }
            if let Some(layer) = setup.layer {
                for (value, spot) in traced.iter_mut().zip(spots) {
                    *value = value.over(layer, spot.pixel);
                }
            }
            values.extend_from_slice(&traced[..spots.len()]);
        }
    }
}

impl<R: Real> PickRays<'_, '_, R> {
    /// Number that a ray of a packet picked.
    fn number(&self, operator: Operator, packet: &Packet, picked: &Picked, lane: usize) -> PickedNumber {
        let (setup, length) = (&self.setup, f64::from(picked.length.0[lane]));
        let number = f64::from(picked.value.0[lane]);
        let number = if operator == Operator::Average { number / length } else { number };
        let steps = packet.middle[lane] + f64::from(picked.at.0[lane]) + setup.offset;
        PickedNumber {
            value: self.calibration.value(number),
            depth: packet.begin[lane] + (steps * setup.step).clamp(0.0, packet.length[lane]),
            color: picked.color.as_ref().map(|color| color.of_lane(lane).map(|sum| sum / length)),
        }
    }
}
