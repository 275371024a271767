//! Engine of packets through grids with labels, as a tracer of rays.

use std::sync::Arc;

use fearless_simd::Level;
use glam::DVec3;
use vr_core::image_order::ImageSample;
use vr_core::labels::{LabelCode, LabelledGrid};
use vr_core::{Counts, Layer, MaxRadiance, ParameterError, Rays, Scene, View};
use vr_kernels::ranges::RangeBlocks;
use vr_kernels::tables::rounding_over;
use vr_kernels::vector::{self, PacketShading};

use super::bands::{Bands, calibration_of};
use super::field::LabelField;
use super::steps::LabelSteps;
use crate::caster::{EmptySpace, Precision, RayCaster, Rule, Step, TransferLookup};
use crate::leap::{EDGE, Visibility, VisibleBlocks};
use crate::packet::engine::fits;
use crate::packet::fields::FilteredField;
use crate::packet::level;
use crate::packet::listed::{ListedSteps, MAX_LISTED};
use crate::packet::march::{MarchSteps, Medium};
use crate::packet::ray_end::RayEnd;
use crate::packet::setup::FrameSetup;
use crate::packet::trace::{Trace, TraceFrame};
use crate::shade::Shader;
use crate::source::Source;
use crate::table_range::{MAX_ROUNDING, field_range};
use crate::tracer::{RaySample, Tracer};

/// Place of a step's sample, as a fraction of the step.
const OFFSET: f64 = 0.5;

/// State that the engine keeps from frame to frame.
#[derive(Clone, Debug)]
pub(crate) struct LabelEngine {
    pub(crate) level: Level,
    bands: Bands,
    /// Blocks of the grid in which something can be seen; `None` without leaping.
    visible: Option<VisibleBlocks>,
    /// Length of a step in world units.
    step: f64,
    end: RayEnd,
    max_radiance: MaxRadiance,
    shading: Option<PacketShading>,
}

impl LabelEngine {
    /// Returns the engine for a scene and a caster's settings; `None` where it cannot draw them, and the plain one must.
    pub(crate) fn new(caster: &RayCaster, scene: &Scene, source: &Source) -> Option<Self> {
        let level = level::of(caster.vector)?;
        let field = scene.volume.field()?.as_labelled_grid()?;
        let end = RayEnd::new(caster, scene)?;
        let is_drawn = matches!(caster.step, Step::Uniform(_))
            && matches!(caster.rule, Rule::Auto | Rule::Midpoint)
            && caster.transfer_lookup != TransferLookup::Exact
            && caster.precision == Precision::F32
            && !scene.transfer.has_rows();
        if !is_drawn {
            return None;
        }
        let (volume, step) = (field.volume(), caster.world_step(source.placement()));
        let (range, wide) = (field_range(volume)?, volume.filter().reach() > 0);
        let is_exact = rounding_over(range, volume.calibration(), wide, &scene.transfer) <= MAX_ROUNDING;
        let (low, high) = volume.bounds();
        let can_list = 2.0 * (high - low).length() / step < MAX_LISTED;
        if !fits(caster, volume) || !can_list || !is_exact || volume.vacuum_cells().is_some() {
            return None;
        }
        let bands = Bands::new(field, &scene.transfer, step)?;
        let leaps = caster.empty_space != EmptySpace::None;
        let shader = scene.gradient_shading().map(|shading| {
            Shader::<f32>::new(shading, scene.lights.clone(), volume.placement(), volume.calibration().slope)
        });
        Some(Self {
            level,
            visible: leaps.then(|| visible_blocks(field, scene, &bands)),
            bands,
            step,
            end,
            max_radiance: scene.max_radiance(),
            shading: shader
                .and_then(|shader| shader.for_packets(&scene.transfer, Arc::new([]), scene.reflection().is_some())),
        })
    }
}

/// Blocks in which something can be seen in any band of the grid's own values.
fn visible_blocks(field: &LabelledGrid, scene: &Scene, bands: &Bands) -> VisibleBlocks {
    let volume = field.volume();
    let ranges = RangeBlocks::of_volume(volume, EDGE);
    let of_band = |code: &LabelCode| {
        let visibility = Visibility::<f32>::of_light(&scene.transfer, calibration_of(field, *code), None, None);
        VisibleBlocks::new(volume.dims(), &ranges, &visibility)
    };
    let own_values = bands.codes.iter().filter(|code| matches!(code, LabelCode::Offset(_)));
    let all: Vec<VisibleBlocks> = own_values.map(of_band).collect();
    VisibleBlocks::from_fn(volume.dims(), EDGE, |block| all.iter().any(|blocks| blocks.at(block)))
}

/// Vector engine with a view.
pub(crate) struct LabelFrame<'a> {
    engine: &'a LabelEngine,
    field: LabelField<'a>,
    source: &'a Source,
    rays: Rays,
    view: &'a View,
    layer: Option<&'a Layer>,
    /// Direction of the view, a unit vector.
    forward: DVec3,
}

impl<'a> LabelFrame<'a> {
    /// # Errors
    /// A view that makes no sense.
    ///
    /// # Panics
    /// Panics at a scene that the engine was not made for: a bug in the caller.
    pub(crate) fn new(
        engine: &'a LabelEngine,
        (scene, source): (&'a Scene, &'a Source),
        (view, layer): (&'a View, Option<&'a Layer>),
    ) -> Result<Self, ParameterError> {
        let labelled = scene.volume.field().and_then(|field| field.as_labelled_grid()).expect("a grid with labels");
        let grid = FilteredField::of_grid(labelled.volume(), labelled.gradient_method());
        let field = LabelField { grid: grid.expect("packets can sample it"), labelled, bands: &engine.bands };
        let forward = view.camera.frame()?.z_axis;
        Ok(Self { engine, field, source, rays: Rays::new(view)?, view, layer, forward })
    }
}

impl Tracer for LabelFrame<'_> {
    fn trace(&self, spots: &[ImageSample], starts: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts) {
        let (engine, labelled) = (self.engine, self.field.labelled);
        let volume = labelled.volume();
        let steps = LabelSteps {
            field: labelled,
            bands: &engine.bands,
            visible: engine.visible.as_ref(),
            lattice: (self.source.placement(), self.source.dims()),
            clip: &self.view.clip,
            step: engine.step,
        };
        let medium = Medium {
            field: self.field,
            vacuum: None,
            dims: volume.dims(),
            steps: MarchSteps::Listed(ListedSteps { steps: &steps, unit: engine.step, offset: OFFSET }),
            optics: &engine.bands.optics,
            shading: engine.shading.as_ref(),
            follows_normals: false,
            negligible: engine.end.negligible as f32,
            level: engine.end.cut as f32,
        };
        let frame = TraceFrame {
            setup: FrameSetup {
                rays: &self.rays,
                placement: volume.placement(),
                dims: volume.dims(),
                clip: &self.view.clip,
                layer: self.layer,
                step: engine.step,
                offset: OFFSET,
                forward: self.forward,
            },
            near: None,
            max_radiance: &engine.max_radiance,
        };
        vector::run(engine.level, Trace { frame: &frame, medium: &medium, spots, starts, values, counts });
    }
}
