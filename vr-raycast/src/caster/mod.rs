//! The ray caster's settings: each in a file of its own, and here what is asked of them together.

mod kernel;
mod leaping;
mod order;
mod rule;
mod screen;
mod step;
mod traversal;

use vr_core::{Filter, ParameterError, Scene, UniformVolume};

use crate::tolerance::check_error;

pub use kernel::{Classification, Precision, Vector};
pub use leaping::Leaping;
pub use order::Order;
pub use rule::Rule;
#[cfg(feature = "classics")]
pub use screen::Connectivity;
pub use screen::Screen;
pub use step::Step;
pub use traversal::Traversal;

/// Casts rays through the pixels of a view and samples the volume along them; the crate's front page says how.
///
/// ```
/// use vr_raycast::{Order, RayCaster, Step};
/// let fine = RayCaster { step: Step::Uniform(0.25), ..RayCaster::default() };
/// let backwards = RayCaster { order: Order::BackToFront, ..fine };
/// # assert_eq!(backwards.step, Step::Uniform(0.25));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RayCaster {
    /// How long steps are.
    pub step: Step,
    /// What the steps of a ray are.
    pub traversal: Traversal,
    /// How empty space is leapt over.
    pub leaping: Leaping,
    /// How the light of a step is found, which sets the order of convergence.
    pub rule: Rule,
    /// From which end the samples of a ray are composited.
    pub order: Order,
    /// The reconstruction filter; `None`: the scene's.
    pub filter: Option<Filter>,
    /// How a value becomes light and opacity.
    pub classification: Classification,
    /// Precision of the kernels.
    pub precision: Precision,
    /// Which rays the picture is made of.
    pub screen: Screen,
    /// Whether rays go in packets of sixteen, by vector instructions, where a scene allows it.
    pub vector: Vector,
}

impl RayCaster {
    /// The name in scene files and on command lines.
    pub const NAME: &'static str = "raycast";
    /// The longest step that is taken, in voxels.
    pub const LONGEST_STEP: f64 = 64.0;

    /// The default caster, but for steps of one length: a fraction of the smallest voxel edge.
    pub fn uniform(step: f64) -> Self {
        Self { step: Step::Uniform(step), ..Self::default() }
    }

    /// The caster that comes nearest to the limit of its step: exact classification in f64 along whole rays.
    pub fn exact(step: f64) -> Self {
        Self {
            step: Step::Uniform(step),
            order: Order::WHOLE_RAY,
            classification: Classification::Exact,
            precision: Precision::F64,
            ..Self::default()
        }
    }

    /// The filter that makes the field it samples.
    pub(crate) fn filter_of(&self, scene: &Scene) -> Filter {
        self.filter.unwrap_or(scene.filter)
    }

    /// The caster that draws a scene: what [`Step::Auto`] means for it.
    pub(crate) fn settled_for(&self, scene: &Scene) -> Self {
        let step = match (self.step, self.traversal) {
            (Step::Auto, _) if !self.follows_light(scene) => Step::Uniform(Step::OTHERWISE),
            (Step::Auto, Traversal::Samples) => Step::Local { error: Step::ERROR },
            (step, _) => step,
        };
        Self { step, ..self.clone() }
    }

    /// True if light is added up along a ray from its begin on, so that steps can follow it.
    pub(crate) fn follows_light(&self, scene: &Scene) -> bool {
        scene.compositing.integrates_light() && self.order != Order::BackToFront
    }

    /// World length of a step.
    pub(crate) fn world_step(&self, volume: &UniformVolume) -> f64 {
        self.step.shortest().unwrap_or(1.0) * volume.placement().spacing().min_element()
    }

    /// World length that no step of a walk exceeds; +∞: cells are not cut. Nothing is gained by cutting what is exact already.
    pub(crate) fn longest_step(&self, volume: &UniformVolume) -> f64 {
        match (self.traversal, self.rule, self.step) {
            (_, Rule::Exact, _) | (Traversal::Cells, _, Step::Auto) => f64::INFINITY,
            _ => self.world_step(volume),
        }
    }

    /// Checks the numbers, and that they go together.
    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        if let Some(step) = self.step.shortest().filter(|&step| !(step > 0.0 && step <= Self::LONGEST_STEP)) {
            return Err(ParameterError::new("render.step", step, "must be above 0 and at most 64"));
        }
        #[cfg(feature = "classics")]
        crate::classics::validate(self)?;
        match self.step {
            Step::Tolerance(error) => {
                check_error(error)?;
                let own = (self.order, self.rule, self.traversal);
                if own != (Order::default(), Rule::default(), Traversal::default()) {
                    let allowed = "a promised error leaves rule, traversal, order and termination to the caster: they must not be set";
                    return Err(ParameterError::new("render.max_error", error, allowed));
                }
            }
            Step::Local { error } if !(error > 0.0 && error <= 1.0) => {
                return Err(ParameterError::new("render.local-error", error, "must be above 0 and at most 1"));
            }
            _ => {}
        }
        self.validate_leaping()?;
        if self.traversal != Traversal::Samples && !matches!(self.step, Step::Auto | Step::Uniform(_)) {
            let allowed = "steps of this kind follow the medium, not cells or voxels: must be samples";
            return Err(ParameterError::new("render.traversal", self.traversal, allowed));
        }
        if self.rule == Rule::Exact && self.traversal != Traversal::Cells {
            return Err(ParameterError::new("render.rule", "exact", "needs traversal = \"cells\""));
        }
        if let Screen::Adaptive { threshold } = self.screen
            && !(threshold >= 0.0 && threshold.is_finite())
        {
            return Err(ParameterError::new("render.screen-threshold", threshold, "must be 0 or more, and finite"));
        }
        match self.order {
            Order::FrontToBack { termination } if !(termination > 0.0 && termination <= 1.0) => {
                Err(ParameterError::new("render.termination", termination, "must be above 0 and at most 1"))
            }
            _ => Ok(()),
        }
    }

    /// Checks that the way of leaping that was asked for can act.
    fn validate_leaping(&self) -> Result<(), ParameterError> {
        let refuse = |allowed| Err(ParameterError::new("render.leaping", self.leaping, allowed));
        match self.leaping {
            Leaping::Auto => Ok(()),
            Leaping::None if self.step.finds_empty_space() => Ok(()),
            _ if self.step.finds_empty_space() => refuse("coarse steps find the empty space themselves: must be none"),
            _ if self.traversal != Traversal::Samples => refuse("every cell is walked: must be absent"),
            _ if matches!(self.step, Step::Uniform(_)) => Ok(()),
            _ => refuse("steps that follow the medium leap by a map of their own: needs uniform steps (set step)"),
        }
    }
}
