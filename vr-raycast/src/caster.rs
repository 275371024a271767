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
    /// How empty space is leapt over.
    pub leaping: Leaping,
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
    /// Adaptive ray traversal (Yagel & Shi 1993, "Accelerating volume animation by space-leaping"): coarse steps that look at nothing but a
    /// flag, and fine ones in the vicinity of what is visible, where the flag is set.
    ///
    /// The flag is kept per block of as many cells along its edge as a coarse step has voxels, and set where the block, or one of the
    /// 26 around it, holds something visible. A coarse step moves by at most one block along each axis (a 26-connected ray), and so
    /// passes nothing that is visible from where the flag is not set. Fine steps are those of [`Step::Uniform`]: the picture is the same,
    /// bit for bit. Coarse steps are a whole number of fine ones.
    ///
    /// It finds the empty space itself, and so [`Leaping`] must be `None`.
    Vicinity {
        /// Length of coarse steps: above `fine`, at most 64, in voxels.
        coarse: f64,
        /// Length of fine steps: a fraction of the smallest voxel edge.
        fine: f64,
    },
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

/// How rays find out where nothing is visible. On steps of one length, no choice changes a picture by a bit: those are dropped in which
/// nothing is visible.
///
/// It applies to `over`, `accumulate` and `first`. An average, a maximum or a minimum depends on what is transparent, too: these
/// sample everything, whatever is chosen.
///
/// Visible is a block of 8³ cells whose range of values holds anything that the transfer function, and the table made of it, do not
/// make perfectly clear (under `first`: that reaches the threshold). Each structure is made anew when the transfer function changes.
///
/// [`Step::Local`] leaps by its own map of smaller blocks: to it, all choices but `None` are the same, and without leaping its steps lie
/// elsewhere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Leaping {
    /// All steps are sampled.
    None,
    /// An octree of minima and maxima, from the root down.
    Octree,
    /// The same nodes, each block storing the level of the largest one around it that is all clear, or all visible.
    Pyramid,
    /// Balls: each block stores its exact Euclidean distance to the nearest block of the other kind.
    ///
    /// The default: the fastest of all on sparse blobs, thin shells and a real scan; a fog loses nothing by it (`benches/leaping.rs`).
    #[default]
    ExactCloud,
    /// Cubes: each block stores its distance to the nearest block of the other kind as a king moves on a chessboard.
    ChessboardCloud,
    /// Up to eight boxes around the visible blocks.
    Boxes,
    /// One convex polyhedron of 26 faces around the visible blocks.
    Polyhedron,
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
            Step::Uniform(voxels) | Step::Vicinity { fine: voxels, .. } => voxels,
            Step::Local { .. } => 1.0,
        };
        voxels * volume.placement().spacing().min_element()
    }

    /// Checks the numbers.
    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        match self.step {
            Step::Uniform(fine) | Step::Vicinity { fine, .. } if !(fine > 0.0 && fine <= Self::LONGEST_STEP) => {
                return Err(ParameterError::new("render.step", fine, "must be above 0 and at most 64"));
            }
            Step::Vicinity { coarse, fine } if !(coarse > fine && coarse <= Self::LONGEST_STEP) => {
                let allowed = "must be longer than the fine step, and at most 64";
                return Err(ParameterError::new("render.coarse", coarse, allowed));
            }
            Step::Vicinity { .. } if self.leaping != Leaping::None => {
                let allowed = "coarse steps find the empty space themselves: must be none";
                return Err(ParameterError::new("render.leaping", self.leaping, allowed));
            }
            Step::Local { error } if !(error > 0.0 && error <= 1.0) => {
                return Err(ParameterError::new("render.local-error", error, "must be above 0 and at most 1"));
            }
            Step::Uniform(_) | Step::Vicinity { .. } | Step::Local { .. } => {}
        }
        match self.order {
            Order::FrontToBack { termination } if !(termination > 0.0 && termination <= 1.0) => {
                Err(ParameterError::new("render.termination", termination, "must be above 0 and at most 1"))
            }
            _ => Ok(()),
        }
    }
}
