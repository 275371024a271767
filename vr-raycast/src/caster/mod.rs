//! Settings of the ray caster: each in a file of its own, and here the questions that need several of them.

mod compositing_order;
mod empty_space;
mod image_sampling;
mod kernel;
mod quality;
mod rule;
mod step;
mod traversal;

use vr_core::{Filter, Placement, Scene, Volume};

use crate::pace::cells_of_parts;
use crate::render_tables::sharp_values;

pub use compositing_order::CompositingOrder;
pub use empty_space::EmptySpace;
pub use image_sampling::ImageSampling;
pub use kernel::{Precision, TransferLookup, Vector};
pub use quality::Quality;
pub use rule::Rule;
pub use step::Step;
pub use traversal::Traversal;

/// Casts rays through the pixels of a view and samples the volume along them; the crate's front page says how.
///
/// ```
/// use vr_raycast::{CompositingOrder, RayCaster, Step};
/// let fine = RayCaster { step: Step::Uniform(0.25), ..RayCaster::default() };
/// let backwards = RayCaster { order: CompositingOrder::BackToFront, ..fine };
/// # assert_eq!(backwards.step, Step::Uniform(0.25));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RayCaster {
    /// Length of the steps.
    pub step: Step,
    /// Error that automatic steps aim at.
    pub quality: Quality,
    /// Kind of the steps of a ray.
    pub traversal: Traversal,
    /// Structure by which rays leap over empty space.
    pub empty_space: EmptySpace,
    /// Rule that integrates the light of a step; it sets the order of convergence.
    pub rule: Rule,
    /// Direction in which the samples of a ray are composited.
    pub order: CompositingOrder,
    /// Reconstruction filter; `None` for the scene's.
    pub filter: Option<Filter>,
    /// Way in which the transfer function is evaluated.
    pub transfer_lookup: TransferLookup,
    /// Precision of the kernels.
    pub precision: Precision,
    /// Choice of the rays that the picture is made of.
    pub image_sampling: ImageSampling,
    /// Instructions for packets of sixteen rays, where a scene allows such packets.
    pub vector: Vector,
}

impl RayCaster {
    /// Name in scene files and on command lines.
    pub const NAME: &'static str = "raycast";
    /// Length of the longest step that is taken, in voxels.
    pub const LONGEST_STEP: f64 = 64.0;

    /// Returns the default caster with steps of one length: a fraction of the smallest voxel edge.
    pub fn uniform(step: f64) -> Self {
        Self { step: Step::Uniform(step), ..Self::default() }
    }

    /// Returns the caster without errors but those of its step: exact classification in f64 along whole rays.
    pub fn exact(step: f64) -> Self {
        Self {
            step: Step::Uniform(step),
            order: CompositingOrder::WHOLE_RAY,
            transfer_lookup: TransferLookup::Exact,
            precision: Precision::F64,
            ..Self::default()
        }
    }

    /// Returns the scene under the filter that this caster samples it with.
    pub(crate) fn scene_of(&self, scene: &Scene) -> Scene {
        self.filter.map_or_else(|| scene.clone(), |filter| scene.with_filter(filter))
    }

    /// Returns the caster that draws a scene: [`Step::Auto`] and [`Rule::Auto`] are replaced by what they mean there. Local steps follow what is known of the
    /// ranges of values.
    pub(crate) fn settled_for(&self, scene: &Scene) -> Self {
        let step = match (self.step, self.traversal) {
            (Step::Auto, _) if self.takes_whole_parts() => Step::Auto,
            (Step::Auto, _) if !self.follows_light(scene) || !knows_ranges(&scene.volume) => {
                Step::Uniform(self.quality.step())
            }
            (Step::Auto, Traversal::Samples) => Step::Local { error: self.quality.error() },
            (step, _) => step,
        };
        let rule = match (self.rule, step) {
            // A promised error has rules of its own.
            (Rule::Auto, Step::ErrorBound(_)) => Rule::Auto,
            (Rule::Auto, Step::Local { .. }) if self.is_sharp(scene) => Rule::Quadratic,
            (Rule::Auto, _) => Rule::Midpoint,
            (rule, _) => rule,
        };
        // The steps have the quality now.
        Self { step, rule, quality: Quality::default(), ..self.clone() }
    }

    /// True if a scene's transfer function changes too fast for single samples, and parabolas can follow the field.
    fn is_sharp(&self, scene: &Scene) -> bool {
        let Some(volume) = scene.volume.value_grid() else { return false };
        let filter = self.filter.unwrap_or(volume.filter());
        let integrates = scene.volume.colors().is_none() && !scene.transfer.has_rows() && filter.is_continuous();
        integrates && sharp_values(scene, volume).is_some_and(|sharp| !sharp.is_empty())
    }

    /// True if every step is one voxel, or one cell that need not be cut.
    pub(crate) fn takes_whole_parts(&self) -> bool {
        #[cfg(feature = "classics")]
        if self.traversal == Traversal::Voxels {
            return true;
        }
        self.rule == Rule::Exact
    }

    /// True if light is added up along a ray from its begin on, so that steps can follow it.
    pub(crate) fn follows_light(&self, scene: &Scene) -> bool {
        scene.compositing.integrates_light() && self.order != CompositingOrder::BackToFront
    }

    /// True if steps end at the faces of cells.
    pub(crate) fn ends_steps_at_faces(&self) -> bool {
        #[cfg(feature = "classics")]
        if self.image_sampling == (ImageSampling::Template { connectivity: crate::classics::Connectivity::Faces }) {
            return true;
        }
        self.traversal == Traversal::Cells
    }

    /// Returns the threshold of adaptive rays in a picture of so many pixels; `None` where every pixel has its own. The caster is settled.
    pub(crate) fn adaptive_threshold(&self, pixels: u64) -> Option<f64> {
        match (self.image_sampling, self.step) {
            (ImageSampling::Adaptive { threshold }, _) => Some(threshold),
            (ImageSampling::Auto, Step::Local { error }) if pixels >= ImageSampling::LARGE => {
                Some(error * ImageSampling::THRESHOLD_PER_ERROR)
            }
            _ => None,
        }
    }

    /// Returns the world length of a step.
    pub(crate) fn world_step(&self, placement: &Placement) -> f64 {
        // Other steps have no one length.
        let voxels = self.step.length().unwrap_or(1.0);
        voxels * placement.spacing().min_element()
    }

    /// Returns the world length that no step of a walk exceeds; +∞ where cells are not cut, since cutting gains nothing where the rule is exact already.
    pub(crate) fn longest_step(&self, placement: &Placement) -> f64 {
        match (self.traversal, self.rule, self.step) {
            (Traversal::Cells, _, Step::Auto) => f64::INFINITY,
            _ => self.world_step(placement),
        }
    }
}

/// True if the ranges of a volume's values are known part by part, so that steps can follow them.
pub(crate) fn knows_ranges(volume: &Volume) -> bool {
    volume.value_grid().is_some() || cells_of_parts(volume).is_some()
}
