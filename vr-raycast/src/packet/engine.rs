//! Vector engine, as a tracer of rays.

use std::sync::Arc;

use fearless_simd::Level;
use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::image_order::ImageSample;
use vr_core::{
    ColorGrid, Counts, Filter, GradientMethod, GridVolume, Layer, MaxRadiance, ParameterError, Rays, Scene, View,
};
use vr_kernels::ranges::{BlockRange, LevelRanges, RangeBlocks};
use vr_kernels::tables::BakedTransfer;
use vr_kernels::vector::{self, Field, OpticsTable, PacketShading, Rows, SegmentTable};

use super::course::Course;
use super::fields::{FilteredField, PacketField, can_sample};
use super::level;
use super::local::{LocalSteps, by_byte};
use super::march::{LatticeSteps, MarchSteps, Medium};
#[cfg(feature = "classics")]
use super::nodes::NodeSteps;
use super::ray_end::RayEnd;
use super::segments::{SegmentLengths, SegmentSteps};
use super::setup::FrameSetup;
use super::shading::row_tables;
use super::trace::{Trace, TraceFrame};
use crate::caster::{EmptySpace, RayCaster, Rule, Step, TransferLookup, Traversal};
#[cfg(feature = "classics")]
use crate::classics::Homogeneity;
use crate::leap::{ClearSpace, Visibility, VisibleBlocks};
use crate::near_depths::NearDepths;
use crate::render_tables::RenderTables;
use crate::rule::Shape;
use crate::silhouette::Hull;
use crate::step_map::StepMap;
use crate::table_range::baked;
use crate::tracer::{RaySample, Tracer};

/// State that the vector engine keeps from frame to frame.
#[derive(Clone, Debug)]
pub(crate) struct PacketEngine {
    pub(crate) volume: Arc<GridVolume>,
    pub(crate) level: Level,
    pub(crate) lengths: PacketLengths,
    pub(crate) light: StepLight,
    /// Hull of the visible blocks; `None` without leaping.
    pub(crate) hull: Option<Hull>,
    /// Table for steps of any length, in units of `step`.
    optics: OpticsTable,
    /// Length of a step in world units; with steps that follow the data, the unit of their lengths.
    pub(super) step: f64,
    /// Place of a step's sample, as a fraction of the step.
    offset: f64,
    /// True if normals are followed over a step: its middle stands for it.
    follows_normals: bool,
    end: RayEnd,
    max_radiance: MaxRadiance,
    shading: Option<PacketShading>,
    /// Source of the gradients.
    gradient: GradientMethod,
    /// Colours of the voxels, where they have any.
    colors: Option<Arc<ColorGrid>>,
}

/// Lengths of the steps of the packets' rays.
#[derive(Clone, Debug)]
pub(crate) enum PacketLengths {
    /// One length. With the space that is leaped over, if there is any.
    Lattice(Option<Arc<ClearSpace>>),
    /// The length that each place asks for.
    Local {
        map: Arc<StepMap>,
        /// Step by the byte of the map; see [`by_byte`].
        by_byte: Box<[f32; 256]>,
    },
    /// Nodes of an octree, each crossed in one step where the medium hardly changes in it, and short steps elsewhere.
    #[cfg(feature = "classics")]
    Nodes {
        map: Arc<Homogeneity>,
        /// Edge of a node by the byte of the map.
        edges: Box<[f32; 256]>,
        /// Length of a short step, in smallest voxel edges.
        step: f32,
    },
}

/// Source of the light of a step.
#[derive(Clone, Debug)]
pub(crate) enum StepLight {
    /// One sample, and a table for whole steps.
    Sample(Arc<BakedTransfer<f32>>),
    /// All values of a step, by a table of antiderivatives.
    Course {
        table: SegmentTable,
        /// True if the value is a parabola, and not a line.
        is_parabola: bool,
    },
}

