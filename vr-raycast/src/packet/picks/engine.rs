//! Engine of packets that pick values, as a tracer of rays.

use std::sync::Arc;

use fearless_simd::Level;
use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::image_order::ImageSample;
use vr_core::{Counts, GradientMethod, GridVolume, ParameterError, Scene};
use vr_kernels::ranges::RangeBlocks;
use vr_kernels::vector::{self, Operator};

use super::march::{Peaks, PickMedium};
use super::trace::{PickRays, PickTrace};
use crate::caster::{EmptySpace, RayCaster, Rule, Step, Traversal};
use crate::packet::engine::{fits, with_voxels};
use crate::packet::fields::{FilteredField, PacketField};
use crate::packet::level;
use crate::pipeline::Pipeline;
use crate::tracer::{RaySample, Tracer};

/// State that the engine keeps from frame to frame.
#[derive(Clone, Debug)]
pub(crate) struct PickEngine {
    volume: Arc<GridVolume>,
    level: Level,
    operator: Operator,
    /// Length of a step in world units.
    step: f64,
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
            || caster.empty_space.is_named();
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
            peaks: sign.filter(|_| caster.empty_space != EmptySpace::None).map(peaks),
        })
    }
}

/// Engine with a view.
pub(crate) struct PickFrame<'a> {
    engine: &'a PickEngine,
    /// The plain engine, which shades surfaces.
    plain: Pipeline<'a, f32>,
    /// Direction of the view, a unit vector.
    forward: DVec3,
}

impl<'a> PickFrame<'a> {
    /// # Errors
    /// A view that makes no sense.
    pub(crate) fn new(engine: &'a PickEngine, plain: Pipeline<'a, f32>) -> Result<Self, ParameterError> {
        Ok(Self { engine, forward: plain.view.camera.frame()?.z_axis, plain })
    }
}

impl Tracer for PickFrame<'_> {
    fn trace(&self, spots: &[ImageSample], starts: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts) {
        let Self { engine, plain, .. } = self;
        let setup = plain.packet_setup(engine.step, self.forward);
        let rays = &PickRays { plain, setup, calibration: engine.volume.calibration() };
        // A mean has the mean colour of its ray, an extreme that of its place; a surface's gradient is the plain engine's.
        let colors = plain.scene.volume.colors().filter(|_| engine.operator == Operator::Average);
        if let Some(field) = FilteredField::new(&engine.volume, colors.map(|c| &**c), GradientMethod::default()) {
            let medium = &self.medium(field);
            vector::run(engine.level, PickTrace { rays, medium, spots, starts, values, counts });
            return;
        }
        with_voxels!(engine.volume, lattice => {
            let medium = &self.medium(vector::Field::new(&lattice));
            vector::run(engine.level, PickTrace { rays, medium, spots, starts, values, counts });
        });
    }
}

impl PickFrame<'_> {
    fn medium<T: PacketField>(&self, field: T) -> PickMedium<'_, T> {
        let engine = self.engine;
        PickMedium {
            field,
            vacuum: engine.volume.vacuum_cells(),
            dims: engine.volume.dims(),
            operator: engine.operator,
            offset: self.plain.offset as f32,
            peaks: engine.peaks.as_deref(),
            listed: None,
        }
    }
}
