//! First section of a report: the shortest time to reach each error on each subject.

use maud::{Markup, html};

use crate::error::StudyError;
use crate::front::THRESHOLDS;
use crate::study::SubjectResult;

use super::figure::wide;
use super::headline::{self, milliseconds, reaching};
use super::subject_section::anchor;
use super::terms;

/// Returns the section.
///
/// # Errors
/// A plot that cannot be drawn.
pub(super) fn section(subjects: &[SubjectResult], timed: bool) -> Result<Markup, StudyError> {
    Ok(html! {
        section {
            h2 { "Time to reach an error" }
            p {
                "The " (terms::RMSE.word()) " is the size of a typical error of a pixel: 1/255 is one step of 8 bits, which can just be seen; 1e-3 "
                "is a quarter of it. For each scene the table names the fastest renderer and setting whose RMSE is no larger."
            }
            @if timed {
                (wide(&headline::plot(subjects), html! {
                    "Each line is the " (terms::FRONT.word()) " of one scene: the further left and down, the better."
                })?)
                div.wide tabindex="0" role="region" aria-label="Time to reach an error" {
                    table {
                        thead { tr { th { "scene" } @for (_, name) in THRESHOLDS { th { "RMSE ≤ " (name) } } } }
                        tbody {
                            @for s in subjects {
                                tr {
                                    th { a href={ "#" (anchor(&s.name)) } { (s.name) } }
                                    @for cell in reaching(s) {
                                        @match cell {
                                            Some((ms, who)) => td { b { (milliseconds(ms)) " ms" } br; span.who { (who) } },
                                            None => td { "–" },
                                        }
                                    }
                                }
                            }
                        }
                    }
                }
                p.note { "A dash: no setting reaches it." }
            } @else {
                p { "Nothing was timed." }
            }
        }
    })
}