impl PacketLengths {
    /// Returns the blocks in which something may be visible.
    fn visible(&self, dims: [usize; 3]) -> VisibleBlocks {
        match self {
            Self::Lattice(Some(clear)) => clear.visible_blocks(dims),
            Self::Lattice(None) => VisibleBlocks::from_fn(dims, 2 * EDGE, |_| true),
            Self::Local { map, .. } => map.visible(dims),
            #[cfg(feature = "classics")]
            Self::Nodes { map, .. } => map.visible(dims),
        }
    }

    /// Returns the space that steps of one length leap over.
    fn clear(&self) -> Option<&ClearSpace> {
        if let Self::Lattice(clear) = self { clear.as_deref() } else { None }
    }

    /// Returns the steps that follow the data as packets take them, where `unit` is the world length of the smallest voxel edge; `None` if all have one length.
    fn local_steps(&self, unit: f64) -> Option<LocalSteps<'_>> {
        match self {
            Self::Lattice(_) => None,
            Self::Local { map, by_byte } => Some(LocalSteps::new(map, by_byte, unit)),
            #[cfg(feature = "classics")]
            Self::Nodes { map, edges, step } => Some(LocalSteps::of_nodes(NodeSteps { map, step: *step }, edges)),
        }
    }
}

/// Largest number of steps of a ray: f32 counts them one by one, with room to spare.
pub(super) const MAX_STEPS: f64 = (1 << 22) as f64;

/// Cells along the edge of a block that is leaped over. With 8, opaque scenes took 1.2 times as long (mni, step 1: 18.8 and 15.5 ms).
pub(crate) const EDGE: usize = LevelRanges::EDGE;

impl PacketEngine {
    /// Returns the vector engine for a scene and a caster's settings; `None` where it cannot draw them, and the plain one must.
    pub(crate) fn new(
        caster: &RayCaster,
        scene: &Scene,
        volume: &Arc<GridVolume>,
        tables: &RenderTables<f32>,
    ) -> Option<Self> {
        let level = level::of(caster.vector)?;
        // Refuse what the kernels are not made for.
        let end = RayEnd::new(caster, scene)?;
        let common = caster.traversal == Traversal::Samples && caster.transfer_lookup != TransferLookup::Exact;
        // The structures that leap along whole rays are the plain engine's.
        if caster.empty_space.is_named() {
            return None;
        }
        let is_uniform = matches!(caster.step, Step::Uniform(_));
        let voxel = volume.placement().spacing().min_element();
        let step = if is_uniform { caster.world_step(volume.placement()) } else { voxel };
        if !common || !fits(caster, volume) {
            return None;
        }
        let offset = match caster.rule {
            Rule::Auto | Rule::Midpoint => 0.5,
            // Samples lie at the begin of a step, and some further on.
            Rule::Left | Rule::Linear | Rule::Quadratic => 0.0,
            Rule::Exact => return None,
        };
        let gradient = scene.shading.as_ref().map(|shading| shading.gradient).unwrap_or_default();
        // A field that is constant around each voxel has no gradient of its own: nothing reflects.
        let is_flat = volume.filter() == Filter::Nearest && gradient == GradientMethod::Analytic;
        let reflects = scene.reflection().is_some() && !is_flat;
        let leaps = caster.empty_space != EmptySpace::None;
        // Choose what a step's light is looked up in, and the lengths of the steps.
        let profile = tables.classifier.profile.as_ref();
        let course = profile.filter(|profile| profile.shape != Shape::Point);
        let integrated = match course {
            Some(course) => Some(course.table.as_ref()?),
            None => None,
        };
        let table = match &tables.classifier.table {
            Some((table, _)) if is_uniform => Arc::clone(table),
            _ => Arc::new(baked(scene, volume, step)?),
        };
        let rows = row_tables(scene, &table, volume.calibration(), step)?;
        let shading = tables.shader.as_ref().and_then(|s| s.for_packets(&scene.transfer, rows, reflects));
        let lengths = match (caster.step, &tables.step_map) {
            (Step::Uniform(_), _) => {
                let baked = integrated.is_none().then_some(&table);
                let visibility = || Visibility::of_light(&scene.transfer, volume.calibration(), baked, integrated);
                PacketLengths::Lattice(
                    leaps.then(|| Self::clear_space(volume, &visibility(), EDGE)).flatten().map(Arc::new),
                )
            }
            // Local steps by the rule left are the plain engine's.
            (Step::Local { .. }, Some(map)) if caster.rule != Rule::Left => {
                PacketLengths::Local { map: Arc::clone(map), by_byte: Box::new(by_byte(map, step)) }
            }
            #[cfg(feature = "classics")]
            (Step::Homogeneous { step: short, .. } | Step::Variance { step: short, .. }, _) => {
                let map = Arc::clone(tables.homogeneity.as_ref()?);
                PacketLengths::Nodes { map, edges: Box::new(Homogeneity::edges()), step: short as f32 }
            }
            _ => return None,
        };
        let light = match integrated {
            Some(table) => {
                StepLight::Course { table: SegmentTable::new(table), is_parabola: caster.rule == Rule::Quadratic }
            }
            None => StepLight::Sample(Arc::clone(&table)),
        };
        let hull = leaps.then(|| Hull::new(volume.dims(), lengths.visible(volume.dims())));
        Some(Self {
            volume: Arc::clone(volume),
            level,
            lengths,
            light,
            hull,
            optics: OpticsTable::new(&table, &scene.transfer, volume.calibration(), step),
            step,
            offset,
            follows_normals: caster.rule != Rule::Left,
            end,
            max_radiance: scene.max_radiance(),
            shading,
            gradient,
            colors: scene.volume.colors().cloned(),
        })
    }

