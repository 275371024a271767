//! The named hard cases, one after the other.

use std::panic::{AssertUnwindSafe, catch_unwind};

use vr_core::{Control, DocumentedError, RenderError, Renderer};

use super::drawn::{SceneName, draw, solve_once};
use super::outcome::CheckFailure;
use super::test_scene::TestScene;
use crate::cases::{self, Case};
use crate::{Metrics, Reference};

const CHECK: &str = "survives the hard cases";

/// The outcome of a hard case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CaseOutcome {
    /// A picture, and its error.
    Drawn(Metrics),
    /// A picture, every number of which is finite, and no more is known: the renderer documents no error, so that the reference is
    /// not solved, or the reference cannot solve the scene.
    Unjudged,
    /// The renderer refuses such scenes.
    Refused,
}

/// One row of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct CaseResult {
    /// The case.
    pub name: &'static str,
    /// The outcome.
    pub outcome: CaseOutcome,
    /// The error that the renderer documents for the case.
    pub bound: DocumentedError,
    /// The error of the reference itself.
    pub uncertainty: f64,
}

/// Every case with its error and its bound. `{}` is a table for people.
#[derive(Clone, Debug, PartialEq)]
pub struct HardCases {
    /// The renderer.
    pub renderer: &'static str,
    /// The results, in the order of [`cases::all`].
    pub results: Vec<CaseResult>,
}

impl std::fmt::Display for HardCases {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "{:<18} {:>10} {:>10} {:>10} {:>10}  ({})", "case", "bound", "max", "RMSE", "bias", self.renderer)?;
        for CaseResult { name, outcome, bound, .. } in &self.results {
            let of = if let DocumentedError::Rmse(_) = bound { "RMSE " } else { "" };
            write!(f, "{name:<18} {:>10} ", format!("{of}{:.1e}", bound.value()))?;
            match outcome {
                CaseOutcome::Drawn(m) => writeln!(f, "{:>10.2e} {:>10.2e} {:>+10.2e}", m.max, m.rmse, m.bias)?,
                CaseOutcome::Unjudged => writeln!(f, "finite; not judged")?,
                CaseOutcome::Refused => writeln!(f, "refused")?,
            }
        }
        Ok(())
    }
}

/// Draws every [hard case](cases): no panic, no error but an honest [`RenderError::Unsupported`], no number that is not finite, and
/// no error above the one that the renderer documents for the case, be it the [largest](Metrics::max) or the
/// [root mean square](Metrics::rmse). Where that is +∞, nothing but finite numbers is asked for, and the reference is not solved.
/// The reference's own uncertainty comes on top of the bound.
///
/// # Errors
/// The first case that does not hold, with the table so far in the reason; a renderer that refuses every case.
pub fn survives_hard_cases<B: Into<DocumentedError>>(
    renderer: &dyn Renderer,
    bound: impl Fn(&Case) -> B,
    reference: &Reference,
) -> Result<HardCases, CheckFailure> {
    let failure = |reason, scene| CheckFailure { check: CHECK, renderer: renderer.name(), reason, scene };
    let mut table = HardCases { renderer: renderer.name(), results: Vec::new() };
    for case in cases::all() {
        let test = TestScene { scene: case.scene.clone(), view: case.view.clone() };
        // The lock of a panicking renderer is the renderer's own: nothing here is left half done.
        let result = catch_unwind(AssertUnwindSafe(|| judge(renderer, &case, &test, bound(&case).into(), reference)));
        match result.unwrap_or_else(|_| Err("panics".to_owned())) {
            Ok(result) => table.results.push(result),
            Err(reason) => {
                let reason = format!("{}: {reason}\nso far:\n{table}", case.name);
                return Err(failure(reason, Some(Box::new(test))));
            }
        }
    }
    if table.results.iter().all(|r| r.outcome == CaseOutcome::Refused) {
        return Err(failure(format!("refuses all {} cases", table.results.len()), None));
    }
    Ok(table)
}

fn judge(
    renderer: &dyn Renderer,
    case: &Case,
    test: &TestScene,
    bound: DocumentedError,
    reference: &Reference,
) -> Result<CaseResult, String> {
    let result = |outcome, uncertainty| CaseResult { name: case.name, outcome, bound, uncertainty };
    let frame = match draw(renderer, test, &Control::default()) {
        Ok(frame) => frame,
        Err(RenderError::Unsupported { .. }) => return Ok(result(CaseOutcome::Refused, 0.0)),
        Err(other) => return Err(format!("an error on a valid scene: {other}")),
    };
    if let Some(p) = frame.pixels().iter().find(|p| p.iter().any(|c| !c.is_finite())) {
        return Err(format!("a pixel is {p:?}"));
    }
    if bound.value() == f64::INFINITY {
        return Ok(result(CaseOutcome::Unjudged, f64::INFINITY));
    }
    let expected = solve_once(reference, SceneName::Case(case.name), test);
    let expected = expected.map_err(|e| format!("the reference fails: {e}"))?;
    let Some(expected) = expected else { return Ok(result(CaseOutcome::Unjudged, f64::INFINITY)) };
    let metrics = Metrics::of(&expected.pixels, frame.pixels());
    if bound.choose(metrics.max, metrics.rmse) <= bound.value() + expected.uncertainty {
        Ok(result(CaseOutcome::Drawn(metrics), expected.uncertainty))
    } else {
        Err(format!("{metrics}; documented {bound:.2?}"))
    }
}
