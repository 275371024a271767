//! Engine of packets that pick values of scattered points, as a tracer of rays.

use std::sync::Arc;

use fearless_simd::Level;
use glam::DVec3;
use vr_core::image_order::ImageSample;
use vr_core::{Calibration, Counts, ParameterError, PointMixing, PointSet, Scene, Volume};
use vr_kernels::vector::{self, Operator};

use super::cells::PointCells;
use super::engine::{can_number, listed_cells, resolves};
use super::field::PointField;
use super::mean_steps::MeanSteps;
use crate::caster::{Precision, RayCaster, Step};
use crate::packet::level;
use crate::packet::listed::ListedSteps;
use crate::packet::picks::{PickMedium, PickRays, PickTrace};
use crate::pipeline::Pipeline;
use crate::source::Source;
use crate::tracer::{RaySample, Tracer};

/// State that the engine keeps from frame to frame.
#[derive(Clone, Debug)]
pub(crate) struct PointPickEngine {
    points: Arc<PointSet>,
    cells: Arc<PointCells>,
    level: Level,
    operator: Operator,
    /// Length of a step in world units.
    step: f64,
}

impl PointPickEngine {
    /// Returns the engine for a scene and a caster's settings; `None` where it cannot draw them, and the plain one must.
    pub(crate) fn new(caster: &RayCaster, scene: &Scene, source: &Source) -> Option<Self> {
        let level = level::of(caster.vector)?;
        let Volume::Points(points) = &scene.volume else { return None };
        let operator = Operator::new(scene.compositing, Calibration::default(), false);
        let step = caster.world_step(source.placement());
        let is_drawn = operator.picks()
            && matches!(caster.step, Step::Uniform(_))
            && caster.precision == Precision::F32
            && can_number(points, step)
            && resolves(points, &scene.transfer);
        if !is_drawn {
            return None;
        }
        let cells = listed_cells(points, source.placement(), source.dims())?;
        Some(Self { points: Arc::clone(points), cells, level, operator, step })
    }
}

/// Engine with a view.
pub(crate) struct PointPickFrame<'a> {
    engine: &'a PointPickEngine,
    /// The plain engine, which shades surfaces.
    plain: Pipeline<'a, f64>,
    /// Direction of the view, a unit vector.
    forward: DVec3,
}

impl<'a> PointPickFrame<'a> {
    /// # Errors
    /// A view that makes no sense.
    pub(crate) fn new(engine: &'a PointPickEngine, plain: Pipeline<'a, f64>) -> Result<Self, ParameterError> {
        Ok(Self { engine, forward: plain.view.camera.frame()?.z_axis, plain })
    }
}

impl Tracer for PointPickFrame<'_> {
    fn trace(&self, spots: &[ImageSample], starts: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts) {
        let Self { engine, plain, .. } = self;
        let steps = MeanSteps {
            cells: &engine.cells,
            placement: plain.source.placement(),
            level: engine.level,
            step: engine.step,
        };
        let listed = ListedSteps { steps: &steps, unit: engine.step, offset: plain.offset };
        let medium = &PickMedium {
            field: PointField {
                // A mean has the mean colour of its ray, an extreme that of its place.
                has_colors: engine.operator == Operator::Average && engine.points.colors().is_some(),
                ..PointField::of_values(&engine.points, &engine.cells)
            },
            vacuum: None,
            dims: plain.source.dims(),
            operator: engine.operator,
            offset: plain.offset as f32,
            peaks: None,
            listed: (engine.points.mixing() == PointMixing::Mean).then_some(listed),
        };
        let setup = plain.packet_setup(engine.step, self.forward);
        let rays = &PickRays { plain, setup, calibration: Calibration::default() };
        vector::run(engine.level, PickTrace { rays, medium, spots, starts, values, counts });
    }
}