    /// Returns the engine that draws the same scene in steps of one length, in smallest voxel edges, with one sample each; `None` where no table serves
    /// such steps. `clear` is the space that they leap over.
    pub(crate) fn in_even_steps(&self, scene: &Scene, clear: Option<Arc<ClearSpace>>, voxels: f64) -> Option<Self> {
        let volume = &self.volume;
        let step = voxels * volume.placement().spacing().min_element();
        let table = baked(scene, volume, step)?;
        Some(Self {
            lengths: PacketLengths::Lattice(clear),
            optics: OpticsTable::new(&table, &scene.transfer, volume.calibration(), step),
            light: StepLight::Sample(Arc::new(table)),
            step,
            offset: 0.5,
            ..self.clone()
        })
    }

    /// Finds the clear space of a volume in blocks of `edge`³ cells, a power of two; `None` where there is none.
    pub(crate) fn clear_space(volume: &GridVolume, visibility: &Visibility<f32>, edge: usize) -> Option<ClearSpace> {
        let space = if edge == EDGE && ClearSpace::knows_cells(volume) {
            let range = |from: f64, to: f64| BlockRange::of_trilinear([from as f32, to as f32]);
            ClearSpace::of_cells(volume, |from, to| visibility.shows_block(&range(from, to)))
        } else {
            let ranges = RangeBlocks::of_volume(volume, edge);
            ClearSpace::of_blocks(edge, ranges.blocks(), |block| !visibility.shows_block(&ranges.ranges()[block]))
        };
        space.has_any().then_some(space)
    }
}

/// Runs code for the voxels of a volume, missing ones filled in, whatever type they have.
macro_rules! with_voxels {
    ($volume:expr, $lattice:ident => $body:expr) => {
        match $volume.filled_floats().filter(|_| $volume.vacuum_cells().is_some()) {
            Some(samples) => {
                let $lattice = Lattice { samples, dims: $volume.dims() };
                $body
            }
            None => vr_core::with_grid!($volume.values(), grid => {
                let $lattice = Lattice { samples: grid.samples(), dims: grid.dims() };
                $body
            }),
        }
    };
}
pub(super) use with_voxels;

/// True if lanes can number a volume's voxels and a caster's steps in it, and there is something in it.
pub(super) fn fits(caster: &RayCaster, volume: &GridVolume) -> bool {
    let corners = volume.corners();
    let extent = corners.iter().map(|c| c.distance(corners[0])).fold(0.0, f64::max);
    let counted = 2.0 * extent / caster.world_step(volume.placement()) < MAX_STEPS;
    let offsets_fit = volume.dims().iter().product::<usize>() <= i32::MAX as usize;
    can_sample(volume) && counted && offsets_fit && volume.value_stats().range.is_some()
}

