//! The ray caster's settings.

use vr_core::{Filter, ParameterError, Scene, UniformVolume};

/// Casts rays and samples them at equal distances; the crate's front page says how.
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
    /// Where in its step a sample is taken, which sets the order of convergence.
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
}

/// How long steps are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// The same everywhere: a fraction of the smallest voxel edge, in world distance whatever the spacing. The last step of a ray is
    /// as long as is left, and counts as that.
    ///
    /// Default ⅕: on the phantoms without jumps, at 64³ and finer and with their own transfer functions, no pixel of the
    /// views tested is then further than 1/255 from the truth; at ¼, Marschner-Lobb at 64³ is (5.8·10⁻³). The error grows
    /// with the square of the step, time with its inverse: fog is as good at a step of 2.
    Uniform(f64),
    /// As long as what is in each place allows: short where extinction and emission change much within four voxels, up to sixteen voxels
    /// where they hardly do; and nothing is sampled where nothing is visible.
    ///
    /// Steps are chosen so that the picture's RMSE is about `error`: it is aimed at, not promised ([`Step::Local`] knows the
    /// size of changes, not their shape). For over and accumulate, front to back.
    Local {
        /// RMSE to aim at, in (0, 1].
        error: f64,
    },
}

impl Default for Step {
    fn default() -> Self {
        Self::Uniform(0.2)
    }
}

/// Where in its step a sample is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rule {
    /// In the middle: order 2.
    #[default]
    Midpoint,
    /// Where the ray enters the step (left rectangles): order 1. For study, not for use.
    Left,
}

/// From which end the samples of a ray are composited under `over`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// From the eye into the depth; can stop early.
    FrontToBack {
        /// Opacity in (0, 1] at which a ray ends; 1: where nothing behind can be seen at all.
        ///
        /// No pixel changes by more than `1 − termination`: that holds as it stands where no point of the medium shines brighter
        /// than 1, and where one can, rays go on correspondingly longer.
        termination: f64,
    },
    /// From the depth to the eye: the same sum, rounded otherwise. It cannot stop early, and it is defined for `over` alone.
    BackToFront,
}

impl Order {
    /// The opacity at which rays end by default: the 10⁻⁴ that this can cost is a fortieth of what an 8-bit picture can show.
    pub const TERMINATION: f64 = 0.9999;

    /// Front to back, ended only by what is opaque in all bits.
    pub const WHOLE_RAY: Self = Self::FrontToBack { termination: 1.0 };
}

impl Default for Order {
    fn default() -> Self {
        Self::FrontToBack { termination: Self::TERMINATION }
    }
}

/// How a value becomes light and opacity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Classification {
    /// Looked up in a table made for the step's length; see [`vr_core::transfer::BakedTransfer`] for what that adds to the error.
    /// Where a transfer function tells apart what no table of some thousand entries can, it is evaluated exactly after all.
    #[default]
    Table,
    /// Evaluated at every sample in f64: slow, for study and for transfer functions finer than any table.
    Exact,
}

/// Precision of the kernels. Rays, and sums of more than a few dozen samples, are in f64 always.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32-bit floats. Where a ramp of the transfer function is narrower than 1/4096 of the largest stored number, which f32 hardly tells
    /// apart, 64-bit ones after all.
    #[default]
    F32,
    /// 64-bit floats: for measuring what the other leaves.
    F64,
}

/// Which rays a picture is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Screen {
    /// Those of every pixel.
    #[default]
    EveryPixel,
    /// Every eighth pixel's first, then those between where the colours differ; the rest is interpolated (Levoy, *Volume rendering by
    /// adaptive refinement*, 1990). Not exact: see the crate's front page for what was measured.
    Adaptive {
        /// The largest difference of a component of the premultiplied colours that is not refined, 0 or more; 0: every pixel is traced.
        threshold: f64,
    },
    /// Every pixel's, each begun where its part of the view can show something first. That is projected for each view from what
    /// earlier pictures met first (a C-buffer; Yagel and Shi, *Accelerating volume animation by space-leaping*, 1993). The picture is that
    /// of [`Screen::EveryPixel`], bit for bit. For steps of one length, under over and accumulate.
    Coherent,
    /// Parallel rays that all step through the voxels alike, cast from the face of the volume that looks at the eye most; what they
    /// show there is stretched onto the screen (Yagel and Kaufman, *Template-based volume viewing*, 1992). Not exact, and for unshaded
    /// scenes under over in orthographic views without layers alone.
    Template {
        /// What the template is made of.
        connectivity: Connectivity,
    },
}

/// What a ray template is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connectivity {
    /// Voxels that touch by a face, an edge or a corner (26-connected), one in each slice: their own values, not interpolated.
    Discrete,
    /// Points at equal distances, between the voxels: trilinear samples, with the same weights on all rays.
    Continuous,
}

impl RayCaster {
    /// The name in scene files and on command lines.
    pub const NAME: &'static str = "raycast";
    /// The longest step that is taken, in voxels.
    pub const LONGEST_STEP: f64 = 64.0;

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

    /// World length of a step.
    pub(crate) fn world_step(&self, volume: &UniformVolume) -> f64 {
        let voxels = match self.step {
            Step::Uniform(voxels) => voxels,
            Step::Local { .. } => 1.0,
        };
        voxels * volume.placement().spacing().min_element()
    }

    /// Checks the numbers.
    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        match self.step {
            Step::Uniform(step) if !(step > 0.0 && step <= Self::LONGEST_STEP) => {
                return Err(ParameterError::new("render.step", step, "must be above 0 and at most 64"));
            }
            Step::Local { error } if !(error > 0.0 && error <= 1.0) => {
                return Err(ParameterError::new("render.local-error", error, "must be above 0 and at most 1"));
            }
            Step::Uniform(_) | Step::Local { .. } => {}
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
}
