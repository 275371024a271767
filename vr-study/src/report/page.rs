//! Page of a report: one file that needs nothing else.

use maud::{DOCTYPE, Markup, PreEscaped, html};
use time::OffsetDateTime;

use crate::error::StudyError;
use crate::machine::Machine;
use crate::scaling::Grown;
use crate::suite::Report;

use super::figure::{command, narrow};
use super::{cases_section, order_section, plots, subject_section, summary, terms};

/// Name of the program in a page's `generator`.
const GENERATOR: &str = "vr report";

/// True if a text is a page that [`page`] has made: it may be replaced by the next one.
pub fn is_page(text: &str) -> bool {
    text.contains(&format!("<meta name=\"generator\" content=\"{GENERATOR}\">"))
}

const STYLE: &str = include_str!("style.css");

/// Returns a report as an HTML page with everything in it: plots, pictures, tables, and the meaning of every term.
///
/// # Errors
/// A plot that cannot be drawn.
pub fn page(report: &Report) -> Result<String, StudyError> {
    let day = OffsetDateTime::now_utc().date();
    let title = format!("vr report, {}, {day}", report.suite.name());
    let content = content(report, &format!("{day}"))?.into_string();
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta name="generator" content=(GENERATOR);
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body { (PreEscaped(&content)) (terms::explanations(&content)) }
        }
    };
    Ok(markup.into_string())
}

fn content(report: &Report, day: &str) -> Result<Markup, StudyError> {
    let timed = report.subjects.iter().flat_map(|s| &s.points).any(|p| p.times.is_some());
    Ok(html! {
        h1 { "Speed against error" }
        p.lead {
            "How far pictures of each renderer are from the " (terms::REFERENCE.word()) ", and the time that they take. "
            "A word with a dotted line explains itself at a click."
        }
        p { "Suite " b { (report.suite.name()) } ", " (day) ", " (format!("{:.0}", report.seconds)) " s." }
        @if let Some(line) = &report.command { (command(line)) }
        (machine(&report.machine))
        @if !report.subjects.is_empty() {
            (summary::section(&report.subjects, timed)?)
            @for subject in &report.subjects { (subject_section::section(subject, timed)?) }
        }
        @if !report.orders.is_empty() { (order_section::section(&report.orders)?) }
        @if !report.stability.is_empty() { (cases_section::section(&report.stability, report.failed_cases())) }
        @if !report.growth.is_empty() {
            section {
                h2 { "Growth" }
                p {
                    "Each renderer at its defaults, on the phantom blobs. The " (terms::EXPONENT.word())
                    " in a legend says how time grows: 1 is in proportion, 2 four times the time for twice as much."
                }
                div.row { @for grown in Grown::ALL { (narrow(&plots::growth(&report.growth, grown), html! {})?) } }
            }
        }
        (how())
    })
}

fn machine(m: &Machine) -> Markup {
    html! {
        dl.machine {
            dt { "Processor" } dd { (m.processor.as_deref().unwrap_or("not told")) ", " (m.processors) " threads, " (m.threads) " used" }
            dt { "Memory" } dd { (m.memory.map_or_else(|| "not told".to_owned(), |b| format!("{:.1} GB", b as f64 / 1e9))) }
            dt { "System" } dd { (m.system) }
            dt { "Version" } dd { (m.version) @if !m.optimized { " (not optimized: times mean nothing)" } }
        }
    }
}

fn how() -> Markup {
    html! {
        section {
            h2 { "How this was measured" }
            ul {
                li { "Errors are frame − exact pixel, over red, green, blue and opacity of " (terms::PREMULTIPLIED.word()) " linear light, divided by max(1, the largest magnitude of the picture). 1/255 ≈ 0.0039 is what 8 bits can show." }
                li { "The " (terms::REFERENCE.word()) " integrates the equation of transfer in f64 with a bound on its own error. " (terms::OWN_MODEL.word()) ": RMSE against what the renderer itself integrates, another reconstruction filter say, done exactly. " (terms::FUNCTION.word()) ": against the phantom as the function that it is, without samples." }
                li { "Times are of frames after preparation. In each round every candidate prepares a copy of the scene, and draws two views of a turning camera in turns after a frame that counts nowhere; the shortest time of each view counts, and the mean of the two; of frames that take 40 ms or more, one is drawn each round, the first after preparation. Given is the median of the rounds, and the shortest and longest, corrected for how fast the machine was at the moment: a small computation, always the same, is timed before and after. Candidates take turns, so that a machine that slows down slows all." }
                li { "Memory is what preparation and frames need at once beyond the scene." }
                li { "Each picture holds a record of its scene and settings: saved from this page, " code { "vr rerun PICTURE" } " draws it again, and " code { "vr info PICTURE" } " prints the record. Maps of errors are colours, and hold none." }
            }
        }
    }
}