/// Vector engine with a view.
pub(crate) struct PacketFrame<'a> {
    engine: &'a PacketEngine,
    volume: &'a GridVolume,
    rays: Rays,
    view: &'a View,
    layer: Option<&'a Layer>,
    /// Depths before which nothing can be seen; `None` if they are not known.
    near: Option<NearDepths>,
    /// Direction of the view, a unit vector.
    forward: DVec3,
}

impl<'a> PacketFrame<'a> {
    /// # Errors
    /// A view that makes no sense.
    pub(crate) fn new(
        engine: &'a PacketEngine,
        volume: &'a GridVolume,
        (view, layer): (&'a View, Option<&'a Layer>),
    ) -> Result<Self, ParameterError> {
        let rays = Rays::new(view)?;
        let near = engine.hull.as_ref().map(|hull| hull.near_depths(view, volume.placement())).transpose()?;
        Ok(Self { engine, volume, rays, view, layer, near, forward: view.camera.frame()?.z_axis })
    }
}

impl Tracer for PacketFrame<'_> {
    fn trace(&self, spots: &[ImageSample], starts: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts) {
        let engine = self.engine;
        let frame = TraceFrame { setup: self.setup(), near: self.near.as_ref(), max_radiance: &engine.max_radiance };
        if let Some(field) = FilteredField::new(self.volume, engine.colors.as_deref(), engine.gradient) {
            let medium = self.medium(field);
            vector::run(engine.level, Trace { frame: &frame, medium: &medium, spots, starts, values, counts });
            return;
        }
        with_voxels!(self.volume, lattice => {
            let medium = self.medium(Field::new(&lattice));
            vector::run(engine.level, Trace { frame: &frame, medium: &medium, spots, starts, values, counts });
        });
    }

    fn is_clear(&self, low: [u32; 2], high: [u32; 2]) -> bool {
        // A layer shows where the volume does not.
        self.layer.is_none() && self.near.as_ref().is_some_and(|near| near.is_clear(low, high))
    }
}

impl PacketFrame<'_> {
    fn medium<T: PacketField>(&self, field: T) -> Medium<'_, T> {
        let engine = self.engine;
        Medium {
            field,
            vacuum: self.volume.vacuum_cells(),
            dims: self.volume.dims(),
            steps: match (&engine.light, engine.lengths.local_steps(engine.step)) {
                (StepLight::Sample(table), None) => {
                    MarchSteps::Lattice(LatticeSteps { rows: Rows::new(table), clear: engine.lengths.clear() })
                }
                (StepLight::Sample(_), Some(steps)) => MarchSteps::Local(steps),
                (StepLight::Course { table, is_parabola }, steps) => {
                    let (is_parabola, unit) = (*is_parabola, engine.step as f32);
                    // No sample is missing where steps end at the faces of holes.
                    let has_holes = steps.is_none() && self.volume.vacuum_cells().is_some();
                    let lengths =
                        steps.map_or_else(|| SegmentLengths::Lattice(engine.lengths.clear()), SegmentLengths::Local);
                    MarchSteps::Segments(SegmentSteps {
                        course: Course { table, is_parabola, has_holes, unit },
                        lengths,
                    })
                }
            },
            optics: &engine.optics,
            shading: engine.shading.as_ref(),
            follows_normals: engine.follows_normals,
            negligible: engine.end.negligible as f32,
            level: engine.end.cut as f32,
        }
    }

    fn setup(&self) -> FrameSetup<'_> {
        FrameSetup {
            rays: &self.rays,
            placement: self.volume.placement(),
            dims: self.volume.dims(),
            clip: &self.view.clip,
            layer: self.layer,
            step: self.engine.step,
            offset: match &self.engine.lengths {
                PacketLengths::Lattice(_) => self.engine.offset,
                // Positions are those of any distance, not of samples.
                _ => 0.0,
            },
            forward: self.forward,
        }
    }
}

#[cfg(test)]
mod tests;
