//! Engine of packets that pick values of patches, as a tracer of rays.

use fearless_simd::{Level, Simd};
use vr_core::image_order::ImageSample;
use vr_core::{Calibration, Compositing, Counts, IndexRay, Scene};
use vr_kernels::tables::rounding_over;
use vr_kernels::vector::{self, LANES, Operator, Vectorized};

use super::march::{Patches, Work};
use super::pick_march::{PatchPicks, pick_march};
use super::rays::PatchRays;
use super::steps::StepBatches;
use super::volume::{PatchVolume, range_of, with_patches};
use crate::caster::{EmptySpace, Precision, RayCaster, Rule, Step};
use crate::chord::{Chord, Crossing};
use crate::leap::Visibility;
use crate::pace::{Lengths, Pace};
use crate::packet::level;
use crate::packet::picks::{PickLook, PickedNumber};
use crate::pipeline::Pipeline;
use crate::source::Source;
use crate::table_range::MAX_ROUNDING;
use crate::tracer::{RaySample, Tracer};

/// State that the engine keeps from frame to frame.
#[derive(Clone, Debug)]
pub(crate) struct PatchPickEngine {
    volume: PatchVolume,
    pub(crate) level: Level,
    operator: Operator,
    /// Calibration of the numbers that packets read.
    calibration: Calibration,
    /// Threshold of a first hit.
    threshold: Option<f64>,
    /// World length in which steps are counted.
    unit: f64,
}

impl PatchPickEngine {
    /// Returns the engine for a scene and a caster's settings; `None` where it cannot draw them, and the plain one must.
    pub(crate) fn new(caster: &RayCaster, scene: &Scene, source: &Source, lengths: Lengths) -> Option<Self> {
        let level = level::of(caster.vector)?;
        let (range, calibration) = range_of(&scene.volume)?;
        let operator = Operator::new(scene.compositing, calibration, false);
        let is_drawn = operator.picks()
            && matches!(caster.step, Step::Uniform(_))
            && matches!(caster.rule, Rule::Auto | Rule::Midpoint)
            && caster.precision == Precision::F32
            && rounding_over(range, calibration, false, &scene.transfer) <= MAX_ROUNDING;
        if !is_drawn {
            return None;
        }
        let threshold = match scene.compositing {
            Compositing::First { threshold } => Some(threshold),
            _ => None,
        };
        let threshold_seen = threshold.filter(|_| caster.empty_space != EmptySpace::None);
        let visibility = threshold_seen.map(|threshold| Visibility::of_threshold(threshold, calibration));
        let volume = PatchVolume::new(&scene.volume, &Pace { lengths, visibility }, false)?;
        Some(Self { volume, level, operator, calibration, threshold, unit: caster.world_step(source.placement()) })
    }
}

/// Engine with a view.
pub(crate) struct PatchPickFrame<'a> {
    engine: &'a PatchPickEngine,
    /// The plain engine, which shades surfaces.
    plain: Pipeline<'a, f64>,
}

impl<'a> PatchPickFrame<'a> {
    pub(crate) fn new(engine: &'a PatchPickEngine, plain: Pipeline<'a, f64>) -> Self {
        Self { engine, plain }
    }

    /// Number that a ray picked, in its part inside the volume.
    fn number(&self, picked: &PatchPicks, lane: usize, part: &IndexRay) -> PickedNumber {
        let (engine, begin) = (self.engine, part.offset + part.start);
        let (number, length) = (f64::from(picked.value.0[lane]), f64::from(picked.length.0[lane]));
        let number = if engine.operator == Operator::Average { number / length } else { number };
        let (value, at) = (engine.calibration.value(number), f64::from(picked.at.0[lane]) * engine.unit);
        // A threshold between two patches lies in either: the plain engine looks it up.
        if let (Some(threshold), Some(before)) = (engine.threshold, picked.before[lane]) {
            let chord = Chord { source: self.plain.source, colors: None, ray: *part };
            let found = Crossing { distance: part.start + at, stored: value };
            if before < found.distance {
                let found = chord.crossing(before, found, 1.0, threshold);
                return PickedNumber { value: found.stored, depth: found.distance + part.offset, color: None };
            }
        }
        PickedNumber { value, depth: begin + at, color: None }
    }
}

impl Tracer for PatchPickFrame<'_> {
    fn trace(&self, spots: &[ImageSample], _: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts) {
        let engine = self.engine;
        with_patches!(&engine.volume, engine.unit, patches => {
            vector::run(engine.level, Trace { frame: self, patches: &patches, spots, values, counts });
        });
    }
}

/// Arguments of [`Tracer::trace`], for the visit of the kind of patches.
struct Trace<'a, 'f, P> {
    frame: &'a PatchPickFrame<'f>,
    patches: &'a P,
    spots: &'a [ImageSample],
    values: &'a mut Vec<RaySample>,
    counts: &'a mut Counts,
}

impl<P: Patches> Vectorized for Trace<'_, '_, P> {
    type Output = ();
    const AVX2_ALONE: bool = cfg!(test);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { frame, patches, spots, values, counts } = self;
        let (operator, plain) = (frame.engine.operator, &frame.plain);
        let rays = PatchRays {
            rays: plain.rays.clone(),
            source: plain.source,
            view: plain.view,
            layer: plain.layer,
            // Ends of the ray are samples, too, where one may be picked.
            samples_ends: operator != Operator::Average,
        };
        let mut work = Work::new(patches);
        let mut look = PickLook::new(plain, operator);
        let mut batches: [StepBatches; LANES] = std::array::from_fn(|_| StepBatches::default());
        for spots in spots.chunks(LANES) {
            let (packet, mut lane_rays) = rays.packet(patches, spots, &mut batches);
            let mut traced = [RaySample::NOTHING; LANES];
            let hits = packet.parts.iter().flatten().count();
            if hits > 0 {
                let picked = pick_march(simd, patches, operator, &mut lane_rays, &mut work);
                counts.rays += hits as u64;
                counts.samples += u64::from(picked.samples);
                counts.terminated += u64::from(picked.terminated.count_ones());
                for (lane, part) in packet.parts.iter().enumerate() {
                    let Some(part) = part.as_ref().filter(|_| picked.length.0[lane] > 0.0) else { continue };
                    traced[lane] = look.sample(frame.number(&picked, lane, part), &spots[lane]);
                }
            }
            rays.add_layer(spots, &mut traced);
            values.extend_from_slice(&traced[..spots.len()]);
        }
    }
}
