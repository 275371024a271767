//! Engine of packets that pick values, as a tracer of rays.

use std::sync::Arc;

use fearless_simd::{Level, Simd};
use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::image_order::ImageSample;
use vr_core::{Counts, GradientMethod, GridVolume, ParameterError, Rays, Scene, View};
use vr_kernels::ranges::RangeBlocks;
use vr_kernels::vector::{self, LANES, Operator, Vectorized};

use super::march::{Peaks, PickMedium, march};
use crate::caster::{EmptySpace, RayCaster, Rule, Step, Traversal};
use crate::packet::engine::{fits, with_voxels};
use crate::packet::fields::{FilteredField, PacketField};
use crate::packet::level;
use crate::packet::setup::{FrameSetup, Packet};
use crate::pipeline::{Pipeline, SurfaceLook};
use crate::ray_value::RayValue;
use crate::tracer::{RaySample, Tracer};

/// State that the engine keeps from frame to frame.
#[derive(Clone, Debug)]
pub(crate) struct PickEngine {
    volume: Arc<GridVolume>,
    level: Level,
    operator: Operator,
    /// Length of a step in world units.
    step: f64,
    /// Place of a step's sample, as a fraction of the step.
    offset: f64,
    /// Bounds of what blocks have to pick; `None` where nothing is leaped over.
    peaks: Option<Arc<Peaks>>,
}

/// Cells along the edge of a block: looks and leaps cost more in smaller ones than they spare.
const EDGE: usize = 8;

impl PickEngine {
    /// Returns the engine for a scene and a caster's settings; `None` where it cannot draw them, and the plain one must.
    pub(crate) fn new(caster: &RayCaster, scene: &Scene, volume: &Arc<GridVolume>) -> Option<Self> {
        let level = level::of(caster.vector)?;
        let operator = Operator::new(scene.compositing, volume.calibration(), false);
        let is_plain = !operator.picks()
            || !matches!(caster.step, Step::Uniform(_))
            || caster.traversal != Traversal::Samples
            || caster.rule == Rule::Exact
            || caster.empty_space.is_named()
            // A mean has the mean colour of its ray.
            || operator == Operator::Average && scene.volume.colors().is_some();
        if is_plain || !fits(caster, volume) {
            return None;
        }
        let sign = match operator {
            Operator::Extreme { sign } | Operator::First { sign, .. } => Some(sign),
            _ => None,
        };
        let peaks = |sign| Arc::new(Peaks::new(&RangeBlocks::of_volume(volume, EDGE), sign));
        Some(Self {
            volume: Arc::clone(volume),
            level,
            operator,
            step: caster.world_step(volume.placement()),
            offset: if caster.rule == Rule::Left { 0.0 } else { 0.5 },
            peaks: sign.filter(|_| caster.empty_space != EmptySpace::None).map(peaks),
        })
    }
}

/// Engine with a view.
pub(crate) struct PickFrame<'a> {
    engine: &'a PickEngine,
    /// The plain engine, which shades surfaces.
    plain: Pipeline<'a, f32>,
    rays: Rays,
    /// Direction of the view, a unit vector.
    forward: DVec3,
}

impl<'a> PickFrame<'a> {
    /// # Errors
    /// A view that makes no sense.
    pub(crate) fn new(engine: &'a PickEngine, plain: Pipeline<'a, f32>) -> Result<Self, ParameterError> {
        let view: &View = plain.view;
        Ok(Self { engine, rays: Rays::new(view)?, forward: view.camera.frame()?.z_axis, plain })
    }

    fn setup(&self) -> FrameSetup<'_> {
        FrameSetup {
            rays: &self.rays,
            placement: self.engine.volume.placement(),
            dims: self.engine.volume.dims(),
            clip: &self.plain.view.clip,
            layer: self.plain.layer,
            step: self.engine.step,
            offset: self.engine.offset,
            forward: self.forward,
        }
    }
}

