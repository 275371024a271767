//! Section of a report about orders of convergence.

use maud::{Markup, html};

use crate::convergence::{Convergence, Outcome, Refined};
use crate::error::StudyError;

use super::figure::narrow;
use super::{plots, terms};

/// Returns the section.
///
/// # Errors
/// A plot that cannot be drawn.
pub(super) fn section(results: &[Convergence]) -> Result<Markup, StudyError> {
    let mut renderers: Vec<&str> = results.iter().map(|c| c.renderer.as_str()).collect();
    renderers.dedup();
    Ok(html! {
        section {
            h2 { "Orders of convergence" }
            p {
                "How fast errors fall as something is refined. The " (terms::ORDER.word()) " is the slope: of order 2, half the step leaves a quarter of the error. "
                "One thing is refined at a time, on a smooth field; thin lines have the documented slope. Legends tell the measured order, and in brackets the documented one."
            }
            @for renderer in renderers {
                @let own: Vec<&Convergence> = results.iter().filter(|c| c.renderer == renderer).collect();
                h3 { (renderer) }
                div.row {
                    @for refined in Refined::ALL {
                        @if own.iter().any(|c| c.refined == refined) { (narrow(&plots::orders(&own, refined), html! {})?) }
                    }
                }
                (table(renderer, &own))
            }
        }
    })
}

fn table(renderer: &str, own: &[&Convergence]) -> Markup {
    let words = [&terms::CLAIM, &terms::REFINED];
    let numbers = [&terms::DOCUMENTED, &terms::MEASURED, &terms::TOLERANCE];
    html! {
        div.wide tabindex="0" role="region" aria-label={ "Orders of " (renderer) } {
            table {
                thead {
                    tr {
                        @for term in words { th.left { (term.word()) } }
                        @for term in numbers { th { (term.word()) } }
                        th.left { (terms::RMSE.called("errors, coarse to fine")) }
                        th { "verdict" }
                    }
                }
                tbody {
                    @for c in own {
                        tr {
                            td.left { (c.claim) } td.left { (c.refined.word()) } td { (c.expected) }
                            td { (c.measured.map_or_else(|| "–".to_owned(), |m| format!("{m:.2}"))) }
                            td { (c.tolerance) }
                            td.left { (c.errors.iter().map(|&e| format!("{e:.1e}")).collect::<Vec<_>>().join("  ")) }
                            td class=(class(c)) { (c.outcome().word()) @if let Some(t) = &c.trouble { ": " (t) } }
                        }
                    }
                }
            }
        }
    }
}

fn class(c: &Convergence) -> &'static str {
    match c.outcome() {
        Outcome::Holds | Outcome::Exact => "good",
        Outcome::Refused | Outcome::Empty => "plain",
        Outcome::Fails => "bad",
    }
}
