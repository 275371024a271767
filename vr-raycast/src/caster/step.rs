//! Lengths of steps.

/// Length of the steps of a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Step {
    /// Default for the scene: [`Step::Local`] with the error of a [`Quality`](super::Quality) where light is followed along a ray, front to back; [`Step::Uniform`]
    /// elsewhere; whole cells or voxels where the [`Traversal`](super::Traversal) says so.
    ///
    /// In pictures of grids with [`ImageSampling::LARGE`](super::ImageSampling::LARGE) pixels or more, a few rays choose a length that all steps of the picture have, in the place of local ones, where
    /// the field does not jump and that takes less time for the same error.
    #[default]
    Auto,
    /// Steps of one length everywhere: a fraction of the smallest voxel edge, in world distance whatever the spacing. The last step of a ray is
    /// as long as is left, and counts as that.
    ///
    /// At ⅕, on the phantoms without jumps, at 64³ and finer and with their own transfer functions, no pixel of the
    /// views tested is further than 1/255 from the correct one; at ¼, Marschner-Lobb at 64³ is (5.8·10⁻³). The error grows
    /// with the square of the step, time with its inverse: fog is as good at a step of 2.
    Uniform(f64),
    /// Steps that are long where the medium is nearly the same, else as [`Uniform`](Self::Uniform) has them (after Danskin and Hanrahan 1992, *Fast
    /// algorithms for volume ray tracing*): a block, or a block of blocks, is crossed in one step where no pixel can change for that by
    /// more than its share of `error`.
    ///
    /// The long steps of a ray together are off by at most `error`, where no source is brighter than 1 (else in
    /// proportion); the short ones by what short steps are off by. For over and accumulate, also shaded.
    #[cfg(feature = "classics")]
    Homogeneous {
        /// Length of the short steps, as a fraction of the smallest voxel edge.
        step: f64,
        /// Largest error that all long steps of a ray may make together.
        error: f64,
    },
    /// Steps as [`Homogeneous`](Self::Homogeneous) has them, and through blocks whose field deviates from its mean by little in the root mean square,
    /// one at that mean: by the variance times what the transfer function makes of it.
    ///
    /// The RMSE that all long steps make in an orthographic picture, over the rays that meet the volume, is at most `error`, where no source is
    /// brighter than 1 (else in proportion). A single pixel may be off by more.
    #[cfg(feature = "classics")]
    Variance {
        /// Length of the short steps, as a fraction of the smallest voxel edge.
        step: f64,
        /// Largest RMSE that all long steps may make together.
        error: f64,
    },
    /// Steps as long as a bound of the error allows: no component of a pixel is further than this from the correct one, relative to max(1, the picture's
    /// largest magnitude); at least 10⁻⁶. Rays for which no such bound was found are counted ([`vr_core::Counts::unbounded`]).
    ///
    /// For over and accumulate, trilinear and nearest fields, without shading. Rule, traversal and order are the caster's own choice, and
    /// the transfer function is always evaluated exactly; in the precision f32, rays whose rounding takes too much are done again in f64.
    ErrorBound(f64),
    /// Adaptive ray traversal (Yagel & Shi 1993, "Accelerating volume animation by space-leaping"): coarse steps that look at nothing but a
    /// flag, and fine ones in the vicinity of what is visible, where the flag is set.
    ///
    /// The flag is kept per block of as many cells along its edge as a coarse step has voxels, and set where the block, or one of the
    /// 26 around it, holds something visible. A coarse step moves by at most one block along each axis (a 26-connected ray), and so
    /// passes nothing that is visible from where the flag is not set. Fine steps are those of [`Step::Uniform`]: the picture is the same,
    /// bit for bit.
    ///
    /// It finds the empty space itself, and so no [`EmptySpace`](super::EmptySpace) goes with it.
    #[cfg(feature = "classics")]
    Vicinity {
        /// Length of coarse steps: above `fine`, at most 64, in voxels.
        coarse: f64,
        /// Length of fine steps: a fraction of the smallest voxel edge.
        fine: f64,
    },
    /// Steps as long as what is in each place allows: short where extinction and emission change much within four voxels, up to sixteen voxels
    /// where they hardly do; and nothing is sampled where nothing is visible.
    ///
    /// Steps are chosen so that the picture's RMSE is about `error`: it is aimed at, not promised ([`Step::Local`] knows the
    /// size of changes, not their shape). Where the field jumps, at the faces of voxels under the filter nearest and of vacuum, steps
    /// end. For over and accumulate, front to back: other operators, and rays from back to front, have no light to follow.
    Local {
        /// RMSE to aim at, in (0, 1].
        error: f64,
    },
}

impl Step {
    /// Length of uniform steps, as a fraction of the smallest voxel edge, where local ones have nothing to follow.
    pub const OTHERWISE: f64 = 0.2;
    /// RMSE that local steps aim at by default; `docs/notes/vr-raycast.md` says how it was chosen.
    pub const ERROR: f64 = 1e-3;

    /// Returns the length of steps, as a fraction of the smallest voxel edge, where all have the same; `None` for other steps.
    pub(crate) fn length(mut self) -> Option<f64> {
        self.length_mut().copied()
    }

    /// Returns the same length as [`length`](Self::length), to be set.
    pub(crate) fn length_mut(&mut self) -> Option<&mut f64> {
        match self {
            Self::Uniform(step) => Some(step),
            #[cfg(feature = "classics")]
            Self::Vicinity { fine: step, .. } | Self::Homogeneous { step, .. } | Self::Variance { step, .. } => {
                Some(step)
            }
            Self::Auto | Self::Local { .. } | Self::ErrorBound(_) => None,
        }
    }

    /// True if steps are of one length, but for the last.
    pub(crate) fn is_on_lattice(self) -> bool {
        matches!(self, Self::Uniform(_)) || self.finds_empty_space()
    }

    /// True if the steps are of one length and find the empty space by themselves.
    pub(crate) fn finds_empty_space(self) -> bool {
        #[cfg(feature = "classics")]
        if matches!(self, Self::Vicinity { .. }) {
            return true;
        }
        false
    }
}
