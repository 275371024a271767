//! Plot and table of a study for a front page.

use crate::error::StudyError;
use crate::front::{THRESHOLDS, fastest_within, pareto_front};
use crate::study::SubjectResult;

use super::chart::{Chart, Look, Series};
use super::plots::place;

/// Returns the fronts of all subjects, all renderers together, as an SVG file.
///
/// # Errors
/// A plot that cannot be drawn.
pub fn headline_plot(results: &[SubjectResult]) -> Result<String, StudyError> {
    plot(results).standalone_svg()
}

/// Plots the fronts of all subjects, all renderers together.
pub(super) fn plot(results: &[SubjectResult]) -> Chart {
    let series: Vec<Series> = results
        .iter()
        .enumerate()
        .map(|(k, r)| {
            let places: Vec<(f64, f64)> = r.points.iter().map(place).collect();
            let points = pareto_front(&places).into_iter().map(|i| places[i]).collect();
            Series { name: r.name.clone(), points, labels: Vec::new(), color: k, look: Look::Line }
        })
        .collect();
    Chart {
        title: "What nothing beats in both time and error",
        x: "milliseconds a frame",
        y: "RMSE against the reference",
        series,
        levels: &THRESHOLDS,
    }
}

/// Returns the shortest time to reach each error on each subject, and its candidate, as a table in Markdown.
pub fn headline_table(results: &[SubjectResult]) -> String {
    let mut text = String::from("| scene |");
    for (_, name) in THRESHOLDS {
        text += &format!(" RMSE ≤ {name} |");
    }
    text += "\n|---|";
    text += &"--:|".repeat(THRESHOLDS.len());
    text += "\n";
    for r in results {
        text += &format!("| {} |", r.name);
        for cell in reaching(r) {
            text += &cell.map_or_else(|| " – |".to_owned(), |(ms, who)| format!(" {} ms, {who} |", milliseconds(ms)));
        }
        text += "\n";
    }
    text
}

/// Returns the shortest time to reach each error of [`THRESHOLDS`], and its candidate.
pub fn reaching(result: &SubjectResult) -> Vec<Option<(f64, String)>> {
    let pairs: Vec<(f64, f64)> = result.points.iter().map(crate::point::Point::pair).collect();
    let timed: Vec<(f64, f64)> =
        pairs.iter().map(|&(t, e)| if t.is_finite() { (t, e) } else { (t, f64::NAN) }).collect();
    let cell =
        |&(error, _): &(f64, &str)| fastest_within(error, &timed).map(|i| (pairs[i].0, result.points[i].candidate()));
    THRESHOLDS.iter().map(cell).collect()
}

/// Formats a number to three digits.
pub(super) fn milliseconds(ms: f64) -> String {
    match ms {
        _ if ms < 10.0 => format!("{ms:.2}"),
        _ if ms < 100.0 => format!("{ms:.1}"),
        _ => format!("{ms:.0}"),
    }
}
