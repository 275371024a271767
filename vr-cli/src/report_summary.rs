//! Summary of a report in the terminal: a table and a few lines; everything else is in the page.

use std::path::PathBuf;

use vr_study::report::{headline_table, reaching};
use vr_study::scaling::Grown;
use vr_study::suite::Report;

use crate::number;
use crate::table::Table;

/// Largest number of rows of the table, and of lines about what is worse than a baseline.
const MAX_ROWS: usize = 12;
/// Columns of the table, as places in the list of errors: an error that can just be seen, and one that cannot.
const COLUMNS: [usize; 2] = [1, 3];

/// Returns the summary; with `all`, the whole table and every name.
pub fn text(report: &Report, files: &[PathBuf], worse: &[String], all: bool) -> String {
    let mut text = String::new();
    if report.subjects.iter().flat_map(|s| &s.points).any(|p| p.times.is_some()) {
        text += &if all { headline_table(&report.subjects) } else { fastest(report) };
        text += "\n";
    } else if !report.subjects.is_empty() {
        let points: usize = report.subjects.iter().map(|s| s.points.len()).sum();
        text += &format!("errors     {points} pictures of {} subjects, nothing timed\n", report.subjects.len());
    }
    if !report.orders.is_empty() {
        let (all, failing) = (report.orders.len(), report.failing_orders());
        text += &format!("orders     {all} measured, {failing} not as documented\n");
    }
    if !report.stability.is_empty() {
        let (all, failed) = (report.stability.len(), report.failed_cases());
        text += &format!("hard cases {all} pictures, {failed} unexplained failures\n");
    }
    text += &growth(report);
    for line in worse.iter().take(if all { worse.len() } else { MAX_ROWS }) {
        text += &format!("worse      {line}\n");
    }
    if worse.len() > MAX_ROWS && !all {
        text += &format!("worse      {} more; --all lists them\n", worse.len() - MAX_ROWS);
    }
    let names: Vec<String> = files.iter().map(|p| p.display().to_string()).collect();
    let wrote = match &names[..] {
        [page, rest @ ..] if !all && !rest.is_empty() => format!("{page} and {} more; --all lists them", rest.len()),
        names => names.join(", "),
    };
    text + &format!("took       {:.1} s\nwrote      {wrote}\n", report.seconds)
}

/// Returns the fastest setting within two errors, on as many scenes as the table has rows.
fn fastest(report: &Report) -> String {
    let names = COLUMNS.map(|column| format!("fastest for RMSE ≤ {}", vr_study::front::THRESHOLDS[column].1));
    let mut table = Table::of_words(&["scene", &names[0], &names[1]]);
    for subject in report.subjects.iter().take(MAX_ROWS) {
        let reached = reaching(subject);
        let cell = |column: usize| match &reached[column] {
            Some((ms, who)) => format!("{who}, {}", number::time(std::time::Duration::from_secs_f64(ms / 1e3))),
            None => "–".to_owned(),
        };
        table.row([subject.name.clone(), cell(COLUMNS[0]), cell(COLUMNS[1])]);
    }
    let mut text = table.to_string();
    if report.subjects.len() > MAX_ROWS {
        text += &format!("{} more scenes are in the page; --all prints them\n", report.subjects.len() - MAX_ROWS);
    }
    text
}

/// Returns a line for each quantity that grew, with the exponent of each renderer.
fn growth(report: &Report) -> String {
    let mut text = String::new();
    for grown in Grown::ALL {
        let own = report.growth.iter().filter(|growth| growth.grown == grown);
        let exponents: Vec<String> = own
            .map(|g| format!("{} {}", g.renderer, g.exponent.map_or_else(|| "–".to_owned(), |p| format!("{p:.2}"))))
            .collect();
        if !exponents.is_empty() {
            text += &format!("growth     with {}: exponents {}\n", grown.word(), exponents.join(", "));
        }
    }
    text
}
