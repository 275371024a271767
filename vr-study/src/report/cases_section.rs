//! Section of a report about hard cases.

use maud::{Markup, html};

use crate::figures::ErrorFigures;
use crate::stability::{CaseResult, Verdict};

use super::terms;

/// Returns the section; `failures` is the number of pictures that failed without an explanation.
pub(super) fn section(results: &[CaseResult], failures: usize) -> Markup {
    let mut candidates: Vec<&str> = Vec::new();
    let mut cases: Vec<(&str, &str)> = Vec::new();
    for r in results {
        if !candidates.contains(&r.candidate.as_str()) {
            candidates.push(&r.candidate);
        }
        if !cases.iter().any(|c| c.0 == r.case) {
            cases.push((&r.case, &r.summary));
        }
    }
    html! {
        section {
            h2 { "Hard cases" }
            p {
                "Small scenes, each made to be difficult in one way. "
                @if failures == 0 { "No unexplained failure." } @else { b.bad { (failures) " unexplained failures." } }
                " In each cell: the largest error (or " (terms::RMSE.word()) ", where the bound is one of that), the documented " (terms::BOUND.word()) ", the verdict."
            }
            div.wide tabindex="0" role="region" aria-label="Hard cases" {
                table {
                    thead { tr { th { "case" } @for c in &candidates { th { (c) } } } }
                    tbody {
                        @for (case, summary) in &cases {
                            tr {
                                th title=(summary) { (case) }
                                @for candidate in &candidates {
                                    @match results.iter().find(|r| r.case == *case && r.candidate == *candidate) {
                                        Some(r) => (cell(r)),
                                        None => td { "–" },
                                    }
                                }
                            }
                        }
                    }
                }
            }
            ul.cases { @for (case, summary) in &cases { li { b { (case) } ": " (summary) } } }
        }
    }
}

fn cell(r: &CaseResult) -> Markup {
    let class = match r.verdict {
        Verdict::Held => "good",
        Verdict::Failed { .. } => "bad",
        _ => "plain",
    };
    let error = |e: &ErrorFigures| if r.bound_of_rmse { e.rmse } else { e.max };
    html! {
        td class=(class) {
            (r.error.as_ref().map_or_else(|| "–".to_owned(), |e| format!("{:.1e}", error(e))))
            " / " (r.bound.map_or_else(|| "–".to_owned(), |b| format!("{b:.1e}")))
            @if r.bound_of_rmse { " RMSE" }
            br; (r.verdict.word())
            @if let Verdict::Failed { reason } = &r.verdict { ": " (reason) }
        }
    }
}
