//! Engine of packets through patches, as a tracer of rays.

use std::sync::Arc;

use fearless_simd::{Level, Simd};
use vr_core::amr::AmrGrid;
use vr_core::image_order::ImageSample;
use vr_core::{
    Calibration, Compositing, Counts, IndexRay, Layer, MaxRadiance, ParameterError, Rays, RectilinearGrid, Scene, View,
    Volume,
};
use vr_kernels::tables::{BakedTransfer, rounding_over, table_range};
use vr_kernels::vector::{self, LANES, Lanes, OpticsTable, PacketLights, PacketShading, Vectorized};

use super::axis_table::AxisTable;
use super::lanes::WorldRay;
use super::march::{LaneRay, PatchMedium, Patches, Work, march};
use super::mesh::{MeshBlock, MeshPatches, gradient_length};
use super::mesh_lattices::MeshLattices;
use super::mesh_paces::MeshPaces;
use super::rectilinear::RectilinearPatches;
use super::rectilinear_paces::RectilinearPaces;
use super::steps::StepBatches;
use crate::caster::{CompositingOrder, EmptySpace, Precision, RayCaster, Rule, TransferLookup};
use crate::leap::Visibility;
use crate::pace::{Lengths, Pace};
use crate::packet::level;
use crate::packet::shading::{row_tables, world_shading};
use crate::source::Source;
use crate::table_range::{MAX_ROUNDING, field_range};
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
    /// Amount at which a ray ends: no more than this could be added to any component.
    negligible: f64,
    /// Opacity at which rays are cut; 1 where they are not.
    cut: f64,
    max_radiance: MaxRadiance,
    shading: Option<PacketShading>,
}

/// Volume that is a regular lattice patch by patch.
#[derive(Clone, Debug)]
enum PatchVolume {
    Amr { grid: Arc<AmrGrid>, blocks: Arc<Vec<MeshBlock>>, lattices: Arc<MeshLattices>, paces: Arc<MeshPaces> },
    Rectilinear(Arc<RectilinearGrid>, Arc<[AxisTable; 3]>, Arc<RectilinearPaces>),
}

impl PatchVolume {
    fn new(volume: &Volume, pace: &Pace<f32>, has_gradients: bool) -> Option<Self> {
        match volume {
            Volume::Amr(grid) => {
                let blocks = grid.derived().get((), || MeshBlock::all_of(grid));
                let paces = Arc::new(MeshPaces::new(grid, pace));
                let lattices = grid.derived().get((), || MeshLattices::new(grid));
                lattices.make(grid, has_gradients, |block| paces.is_seen(grid, block));
                Some(Self::Amr { grid: Arc::clone(grid), blocks, lattices, paces })
            }
            Volume::Rectilinear(grid) => {
                let paces = Arc::new(RectilinearPaces::new(grid, pace));
                Some(Self::Rectilinear(Arc::clone(grid), RectilinearPatches::tables(grid), paces))
            }
            _ => None,
        }
    }

    /// Values per world unit that a gradient of 1 stands for, as the patches tell gradients.
    fn gradient_unit(&self) -> f64 {
        match self {
            Self::Amr { grid, .. } => 1.0 / gradient_length(grid),
            Self::Rectilinear(grid, ..) => {
                grid.lattice().calibration().slope.abs() / RectilinearPatches::gradient_length(grid)
            }
        }
    }
}

/// Range of a volume's numbers as packets read them, and their calibration; `None` for a volume that packets cannot read.
fn range_of(volume: &Volume) -> Option<((f64, f64), Calibration)> {
    match volume {
        Volume::Amr(grid) => Some((grid.value_range(), Calibration::default())),
        Volume::Rectilinear(grid) if RectilinearPatches::can_number(grid) => {
            Some((field_range(grid.lattice())?, grid.lattice().calibration()))
        }
        _ => None,
    }
}

impl PatchEngine {
    /// Returns the engine for a scene and a caster's settings; `None` where it cannot draw them, and the plain one must.
    pub(crate) fn new(caster: &RayCaster, scene: &Scene, source: &Source, lengths: Lengths) -> Option<Self> {
        let level = level::of(caster.vector)?;
        let CompositingOrder::FrontToBack { termination } = caster.order else { return None };
        // A cut sum is ended by its cut alone.
        let (cut, negligible) = match scene.compositing {
            Compositing::Over => (1.0, 1.0 - termination),
            Compositing::Accumulate { level } => (level, 0.0),
            _ => return None,
        };
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
            negligible,
            cut,
            max_radiance: scene.max_radiance(),
            shading,
        })
    }
}

