//! Stability suite: every renderer on every hard case, its error beside the bound that it documents.

use serde::{Deserialize, Serialize};
use std::panic::{AssertUnwindSafe, catch_unwind};
use vr_core::cancel::catch_stopped;
use vr_core::{Control, DocumentedError, HardCaseErrors, Model, RenderError, StudiedRenderer};
use vr_physics::cases::{self, Case};
use vr_physics::metrics::subgrid;

use crate::candidate::Candidate;
use crate::figures::ErrorFigures;
use crate::reference::ReferenceCache;

/// Verdict on a candidate on a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "verdict", rename_all = "kebab-case")]
pub enum Verdict {
    /// The error is within the documented bound.
    Held,
    /// The error is beyond the bound, and the renderer itself counted the rays for which it has no bound.
    Counted {
        /// Number of these rays.
        rays: u64,
    },
    /// No bound is documented.
    Undocumented,
    /// The reference is less certain than the bound.
    Unjudged,
    /// The renderer refuses the scene.
    Refused {
        /// The feature that it lacks.
        feature: String,
    },
    /// The error is beyond the bound, a number is not finite, or the renderer panics or fails on a valid scene.
    Failed {
        /// The failure.
        reason: String,
    },
}

impl Verdict {
    /// True for a failure that the renderer does not explain.
    pub fn is_failure(&self) -> bool {
        matches!(self, Self::Failed { .. })
    }

    /// Returns a word or two for a table.
    pub fn word(&self) -> String {
        match self {
            Self::Held => "held".to_owned(),
            Self::Counted { rays } => format!("{rays} rays counted"),
            Self::Undocumented => "no bound".to_owned(),
            Self::Unjudged => "not judged".to_owned(),
            Self::Refused { .. } => "refused".to_owned(),
            Self::Failed { .. } => "FAILED".to_owned(),
        }
    }
}

/// Cell of the table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaseResult {
    /// The hard case.
    pub case: String,
    /// The difficulty.
    pub summary: String,
    /// The candidate.
    #[serde(rename = "contestant")]
    pub candidate: String,
    /// The error that is documented.
    pub bound: Option<f64>,
    /// True if a documented bound is of the RMSE, false if it is of the largest error.
    #[serde(default)]
    pub bound_of_rmse: bool,
    /// The error, where there is a picture.
    pub error: Option<ErrorFigures>,
    /// The verdict.
    pub verdict: Verdict,
}

/// Returns the candidates: every renderer at its defaults, and under those settings of which a bound is documented.
pub fn candidates_with_bounds<'a>(
    renderers: &'a [Box<dyn StudiedRenderer>],
    settings: &'a [Candidate],
) -> Vec<(String, &'a dyn StudiedRenderer)> {
    let mut all: Vec<(String, &dyn StudiedRenderer)> =
        renderers.iter().map(|r| (format!("{} default", r.name()), &**r)).collect();
    let documented = |c: &&Candidate| c.configured.hard_case_errors() != HardCaseErrors::default();
    all.extend(settings.iter().filter(documented).map(|c| (c.name(), &*c.configured)));
    all
}

/// Draws every case with a candidate.
///
/// # Errors
/// Cancellation alone: all else is a verdict.
pub fn survey(
    (name, renderer): (&str, &dyn StudiedRenderer),
    cache: &ReferenceCache,
    control: &Control,
) -> Result<Vec<CaseResult>, RenderError> {
    cases::all().iter().map(|case| judge((name, renderer), case, cache, control)).collect()
}

fn judge(
    (name, renderer): (&str, &dyn StudiedRenderer),
    case: &Case,
    cache: &ReferenceCache,
    control: &Control,
) -> Result<CaseResult, RenderError> {
    let bound = renderer.hard_case_errors().for_case(case.name);
    let mut result = CaseResult {
        case: case.name.to_owned(),
        summary: case.summary.to_owned(),
        candidate: name.to_owned(),
        bound: bound.map(DocumentedError::value),
        bound_of_rmse: matches!(bound, Some(DocumentedError::Rmse(_))),
        error: None,
        verdict: Verdict::Unjudged,
    };
    let draw = || renderer.prepare(&case.scene, control)?.render(&case.view, control);
    // A renderer that panics on a case is prepared anew for the next one.
    let rendered = match catch_unwind(AssertUnwindSafe(|| catch_stopped(draw))) {
        Ok(Ok(rendered)) => rendered,
        Ok(Err(RenderError::Cancelled)) => return Err(RenderError::Cancelled),
        Ok(Err(RenderError::Unsupported(refused))) => {
            result.verdict = Verdict::Refused { feature: refused.what };
            return Ok(result);
        }
        Ok(Err(other)) => {
            result.verdict = Verdict::Failed { reason: other.to_string() };
            return Ok(result);
        }
        Err(_) => {
            result.verdict = Verdict::Failed { reason: "panics".to_owned() };
            return Ok(result);
        }
    };
    if let Some(p) = rendered.frame.pixels().iter().find(|p| p.iter().any(|c| !c.is_finite())) {
        result.verdict = Verdict::Failed { reason: format!("a pixel is {p:?}") };
        return Ok(result);
    }
    let all = subgrid(u32::MAX, case.view.size);
    let reference = cache.solve((&case.scene, &case.view), &Model::Canonical, all, control)?;
    let metrics = reference.judge(&rendered.frame);
    let uncertainty = reference.certainty.value() / reference.scale();
    result.error = Some(ErrorFigures::new(&reference, &rendered.frame));
    let pixels_beyond =
        |e: f64| reference.errors(&rendered.frame).into_iter().filter(|&error| error > e).count() as u64;
    let Some(documented) = bound else {
        result.verdict = Verdict::Undocumented;
        return Ok(result);
    };
    let (bound, error) = (documented.value(), documented.choose(metrics.max, metrics.rmse));
    let counted = || pixels_beyond(bound + uncertainty) <= rendered.stats.counts.unbounded;
    result.verdict = if error <= bound {
        Verdict::Held
    } else if error <= bound + uncertainty {
        if uncertainty > bound { Verdict::Unjudged } else { Verdict::Held }
    } else if matches!(documented, DocumentedError::Max(_)) && counted() {
        // No more pixels than the renderer itself counted as unbounded.
        Verdict::Counted { rays: rendered.stats.counts.unbounded }
    } else {
        Verdict::Failed { reason: format!("{error:.2e} beyond the documented {bound:.2e}") }
    };
    Ok(result)
}
