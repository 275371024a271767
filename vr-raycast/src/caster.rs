//! The ray caster's settings.

use vr_core::{Filter, ParameterError, Scene, UniformVolume};

use crate::tolerance::check_error;

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

/// Which instructions the vector engine may use.
///
/// It draws `over` of the trilinear filter, front to back, in f32 with a table, by the rules `midpoint` and `left` under uniform steps and
/// by `midpoint` under local ones, unshaded or shaded by central differences, where no sample is missing and opacity does not follow the
/// gradient. Everything else goes through the plain engine. Under uniform steps it leaps by cubes of blocks of its own, whichever
/// structure [`Leaping`] names; with [`Leaping::None`], not at all.
///
/// Pictures do not depend on the instructions, bit for bit; from the plain engine's they differ by rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Vector {
    /// The widest that the machine has.
    #[default]
    Auto,
    /// At most AVX2.
    Avx2,
    /// Those that every machine of the architecture has: SSE2, NEON.
    Baseline,
    /// The plain engine draws everything.
    Off,
}

/// How long steps are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// The same everywhere: a fraction of the smallest voxel edge, in world distance whatever the spacing. The last step of a ray is
    /// as long as is left, and counts as that.
    ///
    /// At ⅕, on the phantoms without jumps, at 64³ and finer and with their own transfer functions, no pixel of the
    /// views tested is further than 1/255 from the truth; at ¼, Marschner-Lobb at 64³ is (5.8·10⁻³). The error grows
    /// with the square of the step, time with its inverse: fog is as good at a step of 2.
    Uniform(f64),
    /// Long where the medium is nearly the same, else as [`Uniform`](Self::Uniform) has it (after Danskin and Hanrahan 1992, *Fast
    /// algorithms for volume ray tracing*): a block, or a block of blocks, is crossed in one step where no pixel can change for that by
    /// more than its share of `error`.
    ///
    /// The long steps of a ray together are off by at most `error` from the truth, where no source is brighter than 1 (else in
    /// proportion); the short ones by what short steps are off by. For over, front to back, without shading.
    Homogeneous {
        /// The short steps, as a fraction of the smallest voxel edge.
        step: f64,
        /// The largest error that long steps may make, all of a ray together.
        error: f64,
    },
    /// As long as a promise allows: no component of a pixel is further than this from the truth, relative to max(1, the picture's
    /// largest magnitude); at least 10⁻⁶. Rays for which no such bound was found are counted ([`vr_core::Counts::unbounded`]).
    ///
    /// For over and accumulate, trilinear and nearest fields, without shading. Rule, traversal and order are the caster's own choice, and
    /// the transfer function is always evaluated exactly; in the precision f32, rays whose rounding takes too much are done again in f64.
    Tolerance(f64),
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
    /// size of changes, not their shape). For over and accumulate, front to back: other operators, and rays from back to front, take uniform
    /// steps of [`Step::OTHERWISE`].
    Local {
        /// RMSE to aim at, in (0, 1].
        error: f64,
    },
}

impl Step {
    /// Uniform steps where local ones have nothing to follow, as a fraction of the smallest voxel edge.
    pub const OTHERWISE: f64 = 0.2;
    /// The error that local steps aim at by default; the crate's README says how it was chosen.
    pub const ERROR: f64 = 5e-4;
}

impl Default for Step {
    fn default() -> Self {
        Self::Local { error: Self::ERROR }
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

/// What the steps of a ray are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Traversal {
    /// Steps of the given length, wherever the cells' faces are.
    #[default]
    Samples,
    /// From cell to cell (3D DDA, Amanatides and Woo 1987): steps end at cell faces, and a cell is cut into equal steps where it is
    /// longer than a [`Step::Uniform`] (other settings do not cut them). No step has a kink of the trilinear field inside, and so
    /// rules keep the order that they have on smooth fields.
    Cells,
    /// From voxel to voxel (a 26-connected Bresenham line): the field is taken at the samples nearest to the ray, as if it were constant
    /// around each. The classic discrete approximation: of first order in the size of a voxel, and as there is one step a voxel, none
    /// makes it better. With [`Rule::Midpoint`] alone.
    Voxels,
}

/// How the light of a step is found. The rules differ where light is integrated (over, accumulate); other operators
/// look at one sample a step, in its middle (or its begin, by [`Rule::Left`]).
///
/// The orders hold for smooth fields. A trilinear field has kinks at cell faces, and a step that has one inside is off by the
/// square of its length under any rule: [`Traversal::Cells`] ends steps there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rule {
    /// By the value in its middle: order 2, and 1 at jumps of the transfer function.
    #[default]
    Midpoint,
    /// By the value where the ray enters the step (left rectangles): order 1. For study, not for use.
    Left,
    /// By a value that goes linearly from the begin of the step to its end, the transfer function being integrated over all values between
    /// ([`vr_core::transfer::PreIntegrated`]): order 2, at kinks and jumps of the transfer function, too. One sample a step.
    Linear,
    /// By the parabola through the values at begin, middle and end of the step, integrated so: order 4, at kinks of the transfer
    /// function, too, where Simpson's rule has 2. Two samples a step.
    Quadratic,
    /// By the cubic that a trilinear field is along a ray in each cell, to rounding: needs [`Traversal::Cells`], whose steps it does
    /// not cut further, and the trilinear filter. Four samples a cell, each step integrated in f64: for study.
    Exact,
}

