//! What pictures of one view are judged by.

use std::time::Duration;

use vr_core::{Control, Frame, Model, RenderError, Scene, View};
use vr_physics::metrics::subgrid;

use super::Prover;
use super::rmse::RmseEstimate;
use super::strata;
use crate::exact::{Exact, ExactCache, SUBGRID};

/// What pictures of one view are judged by, the most certain first.
pub(super) enum Judge {
    /// A picture of which every pixel is within `error` of the truth.
    Proven {
        /// The picture.
        frame: Frame,
        /// Its largest error.
        error: f64,
    },
    /// Exact pixels: all of the view, or an even sample where no more is needed.
    Exact(Exact),
    /// Exact pixels that are chosen for each picture.
    Strata,
}

/// The largest share of the target that a proven picture's own error may be.
const MAX_SHARE: f64 = 0.25;
/// Parts along each side of the small picture that a pixel is taken of, where it is judged by exact pixels.
const SMALL_SUBGRID: u32 = 40;
/// Exact pixels of a whole picture are solved if that takes no longer than this.
const PATIENCE: Duration = Duration::from_secs(20);
/// Parts along each side of a picture of which a pixel is solved to see how long all take.
const TIMED_SUBGRID: u32 = 12;

impl Judge {
    /// For small pictures, which only tell what is worth a closer look.
    pub(super) fn of_small(
        target: f64,
        provers: &[Prover],
        (scene, small): (&Scene, &View),
        cache: &ExactCache,
        control: &Control,
    ) -> Result<Self, RenderError> {
        if let Some(proven) = Self::proven(target, provers, (scene, small), control)? {
            return Ok(proven);
        }
        let pixels = subgrid(SMALL_SUBGRID, small.size);
        cache.solve((scene, small), &Model::Canonical, pixels, control).map(Self::Exact)
    }

    /// For whole pictures.
    pub(super) fn of_whole(
        target: f64,
        provers: &[Prover],
        (scene, view): (&Scene, &View),
        control: &Control,
    ) -> Result<Self, RenderError> {
        if let Some(proven) = Self::proven(target, provers, (scene, view), control)? {
            return Ok(proven);
        }
        let all = subgrid(u32::MAX, view.size);
        let solve = |pixels| Exact::solve((scene, view), &Model::Canonical, pixels, control);
        if all.len() > (SUBGRID * SUBGRID) as usize {
            let some = solve(subgrid(TIMED_SUBGRID, view.size))?;
            if some.time.mul_f64(all.len() as f64 / some.count() as f64) > PATIENCE {
                return Ok(Self::Strata);
            }
        }
        solve(all).map(Self::Exact)
    }

    /// The picture of the first prover that draws the scene and keeps its promise.
    fn proven(
        target: f64,
        provers: &[Prover],
        (scene, view): (&Scene, &View),
        control: &Control,
    ) -> Result<Option<Self>, RenderError> {
        for Prover { renderer, max_error } in provers.iter().filter(|p| p.max_error <= MAX_SHARE * target) {
            let drawn = renderer.prepare(scene, control).and_then(|mut prepared| prepared.render(view, control));
            match drawn {
                Ok(drawn) if drawn.stats.counts.unbounded == 0 => {
                    return Ok(Some(Self::Proven { frame: drawn.frame, error: *max_error }));
                }
                Ok(_) | Err(RenderError::Unsupported { .. }) => {}
                Err(other) => return Err(other),
            }
        }
        Ok(None)
    }

    /// Whether [`rmse`](Self::rmse) is more certain with a finer picture beside the one that is judged.
    pub(super) fn needs_a_guide(&self) -> bool {
        matches!(self, Self::Strata)
    }

    /// The RMSE of a picture; `finer` shows where it may be wrong.
    pub(super) fn rmse(
        &self,
        frame: &Frame,
        finer: Option<&Frame>,
        scene: (&Scene, &View),
        cache: &ExactCache,
        control: &Control,
    ) -> Result<RmseEstimate, RenderError> {
        match self {
            Self::Proven { frame: proven, error } => Ok(RmseEstimate::against(frame, proven, *error)),
            Self::Exact(exact) => Ok(RmseEstimate::of_sample(exact, frame)),
            Self::Strata => strata::bound(frame, finer.unwrap_or(frame), scene, cache, control),
        }
    }
}
