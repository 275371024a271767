//! Table of settings of a subject, with the meaning of each column at its head.

use maud::{Markup, html};

use crate::point::Point;
use crate::study::SubjectResult;

use super::headline::milliseconds;
use super::terms::{self, Term};

/// Columns of numbers.
const COLUMNS: [&Term; 11] = [
    &terms::FRAME,
    &terms::SPREAD,
    &terms::PREPARE,
    &terms::MEMORY,
    &terms::SAMPLES,
    &terms::RMSE,
    &terms::MAX,
    &terms::BIAS,
    &terms::P99,
    &terms::OWN_MODEL,
    &terms::FUNCTION,
];

/// Returns the table of some of a subject's points, in a box that scrolls by itself.
pub(super) fn table(s: &SubjectResult, which: &[usize]) -> Markup {
    html! {
        div.wide tabindex="0" role="region" aria-label={ "Settings on " (s.name) } {
            table {
                thead { tr { th { "#" } th.left { (terms::SETTING.word()) } @for term in COLUMNS { th { (term.word()) } } } }
                tbody { @for &i in which { (row(i + 1, &s.points[i])) } }
            }
        }
    }
}

fn row(number: usize, p: &Point) -> Markup {
    let or_dash = |x: Option<String>| x.unwrap_or_else(|| "–".to_owned());
    html! {
        tr {
            td { (number) }
            td.left title=(options(p)) { (p.candidate()) }
            td { (or_dash(p.times.map(|t| milliseconds(t.frame.median)))) }
            td { (or_dash(p.times.map(|t| format!("{} … {}", milliseconds(t.frame.min), milliseconds(t.frame.max))))) }
            td { (or_dash(p.times.map(|t| milliseconds(t.prepare.median)))) }
            td { (or_dash(p.peak_bytes.map(bytes))) }
            td { (p.counts.get("samples").copied().unwrap_or(0)) }
            td { (small(p.error.rmse)) }
            td { (small(p.error.max)) }
            td { (small(p.error.bias)) }
            td { (small(p.error.p99)) }
            td { (or_dash(p.own_error.as_ref().map(|e| small(e.rmse)))) }
            td { (or_dash(p.function_error.as_ref().map(|e| small(e.rmse)))) }
        }
    }
}

fn options(p: &Point) -> String {
    p.options.0.iter().map(|(k, v)| format!("{k}={v}")).collect::<Vec<_>>().join(" ")
}

/// Formats a number to three digits with its power of ten.
pub(super) fn small(x: f64) -> String {
    if x == 0.0 { "0".to_owned() } else { format!("{x:.2e}") }
}

fn bytes(n: u64) -> String {
    match n {
        0..1_000_000 => format!("{:.0} kB", n as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", n as f64 / 1e6),
        _ => format!("{:.2} GB", n as f64 / 1e9),
    }
}
