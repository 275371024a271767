//! Standard by which pictures of one view are judged.

use std::time::Duration;

use vr_core::{Control, Frame, Model, Prepared, RenderError, Scene, View};
use vr_physics::metrics::subgrid;

use super::BoundedRenderer;
use super::rmse::RmseEstimate;
use super::strata;
use crate::reference::{ReferenceCache, ReferencePixels, SUBGRID};

/// Standard by which pictures of one view are judged, the most certain first.
pub(super) enum Judge {
    /// Picture of which every pixel is within `error` of the correct one.
    Proven {
        /// The picture.
        frame: Frame,
        /// Largest error of the picture.
        error: f64,
    },
    /// Reference pixels, all of the view or an even sample where no more is needed.
    Reference(ReferencePixels),
    /// Reference pixels that are chosen for each picture.
    Strata,
}

/// Largest share of the target that a proven picture's own error may be.
const MAX_SHARE: f64 = 0.25;
/// Number of parts along each side of the small picture, of each of which a pixel is compared with the reference.
const SMALL_SUBGRID: u32 = 40;
/// Longest time in which the reference pixels of a whole picture are solved.
const PATIENCE: Duration = Duration::from_secs(20);
/// Number of parts along each side of a picture, of each of which a pixel is solved to estimate the time of all.
const TIMED_SUBGRID: u32 = 12;

impl Judge {
    /// Returns the judge of small pictures, which only select candidates for larger ones.
    pub(super) fn of_small(
        target: f64,
        bounded: &[BoundedRenderer],
        (scene, small): (&Scene, &View),
        cache: &ReferenceCache,
        control: &Control,
    ) -> Result<Self, RenderError> {
        if let Some(proven) = Self::proven(target, bounded, (scene, small), control)? {
            return Ok(proven);
        }
        let pixels = subgrid(SMALL_SUBGRID, small.size);
        cache.solve((scene, small), &Model::Canonical, pixels, control).map(Self::Reference)
    }

    /// Returns the judge of whole pictures.
    pub(super) fn of_whole(
        target: f64,
        bounded: &[BoundedRenderer],
        (scene, view): (&Scene, &View),
        control: &Control,
    ) -> Result<Self, RenderError> {
        if let Some(proven) = Self::proven(target, bounded, (scene, view), control)? {
            return Ok(proven);
        }
        let all = subgrid(u32::MAX, view.size);
        let solve = |pixels| ReferencePixels::solve((scene, view), &Model::Canonical, pixels, control);
        if all.len() > (SUBGRID * SUBGRID) as usize {
            let some = solve(subgrid(TIMED_SUBGRID, view.size))?;
            if some.time.mul_f64(all.len() as f64 / some.count() as f64) > PATIENCE {
                return Ok(Self::Strata);
            }
        }
        solve(all).map(Self::Reference)
    }

    /// Returns the picture of the first bounded renderer that draws the scene and counts no pixel as unbounded.
    fn proven(
        target: f64,
        bounded: &[BoundedRenderer],
        (scene, view): (&Scene, &View),
        control: &Control,
    ) -> Result<Option<Self>, RenderError> {
        for candidate in preparing(target, bounded, scene, control) {
            let (mut prepared, error) = candidate?;
            match prepared.render(view, control) {
                Ok(drawn) if drawn.stats.counts.unbounded == 0 => {
                    return Ok(Some(Self::Proven { frame: drawn.frame, error }));
                }
                Ok(_) | Err(RenderError::Unsupported { .. }) => {}
                Err(other) => return Err(other),
            }
        }
        Ok(None)
    }

    /// True if [`rmse`](Self::rmse) is more certain with a finer picture beside the one that is judged.
    pub(super) fn needs_a_guide(&self) -> bool {
        matches!(self, Self::Strata)
    }

    /// Returns the RMSE of a picture; `finer` shows where it may be wrong.
    pub(super) fn rmse(
        &self,
        frame: &Frame,
        finer: Option<&Frame>,
        scene: (&Scene, &View),
        cache: &ReferenceCache,
        control: &Control,
    ) -> Result<RmseEstimate, RenderError> {
        match self {
            Self::Proven { frame: proven, error } => Ok(RmseEstimate::against(frame, proven, *error)),
            Self::Reference(reference) => Ok(RmseEstimate::of_sample(reference, frame)),
            Self::Strata => strata::bound(frame, finer.unwrap_or(frame), scene, cache, control),
        }
    }
}

/// Prepares a scene with the renderers whose bound is small beside the target, one after the other, and returns them with their bounds; those that do not take the scene are left out.
pub(super) fn preparing<'a>(
    target: f64,
    bounded: &'a [BoundedRenderer],
    scene: &'a Scene,
    control: &'a Control,
) -> impl Iterator<Item = Result<(Box<dyn Prepared>, f64), RenderError>> {
    let near = bounded.iter().filter(move |renderer| renderer.max_error <= MAX_SHARE * target);
    near.filter_map(|BoundedRenderer { renderer, max_error }| match renderer.prepare(scene, control) {
        Err(RenderError::Unsupported { .. }) => None,
        prepared => Some(prepared.map(|prepared| (prepared, *max_error))),
    })
}
