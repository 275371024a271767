//! Engine of packets through scattered points, as a tracer of rays.

use std::sync::Arc;

use fearless_simd::Level;
use glam::DVec3;
use vr_core::image_order::ImageSample;
use vr_core::{
    Calibration, Counts, Layer, MaxRadiance, ParameterError, Placement, PointMixing, PointSet, Rays, Scene,
    TransferFunction, View, Volume,
};
use vr_kernels::tables::{BakedTransfer, rounding_over, table_range};
use vr_kernels::vector::{self, OpticsTable, PacketShading, Rows};

use super::cells::PointCells;
use super::even_ramps::EvenRamps;
use super::field::PointField;
use super::mean_steps::MeanSteps;
use crate::caster::{Precision, RayCaster, Rule, Step, TransferLookup};
use crate::packet::engine::MAX_STEPS;
use crate::packet::level;
use crate::packet::listed::{ListedSteps, MAX_LISTED};
use crate::packet::march::{LatticeSteps, MarchSteps, Medium};
use crate::packet::ray_end::RayEnd;
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
    /// Places that tables are over; `None` if they are over values.
    ramps: Option<Arc<EvenRamps>>,
    /// Length of a step in world units.
    step: f64,
    /// Place of a step's sample, as a fraction of the step.
    offset: f64,
    end: RayEnd,
    max_radiance: MaxRadiance,
    shading: Option<PacketShading>,
}

impl PointEngine {
    /// Returns the engine for a scene and a caster's settings; `None` where it cannot draw them, and the plain one must.
    pub(crate) fn new(caster: &RayCaster, scene: &Scene, source: &Source) -> Option<Self> {
        let level = level::of(caster.vector)?;
        let Volume::Points(points) = &scene.volume else { return None };
        let end = RayEnd::new(caster, scene)?;
        let is_drawn = matches!(caster.step, Step::Uniform(_))
            && caster.transfer_lookup != TransferLookup::Exact
            && caster.precision == Precision::F32;
        if !is_drawn {
            return None;
        }
        let (placement, dims) = (*source.placement(), source.dims());
        let step = caster.world_step(&placement);
        if !can_number(points, step) || !resolves(points, &scene.transfer) {
            return None;
        }
        let (largest, calibration) = (largest_value(points), Calibration::default());
        // Where a table over values does not resolve the transfer function, one over places does.
        let table_of = |transfer: &TransferFunction| table_of(transfer, largest, step);
        let (table, ramps) = match table_of(&scene.transfer) {
            Some(table) => (table, None),
            None => {
                let (ramps, transfer) = EvenRamps::of(&scene.transfer)?;
                (table_of(&transfer)?, Some((Arc::new(ramps), transfer)))
            }
        };
        let cells = listed_cells(points, &placement, dims)?;
        let transfer = ramps.as_ref().map_or(&*scene.transfer, |(_, transfer)| transfer);
        let shading = world_shading(scene, row_tables(scene, &table, calibration, step)?, 1.0);
        Some(Self {
            points: Arc::clone(points),
            cells,
            placement,
            dims,
            level,
            optics: OpticsTable::new(&table, transfer, calibration, step),
            table,
            ramps: ramps.map(|(ramps, _)| ramps),
            step,
            offset: if caster.rule == Rule::Left { 0.0 } else { 0.5 },
            end,
            max_radiance: scene.max_radiance(),
            shading,
        })
    }
}

/// True if f32 numbers the steps of a length through a set of points.
pub(super) fn can_number(points: &PointSet, step: f64) -> bool {
    let (low, high) = points.bounds();
    let max_steps = if points.mixing() == PointMixing::Mean { MAX_LISTED } else { MAX_STEPS };
    2.0 * (high - low).length() / step < max_steps
}

/// True if values of a set in f32 are exact enough for a transfer function.
pub(super) fn resolves(points: &PointSet, transfer: &TransferFunction) -> bool {
    let largest = largest_value(points);
    rounding_over((-largest, largest), Calibration::default(), false, transfer) <= MAX_ROUNDING
}

/// Lists of the points of a set in the cells of a lattice, kept with it; `None` if they take too much memory.
pub(super) fn listed_cells(points: &PointSet, placement: &Placement, dims: [usize; 3]) -> Option<Arc<PointCells>> {
    let cells = points.derived().get((), || PointCells::new(points, placement, dims).map(Arc::new));
    cells.as_ref().clone()
}

/// Largest size of a value of a set, but for what a sum may be larger than at points' own places: it is known to some roundings of that.
fn largest_value(points: &PointSet) -> f64 {
    match points.mixing() {
        PointMixing::Sum => points.value_range().0.abs().max(points.value_range().1.abs()),
        PointMixing::Mean => points.values().iter().map(|&value| f64::from(value).abs()).fold(0.0, f64::max),
    }
}

/// Makes the table of a transfer function for steps of a length, over all values, whose largest is about so large: beyond its points, it is constant. `None` if
/// its entries do not resolve it.
fn table_of(transfer: &TransferFunction, largest: f64, step: f64) -> Option<Arc<BakedTransfer<f32>>> {
    let (points, calibration) = (transfer.points(), Calibration::default());
    let (first, last) = (points[0].value, points[points.len() - 1].value);
    let margin = (last - first).max(largest);
    let places = table_range((first - margin, last + margin), false, calibration, transfer);
    let table = BakedTransfer::<f32>::new(transfer, calibration, places, false, step);
    table.resolves().then(|| Arc::new(table))
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
        let steps =
            MeanSteps { cells: &engine.cells, placement: &engine.placement, level: engine.level, step: engine.step };
        let medium = Medium {
            field: PointField {
                has_colors: engine.points.colors().is_some(),
                ramps: engine.ramps.as_deref(),
                ..PointField::of_values(&engine.points, &engine.cells)
            },
            vacuum: None,
            dims: engine.dims,
            steps: match engine.points.mixing() {
                PointMixing::Sum => MarchSteps::Lattice(LatticeSteps { rows: Rows::new(&engine.table), clear: None }),
                PointMixing::Mean => {
                    MarchSteps::Listed(ListedSteps { steps: &steps, unit: engine.step, offset: engine.offset })
                }
            },
            optics: &engine.optics,
            shading: engine.shading.as_ref(),
            follows_normals: false,
            negligible: engine.end.negligible as f32,
            level: engine.end.cut as f32,
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