/// Engine with a view.
pub(crate) struct PatchFrame<'a> {
    engine: &'a PatchEngine,
    source: &'a Source,
    rays: Rays,
    view: &'a View,
    layer: Option<&'a Layer>,
}

impl<'a> PatchFrame<'a> {
    /// # Errors
    /// A view that makes no sense.
    pub(crate) fn new(
        engine: &'a PatchEngine,
        source: &'a Source,
        (view, layer): (&'a View, Option<&'a Layer>),
    ) -> Result<Self, ParameterError> {
        Ok(Self { engine, source, rays: Rays::new(view)?, view, layer })
    }

    fn medium<P>(&self, patches: P) -> PatchMedium<'_, P> {
        PatchMedium {
            patches,
            optics: &self.engine.optics,
            shading: self.engine.shading.as_ref(),
            negligible: self.engine.negligible as f32,
            level: self.engine.cut as f32,
            unit: self.engine.unit,
        }
    }
}

impl Tracer for PatchFrame<'_> {
    fn trace(&self, spots: &[ImageSample], _: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts) {
        let engine = self.engine;
        match &engine.volume {
            PatchVolume::Amr { grid, blocks, lattices, paces } => {
                let patches = MeshPatches { grid, samples: grid.samples(), lattices, blocks, paces, unit: engine.unit };
                let medium = self.medium(patches);
                vector::run(engine.level, Trace { frame: self, medium: &medium, spots, values, counts });
            }
            PatchVolume::Rectilinear(grid, tables, paces) => {
                let medium = self.medium(RectilinearPatches::new(grid, tables, paces, engine.unit));
                vector::run(engine.level, Trace { frame: self, medium: &medium, spots, values, counts });
            }
        }
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

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { frame, medium, spots, values, counts } = self;
        let (mut lights, mut work) = (PacketLights::default(), Work::new(&medium.patches));
        let mut batches: [StepBatches; LANES] = std::array::from_fn(|_| StepBatches::default());
        for spots in spots.chunks(LANES) {
            let mut parts = [None; LANES];
            let mut directions = [[0.0; LANES]; 3];
            let mut max_light = Lanes::ZERO;
            let mut batches = batches.iter_mut();
            let mut lane_rays = std::array::from_fn(|lane| {
                let spot = &spots[lane.min(spots.len() - 1)];
                let (ray, part) = frame.cut(spot);
                (0..3).for_each(|a| directions[a][lane] = ray.direction[a]);
                let batches = batches.next()?;
                let part = part.filter(|_| lane < spots.len())?;
                parts[lane] = Some(part);
                max_light.0[lane] = frame.engine.max_radiance.over(part.length()) as f32;
                batches.begin([part.start, part.end]);
                let base = ray.origin + ray.direction * part.offset;
                let world = WorldRay { base, direction: ray.direction, start: part.start };
                Some(LaneRay { world, parts: medium.patches.parts(ray, part), batches })
            });
            let mut traced = [RaySample::NOTHING; LANES];
            let hits = parts.iter().flatten().count();
            if hits > 0 {
                if let Some(shading) = medium.shading {
                    lights.look_along(&shading.lights, &directions);
                }
                let marched = march(simd, medium, &mut lane_rays, &max_light, &lights, &mut work);
                counts.rays += hits as u64;
                counts.samples += u64::from(marched.samples);
                counts.terminated += u64::from(marched.terminated.count_ones());
                for (lane, part) in parts.iter().enumerate() {
                    let Some(part) = part else { continue };
                    traced[lane].rgba = std::array::from_fn(|c| marched.rgba[c].0[lane]);
                    let half = f64::from(marched.half.0[lane]) * medium.unit;
                    traced[lane].depth = (part.offset + part.start + half) as f32;
                }
            }
            if let Some(layer) = frame.layer {
                for (value, spot) in traced.iter_mut().zip(spots) {
                    *value = value.over(layer, spot.pixel);
                }
            }
            values.extend_from_slice(&traced[..spots.len()]);
        }
    }
}

impl PatchFrame<'_> {
    /// Returns the ray through a place of the image, and its part inside the volume.
    fn cut(&self, spot: &ImageSample) -> (vr_core::Ray, Option<IndexRay>) {
        let ray = self.rays.at(spot.x, spot.y);
        let far = self.layer.map_or(f64::INFINITY, |layer| layer.depth(spot.pixel));
        let part = IndexRay::new(&ray, self.source.placement(), self.source.dims(), &self.view.clip, far);
        (ray, part)
    }
}
