//! Rays of a frame through patches, sixteen after sixteen.

use vr_core::image_order::ImageSample;
use vr_core::{IndexRay, Layer, Ray, Rays, View};
use vr_kernels::vector::LANES;

use super::lanes::WorldRay;
use super::march::{LaneRay, Patches};
use super::steps::{Part, StepBatches};
use crate::source::Source;
use crate::tracer::RaySample;

/// Rays of a frame through patches.
pub(super) struct PatchRays<'a> {
    pub(super) rays: Rays,
    pub(super) source: &'a Source,
    pub(super) view: &'a View,
    pub(super) layer: Option<&'a Layer>,
    /// True if the ends of rays are sampled, too.
    pub(super) samples_ends: bool,
}

/// Sixteen rays, and their parts inside the volume.
pub(super) struct PatchPacket {
    /// Parts of the rays that meet the volume.
    pub(super) parts: [Option<IndexRay>; LANES],
    /// Unit vectors along the rays, axis by axis.
    pub(super) directions: [[f64; LANES]; 3],
}

impl PatchRays<'_> {
    /// Sets rays up through up to sixteen places of the image.
    #[inline(always)]
    pub(super) fn packet<'b, P: Patches>(
        &self,
        patches: &'b P,
        spots: &[ImageSample],
        batches: &'b mut [StepBatches; LANES],
    ) -> (PatchPacket, [Option<LaneRay<'b, impl Iterator<Item = Part> + use<'b, P>>>; LANES]) {
        let mut packet = PatchPacket { parts: [None; LANES], directions: [[0.0; LANES]; 3] };
        let mut batches = batches.iter_mut();
        let lane_rays = std::array::from_fn(|lane| {
            let spot = &spots[lane.min(spots.len() - 1)];
            let (ray, part) = self.cut(spot);
            (0..3).for_each(|a| packet.directions[a][lane] = ray.direction[a]);
            let batches = batches.next()?;
            let part = part.filter(|_| lane < spots.len())?;
            packet.parts[lane] = Some(part);
            batches.begin([part.start, part.end], self.samples_ends);
            let base = ray.origin + ray.direction * part.offset;
            let world = WorldRay { base, direction: ray.direction, start: part.start };
            Some(LaneRay { world, parts: patches.parts(ray, part), batches, before: part.start })
        });
        (packet, lane_rays)
    }

    /// Returns the ray through a place of the image, and its part inside the volume.
    fn cut(&self, spot: &ImageSample) -> (Ray, Option<IndexRay>) {
        let ray = self.rays.at(spot.x, spot.y);
        let far = self.layer.map_or(f64::INFINITY, |layer| layer.depth(spot.pixel));
        let part = IndexRay::new(&ray, self.source.placement(), self.source.dims(), &self.view.clip, far);
        (ray, part)
    }

    /// Puts samples in front of the surfaces behind them.
    pub(super) fn add_layer(&self, spots: &[ImageSample], traced: &mut [RaySample; LANES]) {
        let Some(layer) = self.layer else { return };
        for (value, spot) in traced.iter_mut().zip(spots) {
            *value = value.over(layer, spot.pixel);
        }
    }
}