impl Tracer for PickFrame<'_> {
    fn trace(&self, spots: &[ImageSample], starts: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts) {
        let engine = self.engine;
        // Colours multiply what was picked, and a surface's gradient is the plain engine's.
        if let Some(field) = FilteredField::new(&engine.volume, None, GradientMethod::default()) {
            let medium = self.medium(field);
            vector::run(engine.level, Trace { frame: self, medium: &medium, spots, starts, values, counts });
            return;
        }
        with_voxels!(engine.volume, lattice => {
            let medium = self.medium(vector::Field::new(&lattice));
            vector::run(engine.level, Trace { frame: self, medium: &medium, spots, starts, values, counts });
        });
    }
}

/// Arguments of [`Tracer::trace`], for the visit of the voxel type.
struct Trace<'a, 'f, T> {
    frame: &'a PickFrame<'f>,
    medium: &'a PickMedium<'a, T>,
    spots: &'a [ImageSample],
    starts: Option<&'a [u32]>,
    values: &'a mut Vec<RaySample>,
    counts: &'a mut Counts,
}

impl<T: PacketField> Vectorized for Trace<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { frame, medium, spots, starts, values, counts } = self;
        let setup = frame.setup();
        let mut packet = Packet::EMPTY;
        let mut stages = [T::Stage::default(), T::Stage::default()];
        let mut surface = frame.plain.surface_look().filter(|_| matches!(medium.operator, Operator::First { .. }));
        for (group, spots) in spots.chunks(LANES).enumerate() {
            setup.packet(simd, spots, &[0.0; LANES], &mut packet);
            let mut traced = [RaySample::NOTHING; LANES];
            if packet.hits != 0 {
                if let Some(starts) = starts {
                    packet.begin_at(&starts[group * LANES..][..spots.len()]);
                }
                let picked = march(simd, medium, &packet, &mut stages);
                counts.rays += u64::from(packet.hits.count_ones());
                counts.samples += u64::from(picked.samples);
                counts.terminated += u64::from(picked.ended.count_ones());
                for i in (0..spots.len()).filter(|&i| picked.length.0[i] > 0.0) {
                    let [value, at, length] = [picked.value.0[i], picked.at.0[i], picked.length.0[i]];
                    traced[i] = frame.picked(&packet, i, (value, at, length), &spots[i], &mut surface);
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

impl<'a> PickFrame<'a> {
    fn medium<T: PacketField>(&self, field: T) -> PickMedium<'_, T> {
        let engine = self.engine;
        PickMedium {
            field,
            vacuum: engine.volume.vacuum_cells(),
            dims: engine.volume.dims(),
            operator: engine.operator,
            offset: engine.offset as f32,
            peaks: engine.peaks.as_deref(),
        }
    }

    /// Value of a ray that picked a number, at a position in steps from its middle and over a length.
    fn picked(
        &self,
        packet: &Packet,
        lane: usize,
        (value, at, length): (f32, f32, f32),
        spot: &ImageSample,
        surface: &mut Option<SurfaceLook<'a>>,
    ) -> RaySample {
        let (engine, scene) = (self.engine, self.plain.scene);
        let calibration = engine.volume.calibration();
        if engine.operator == Operator::Average {
            let mean = calibration.value(f64::from(value) / f64::from(length));
            return RayValue { rgba: scene.transfer.at(mean).pixel(), ..RayValue::NOTHING }.into();
        }
        let steps = packet.middle[lane] + f64::from(at) + engine.offset;
        let depth = packet.begin[lane] + (steps * engine.step).clamp(0.0, packet.length[lane]);
        let point = scene.transfer.at(calibration.value(f64::from(value)));
        let is_surface = matches!(engine.operator, Operator::First { .. });
        let [r, g, b] = point.color;
        let mut value = RayValue { rgba: if is_surface { [r, g, b, 1.0] } else { point.pixel() }, depth };
        if let Some(colors) = self.plain.colors {
            let at: [f32; 3] = std::array::from_fn(|a| {
                let last = (engine.volume.dims()[a] - 1) as f32;
                (packet.base[a].0[lane] + at * packet.delta[a].0[lane]).clamp(0.0, last)
            });
            let color = colors.at(at);
            (0..3).for_each(|c| value.rgba[c] *= f64::from(color[c]));
        }
        // A surface is shaded.
        if let Some(surface) = surface {
            surface.shade(&self.rays.at(spot.x, spot.y), &mut value);
        }
        value.into()
    }
}
