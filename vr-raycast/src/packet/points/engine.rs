//! Engine of packets through scattered points, as a tracer of rays.

use std::sync::Arc;

use fearless_simd::Level;
use glam::DVec3;
use vr_core::image_order::ImageSample;
use vr_core::{
    Calibration, Compositing, Counts, Layer, MaxRadiance, ParameterError, Placement, PointMixing, PointSet, Rays,
    Scene, View, Volume,
};
use vr_kernels::tables::{BakedTransfer, rounding_over, table_range};
use vr_kernels::vector::{self, OpticsTable, PacketShading, Rows};

use super::cells::PointCells;
use super::field::PointField;
use crate::caster::{CompositingOrder, Precision, RayCaster, Rule, Step, TransferLookup};
use crate::packet::engine::MAX_STEPS;
use crate::packet::level;
use crate::packet::march::{LatticeSteps, MarchSteps, Medium};
use crate::packet::setup::FrameSetup;
use crate::packet::shading::{row_tables, world_shading};
use crate::packet::trace::{Trace, TraceFrame};
use crate::source::Source;
use crate::table_range::MAX_ROUNDING;
use crate::tracer::{RaySample, Tracer};

/// State that the engine keeps from frame to frame.
#[derive(Clone, Debug)]
pub(crate) struct PointEngine {
    points: Arc<PointSet>,
    cells: Arc<PointCells>,
    placement: Placement,
    dims: [usize; 3],
    pub(crate) level: Level,
    /// Table for whole steps.
    table: Arc<BakedTransfer<f32>>,
    /// Table for steps of any length, in units of `step`.
    optics: OpticsTable,
    /// Length of a step in world units.
    step: f64,
    /// Place of a step's sample, as a fraction of the step.
    offset: f64,
    /// Amount at which a ray ends: no more than this could be added to any component.
    negligible: f64,
    /// Opacity at which rays are cut; 1 where they are not.
    cut: f64,
    max_radiance: MaxRadiance,
    shading: Option<PacketShading>,
}

impl PointEngine {
    /// Returns the engine for a scene and a caster's settings; `None` where it cannot draw them, and the plain one must.
    pub(crate) fn new(caster: &RayCaster, scene: &Scene, source: &Source) -> Option<Self> {
        let level = level::of(caster.vector)?;
        let Volume::Points(points) = &scene.volume else { return None };
        // Means, and colours of places, are the plain engine's.
        if points.mixing() == PointMixing::Mean || points.colors().is_some() {
            return None;
        }
        let CompositingOrder::FrontToBack { termination } = caster.order else { return None };
        // A cut sum is ended by its cut alone.
        let (cut, negligible) = match scene.compositing {
            Compositing::Over => (1.0, 1.0 - termination),
            Compositing::Accumulate { level } => (level, 0.0),
            _ => return None,
        };
        let is_drawn = matches!(caster.step, Step::Uniform(_))
            && caster.transfer_lookup != TransferLookup::Exact
            && caster.precision == Precision::F32;
        if !is_drawn {
            return None;
        }
        let (placement, dims) = (*source.placement(), source.dims());
        let step = caster.world_step(&placement);
        let (low, high) = points.bounds();
        if 2.0 * (high - low).length() / step >= MAX_STEPS {
            return None;
        }
        // The sum is known to some roundings of its largest value. Beyond its points, a transfer function is constant.
        let largest = points.value_range().0.abs().max(points.value_range().1.abs());
        let calibration = Calibration::default();
        if rounding_over((-largest, largest), calibration, false, &scene.transfer) > MAX_ROUNDING {
            return None;
        }
        let ends = scene.transfer.points();
        let (first, last) = (ends[0].value, ends[ends.len() - 1].value);
        let margin = (last - first).max(largest);
        let places = table_range((first - margin, last + margin), false, calibration, &scene.transfer);
        let table = Arc::new(BakedTransfer::<f32>::new(&scene.transfer, calibration, places, false, step));
        if !table.resolves() {
            return None;
        }
        let cells = points.derived().get((), || PointCells::new(points, &placement, dims).map(Arc::new));
        let cells = cells.as_ref().clone()?;
        let shading = world_shading(scene, row_tables(scene, &table, calibration, step)?, 1.0);
        Some(Self {
            points: Arc::clone(points),
            cells,
            placement,
            dims,
            level,
            optics: OpticsTable::new(&table, &scene.transfer, calibration, step),
            table,
            step,
            offset: if caster.rule == Rule::Left { 0.0 } else { 0.5 },
            negligible,
            cut,
            max_radiance: scene.max_radiance(),
            shading,
        })
    }
}

/// Vector engine with a view.
pub(crate) struct PointFrame<'a> {
    engine: &'a PointEngine,
    rays: Rays,
    view: &'a View,
    layer: Option<&'a Layer>,
    /// Direction of the view, a unit vector.
    forward: DVec3,
}

impl<'a> PointFrame<'a> {
    /// # Errors
    /// A view that makes no sense.
    pub(crate) fn new(
        engine: &'a PointEngine,
        (view, layer): (&'a View, Option<&'a Layer>),
    ) -> Result<Self, ParameterError> {
        Ok(Self { engine, rays: Rays::new(view)?, view, layer, forward: view.camera.frame()?.z_axis })
    }
}

impl Tracer for PointFrame<'_> {
    fn trace(&self, spots: &[ImageSample], starts: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts) {
        let engine = self.engine;
        let kernel = engine.points.kernel();
        // W(t) over the same without its factor, at a place where neither is small.
        let factor =
            kernel.at(0.0) / if kernel == vr_core::PointKernel::Gaussian { 1.0 - libm::exp(-4.5) } else { 1.0 };
        let medium = Medium {
            field: PointField { cells: &engine.cells, kernel, factor: factor as f32 },
            vacuum: None,
            dims: engine.dims,
            steps: MarchSteps::Lattice(LatticeSteps { rows: Rows::new(&engine.table), distances: None }),
            optics: &engine.optics,
            shading: engine.shading.as_ref(),
            follows_normals: false,
            negligible: engine.negligible as f32,
            level: engine.cut as f32,
        };
        let frame = TraceFrame {
            setup: FrameSetup {
                rays: &self.rays,
                placement: &engine.placement,
                dims: engine.dims,
                clip: &self.view.clip,
                layer: self.layer,
                step: engine.step,
                offset: engine.offset,
                forward: self.forward,
            },
            near: None,
            max_radiance: &engine.max_radiance,
        };
        vector::run(engine.level, Trace { frame: &frame, medium: &medium, spots, starts, values, counts });
    }
}
