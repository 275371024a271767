//! Engine of packets through patches, as a tracer of rays.

use std::sync::Arc;

use fearless_simd::{Level, Simd};
use vr_core::image_order::ImageSample;
use vr_core::{Counts, Layer, MaxRadiance, ParameterError, Rays, Scene, View};
use vr_kernels::tables::{BakedTransfer, rounding_over, table_range};
use vr_kernels::vector::{self, LANES, Lanes, OpticsTable, PacketLights, PacketShading, Vectorized};

use super::march::{PatchMedium, Patches, Work, march};
use super::rays::PatchRays;
use super::steps::StepBatches;
use super::volume::{PatchVolume, range_of, with_patches};
use crate::caster::{EmptySpace, Precision, RayCaster, Rule, TransferLookup};
use crate::leap::Visibility;
use crate::pace::{Lengths, Pace};
use crate::packet::level;
use crate::packet::ray_end::RayEnd;
use crate::packet::shading::{row_tables, world_shading};
use crate::source::Source;
use crate::table_range::MAX_ROUNDING;
use crate::tracer::{RaySample, Tracer};

/// State that the engine keeps from frame to frame.
#[derive(Clone, Debug)]
pub(crate) struct PatchEngine {
    volume: PatchVolume,
    pub(crate) level: Level,
    /// Table for steps of any length, in units of `unit`.
    optics: OpticsTable,
    /// World length in which steps are counted.
    unit: f64,
    end: RayEnd,
    max_radiance: MaxRadiance,
    shading: Option<PacketShading>,
}

impl PatchEngine {
    /// Returns the engine for a scene and a caster's settings; `None` where it cannot draw them, and the plain one must.
    pub(crate) fn new(caster: &RayCaster, scene: &Scene, source: &Source, lengths: Lengths) -> Option<Self> {
        let level = level::of(caster.vector)?;
        let end = RayEnd::new(caster, scene)?;
        let is_drawn = matches!(caster.rule, Rule::Auto | Rule::Midpoint)
            && caster.transfer_lookup != TransferLookup::Exact
            && caster.precision == Precision::F32;
        if !is_drawn {
            return None;
        }
        let (range, calibration) = range_of(&scene.volume)?;
        if rounding_over(range, calibration, false, &scene.transfer) > MAX_ROUNDING {
            return None;
        }
        let unit = caster.world_step(source.placement());
        let places = table_range(range, false, calibration, &scene.transfer);
        let table = Arc::new(BakedTransfer::<f32>::new(&scene.transfer, calibration, places, false, unit));
        if !table.resolves() {
            return None;
        }
        let leaps = caster.empty_space != EmptySpace::None;
        let visibility = leaps.then(|| Visibility::of_light(&scene.transfer, calibration, Some(&table), None));
        let pace = Pace { lengths, visibility };
        let rows = row_tables(scene, &table, calibration, unit)?;
        let has_gradients = scene.reflection().is_some() || scene.has_gradient_opacity();
        let volume = PatchVolume::new(&scene.volume, &pace, has_gradients)?;
        let shading = world_shading(scene, rows, volume.gradient_unit());
        Some(Self {
            volume,
            level,
            optics: OpticsTable::new(&table, &scene.transfer, calibration, unit),
            unit,
            end,
            max_radiance: scene.max_radiance(),
            shading,
        })
    }
}

/// Engine with a view.
pub(crate) struct PatchFrame<'a> {
    engine: &'a PatchEngine,
    rays: PatchRays<'a>,
}

impl<'a> PatchFrame<'a> {
    /// # Errors
    /// A view that makes no sense.
    pub(crate) fn new(
        engine: &'a PatchEngine,
        source: &'a Source,
        (view, layer): (&'a View, Option<&'a Layer>),
    ) -> Result<Self, ParameterError> {
        let rays = PatchRays { rays: Rays::new(view)?, source, view, layer, samples_ends: false };
        Ok(Self { engine, rays })
    }

    fn medium<P>(&self, patches: P) -> PatchMedium<'_, P> {
        PatchMedium {
            patches,
            optics: &self.engine.optics,
            shading: self.engine.shading.as_ref(),
            negligible: self.engine.end.negligible as f32,
            level: self.engine.end.cut as f32,
            unit: self.engine.unit,
        }
    }
}

impl Tracer for PatchFrame<'_> {
    fn trace(&self, spots: &[ImageSample], _: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts) {
        let engine = self.engine;
        with_patches!(&engine.volume, engine.unit, patches => {
            let medium = self.medium(patches);
            vector::run(engine.level, Trace { frame: self, medium: &medium, spots, values, counts });
        });
    }
}

/// Arguments of [`Tracer::trace`], for the visit of the kind of patches.
struct Trace<'a, 'f, P> {
    frame: &'a PatchFrame<'f>,
    medium: &'a PatchMedium<'a, P>,
    spots: &'a [ImageSample],
    values: &'a mut Vec<RaySample>,
    counts: &'a mut Counts,
}

impl<P: Patches> Vectorized for Trace<'_, '_, P> {
    type Output = ();
    const AVX2_ALONE: bool = cfg!(test);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { frame, medium, spots, values, counts } = self;
        let (mut lights, mut work) = (PacketLights::default(), Work::new(&medium.patches));
        let mut batches: [StepBatches; LANES] = std::array::from_fn(|_| StepBatches::default());
        for spots in spots.chunks(LANES) {
            let (packet, mut lane_rays) = frame.rays.packet(&medium.patches, spots, &mut batches);
            let mut traced = [RaySample::NOTHING; LANES];
            let hits = packet.parts.iter().flatten().count();
            if hits > 0 {
                if let Some(shading) = medium.shading {
                    lights.look_along(&shading.lights, &packet.directions);
                }
                let max_light = packet.parts.map(|part| match part {
                    Some(part) => frame.engine.max_radiance.over(part.length()) as f32,
                    None => 0.0,
                });
                let marched = march(simd, medium, &mut lane_rays, &Lanes(max_light), &lights, &mut work);
                counts.rays += hits as u64;
                counts.samples += u64::from(marched.samples);
                counts.terminated += u64::from(marched.terminated.count_ones());
                for (lane, part) in packet.parts.iter().enumerate() {
                    let Some(part) = part else { continue };
                    traced[lane].rgba = std::array::from_fn(|c| marched.rgba[c].0[lane]);
                    let half = f64::from(marched.half.0[lane]) * medium.unit;
                    traced[lane].depth = (part.offset + part.start + half) as f32;
                }
            }
            frame.rays.add_layer(spots, &mut traced);
            values.extend_from_slice(&traced[..spots.len()]);
        }
    }
}