impl Rule {
    /// As options name it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Midpoint => "midpoint",
            Self::Left => "left",
            Self::Linear => "linear",
            Self::Quadratic => "quadratic",
            Self::Exact => "exact",
        }
    }

    /// Whether it makes sense for a filter's field: not all values between two labels are on the way from one to the other.
    pub(crate) fn goes_with(self, filter: Filter) -> bool {
        match self {
            Self::Midpoint | Self::Left => true,
            Self::Linear | Self::Quadratic => filter.is_continuous(),
            Self::Exact => filter == Filter::Trilinear,
        }
    }
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
    /// Every fourth pixel's first, along x and y, then those between where the colours bend; the rest is interpolated by cubics (after Levoy,
    /// *Volume rendering by adaptive refinement*, 1990). Not exact: see the crate's README for what was measured.
    Adaptive {
        /// How far a component of the premultiplied colours may be from the straight lines through its neighbours' along x and y (the sum of
        /// both second differences), 0 or more, where nothing is refined; 0: every pixel is traced. Where features are wider than four
        /// pixels, the largest error of the interpolation is below it, and its RMSE a twentieth; what is thinner may be missed, whatever it
        /// is.
        threshold: f64,
    },
    /// Every pixel's, each begun where its part of the view can show something first. That is projected for each view from what
    /// earlier pictures met first (a C-buffer; Yagel and Shi, *Accelerating volume animation by space-leaping*, 1993). The picture is that
    /// of [`Screen::EveryPixel`], bit for bit. For samples at equal distances by the rules
    /// midpoint and left, under over and accumulate.
    Coherent,
    /// Parallel rays that all step through the voxels alike, cast from the face of the volume that looks at the eye most; what they
    /// show there is stretched onto the screen (Yagel and Kaufman, *Template-based volume viewing*, 1992). Not exact, and for unshaded
    /// scenes under over in orthographic views without layers alone.
    Template {
        /// What the template is made of.
        connectivity: Connectivity,
    },
}

impl Screen {
    /// As options name it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::EveryPixel => "every-pixel",
            Self::Adaptive { .. } => "adaptive",
            Self::Coherent => "coherent",
            Self::Template { connectivity: Connectivity::Discrete } => "template-discrete",
            Self::Template { connectivity: Connectivity::Continuous } => "template-continuous",
        }
    }
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

    /// The caster that draws a scene: where there is no light to follow, or no way to, local steps are uniform ones.
    pub(crate) fn settled_for(&self, scene: &Scene) -> Self {
        let follows = scene.compositing.integrates_light() && self.order != Order::BackToFront;
        match self.step {
            Step::Local { .. } if !follows => Self { step: Step::Uniform(Step::OTHERWISE), ..self.clone() },
            _ => self.clone(),
        }
    }

    /// World length of a step.
    pub(crate) fn world_step(&self, volume: &UniformVolume) -> f64 {
        let voxels = match self.step {
            Step::Uniform(voxels) | Step::Vicinity { fine: voxels, .. } | Step::Homogeneous { step: voxels, .. } => {
                voxels
            }
            // They have no one length.
            Step::Local { .. } | Step::Tolerance(_) => 1.0,
        };
        voxels * volume.placement().spacing().min_element()
    }

    /// World length that no step of a walk exceeds; +∞: cells are not cut. Nothing is gained by cutting what is exact already.
    pub(crate) fn longest_step(&self, volume: &UniformVolume) -> f64 {
        match (self.traversal, self.rule, self.step) {
            (_, Rule::Exact, _) | (Traversal::Cells, _, Step::Local { .. }) => f64::INFINITY,
            _ => self.world_step(volume),
        }
    }

    /// Checks the numbers, and that they go together.
    pub(crate) fn validate(&self) -> Result<(), ParameterError> {
        match self.step {
            Step::Uniform(step) | Step::Vicinity { fine: step, .. } | Step::Homogeneous { step, .. }
                if !(step > 0.0 && step <= Self::LONGEST_STEP) =>
            {
                return Err(ParameterError::new("render.step", step, "must be above 0 and at most 64"));
            }
            Step::Vicinity { coarse, fine } if !(coarse > fine && coarse <= Self::LONGEST_STEP) => {
                let allowed = "must be longer than the fine step, and at most 64";
                return Err(ParameterError::new("render.coarse", coarse, allowed));
            }
            Step::Vicinity { .. } if self.leaping != Leaping::None => {
                let allowed = "coarse steps find the empty space themselves: must be none";
                return Err(ParameterError::new("render.leaping", self.leaping, allowed));
            }
            Step::Homogeneous { error, .. } if !(error > 0.0 && error <= 1.0) => {
                return Err(ParameterError::new("render.homogeneity", error, "must be above 0 and at most 1"));
            }
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
            Step::Uniform(_) | Step::Vicinity { .. } | Step::Local { .. } | Step::Homogeneous { .. } => {}
        }
        if self.traversal != Traversal::Samples && !matches!(self.step, Step::Uniform(_) | Step::Local { .. }) {
            let allowed = "steps of this kind follow the medium, not cells or voxels: must be samples";
            return Err(ParameterError::new("render.traversal", self.traversal, allowed));
        }
        match (self.rule, self.traversal) {
            (Rule::Exact, Traversal::Samples | Traversal::Voxels) => {
                return Err(ParameterError::new("render.rule", "exact", "needs traversal = \"cells\""));
            }
            (Rule::Left | Rule::Linear | Rule::Quadratic, Traversal::Voxels) => {
                return Err(ParameterError::new("render.traversal", "voxels", "goes with rule = \"midpoint\" only"));
            }
            _ => {}
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
