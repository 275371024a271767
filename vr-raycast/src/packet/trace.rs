//! Rays of a frame, sixteen after sixteen.

use fearless_simd::Simd;
use vr_core::image_order::ImageSample;
use vr_core::{Counts, MaxRadiance};
use vr_kernels::vector::{LANES, Lanes, PacketLights, Vectorized};

use super::fields::PacketField;
use super::march::{MarchSteps, Medium, march};
use super::setup::{FrameSetup, Packet};
use crate::near_depths::NearDepths;
use crate::tracer::RaySample;

/// Data that the rays of a frame share beside their medium.
pub(super) struct TraceFrame<'a> {
    pub(super) setup: FrameSetup<'a>,
    /// Depths before which nothing can be seen; `None` if they are not known.
    pub(super) near: Option<&'a NearDepths>,
    pub(super) max_radiance: &'a MaxRadiance,
}

impl TraceFrame<'_> {
    /// Returns, for each ray, the largest light or opacity that can come from behind, per transmittance left.
    fn max_light(&self, packet: &Packet) -> Lanes {
        Lanes(packet.length.map(|length| self.max_radiance.over(length) as f32))
    }
}

/// Arguments of [`Tracer::trace`](crate::tracer::Tracer::trace), for a medium.
pub(super) struct Trace<'a, T> {
    pub(super) frame: &'a TraceFrame<'a>,
    pub(super) medium: &'a Medium<'a, T>,
    pub(super) spots: &'a [ImageSample],
    pub(super) starts: Option<&'a [u32]>,
    pub(super) values: &'a mut Vec<RaySample>,
    pub(super) counts: &'a mut Counts,
}

impl<T: PacketField> Vectorized for Trace<'_, T> {
    type Output = ();
    const AVX2_ALONE: bool = cfg!(test);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let setup = &self.frame.setup;
        let mut packet = Packet::EMPTY;
        let mut lights = PacketLights::default();
        let mut stages = [T::Stage::default(), T::Stage::default()];
        for (group, spots) in self.spots.chunks(LANES).enumerate() {
            let nearest = self.frame.near.map_or(Some([0.0; LANES]), |near| near.at_spots(spots));
            let mut traced = [RaySample::NOTHING; LANES];
            packet.hits = 0;
            if let Some(nearest) = nearest {
                setup.packet(simd, spots, &nearest, &mut packet);
            }
            if packet.hits != 0 {
                if let Some(starts) = self.starts {
                    packet.begin_at(&starts[group * LANES..][..spots.len()]);
                }
                if let MarchSteps::Listed(steps) = &self.medium.steps {
                    steps.fill(setup.rays, spots, &mut packet);
                }
                let max_light = self.frame.max_light(&packet);
                if let Some(shading) = self.medium.shading {
                    lights.look_along(&shading.lights, &packet.directions);
                }
                let marched = march(simd, self.medium, &packet, &max_light, &lights, &mut stages);
                self.counts.rays += u64::from(packet.hits.count_ones());
                self.counts.samples += u64::from(marched.samples);
                self.counts.terminated += u64::from(marched.terminated.count_ones());
                for i in 0..spots.len() {
                    let steps = packet.middle[i] + f64::from(marched.half.0[i]);
                    let rgba = &marched.rgba;
                    traced[i].rgba = [rgba[0].0[i], rgba[1].0[i], rgba[2].0[i], rgba[3].0[i]];
                    traced[i].depth = (packet.begin[i] + steps * setup.step) as f32;
                }
            }
            if let Some(layer) = setup.layer {
                for (value, spot) in traced.iter_mut().zip(spots) {
                    *value = value.over(layer, spot.pixel);
                }
            }
            self.values.extend_from_slice(&traced[..spots.len()]);
        }
    }
}
