//! Page of a report: one file that needs nothing else.

use maud::{DOCTYPE, Markup, PreEscaped, html};
use time::OffsetDateTime;

use crate::convergence::{Convergence, Outcome, Refined};
use crate::error::StudyError;
use crate::error_colors;
use crate::figures::ErrorFigures;
use crate::front::{THRESHOLDS, best_within, pareto_front};
use crate::machine::Machine;
use crate::point::Point;
use crate::scaling::Grown;
use crate::stability::{CaseResult, Verdict};
use crate::study::{Picture, SubjectResult};
use crate::suite::Report;

use super::headline::{inline_plot, milliseconds, reaching};
use super::plots;

const STYLE: &str = include_str!("style.css");

/// Returns a report as an HTML page with everything in it: plots, pictures, tables.
///
/// # Errors
/// A plot that cannot be drawn.
pub fn page(report: &Report) -> Result<String, StudyError> {
    let day = OffsetDateTime::now_utc().date().to_string();
    let title = format!("vr report, {}", report.suite.name());
    let timed = report.subjects.iter().flat_map(|s| &s.points).any(|p| p.times.is_some());
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "Speed against error" }
                p.lead { "Suite " b { (report.suite.name()) } ", " (day) ", " (format!("{:.0}", report.seconds)) " s." }
                (machine(&report.machine))
                @if !report.subjects.is_empty() {
                    (summary(&report.subjects, timed)?)
                    @for subject in &report.subjects { (subject_section(subject, timed)?) }
                }
                @if !report.orders.is_empty() { (orders(&report.orders)?) }
                @if !report.stability.is_empty() { (stability(&report.stability, report.failed_cases())) }
                @if !report.growth.is_empty() {
                    section {
                        h2 { "Growth" }
                        p { "Each renderer at its defaults, on the phantom blobs. An exponent p says that time grows like the p-th power." }
                        div.row {
                            @for grown in Grown::ALL { figure { (PreEscaped(plots::growth(&report.growth, grown)?)) } }
                        }
                    }
                }
                (how())
            }
        }
    };
    Ok(markup.into_string())
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

fn summary(subjects: &[SubjectResult], timed: bool) -> Result<Markup, StudyError> {
    Ok(html! {
        section {
            h2 { "Time to reach an error" }
            @if timed {
                figure { (PreEscaped(inline_plot(subjects)?)) }
                div.wide {
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
            } @else {
                p { "Nothing was timed." }
            }
        }
    })
}

fn anchor(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect()
}

fn subject_section(s: &SubjectResult, timed: bool) -> Result<Markup, StudyError> {
    let pairs: Vec<(f64, f64)> = s.points.iter().map(Point::pair).collect();
    let front = pareto_front(&pairs);
    let [w, h] = s.size;
    let winners = best_within(&pairs, |i| s.points[i].renderer.clone());
    Ok(html! {
        section id=(anchor(&s.name)) {
            h2 { (s.name) }
            p { (s.title) ", " (w) "×" (h) " pixels. " (certainty(s)) }
            @if timed && !s.points.is_empty() {
                figure { (PreEscaped(plots::speed_against_error(s)?)) figcaption { "Numbers are rows of the table." } }
                p {
                    @for (k, r) in winners.iter().enumerate() {
                        @if k > 0 { "; " } @else { "Who is fastest: " }
                        b { (s.points[r.fastest].renderer) } " for an RMSE "
                        @match r.to {
                            Some(to) => { "from " (small(r.from)) " to " (small(to)) },
                            None => { "of " (small(r.from)) " or more" },
                        }
                    }
                    "."
                }
            }
            div.row {
                @if !s.points.is_empty() { (picture(&s.picture, "picture")) }
                @for map in &s.error_maps { (picture(map, "error of")) }
            }
            @if !s.error_maps.is_empty() { (scale()) }
            @if timed { div.wide { (points(s, &front)) } }
            details open[!timed] {
                summary { "All " (s.points.len()) " settings" }
                div.wide { (points(s, &(0..s.points.len()).collect::<Vec<_>>())) }
            }
            @if !s.refusals.is_empty() {
                details {
                    summary { (s.refusals.len()) " that cannot draw it" }
                    ul { @for r in &s.refusals { li { (r.candidate) ": " (r.feature) } } }
                }
            }
        }
    })
}

fn certainty(s: &SubjectResult) -> String {
    s.points.first().map_or_else(String::new, |p| {
        let e = &p.error;
        let proven = if e.reference_error_is == "bound" { "proven" } else { "estimated" };
        let all = u64::from(s.size[0]) * u64::from(s.size[1]);
        let between = if (e.pixels as u64) < all { " Maps are interpolated between them." } else { "" };
        format!(
            "Errors are over {} of {all} pixels, against a reference {proven} to within {}.{between}",
            e.pixels,
            small(e.reference_error)
        )
    })
}

fn picture(p: &Picture, what: &str) -> Markup {
    html! {
        figure.picture {
            img src={ "data:image/png;base64," (p.png) } alt={ (what) " " (p.candidate) };
            figcaption { @if what == "picture" { (p.candidate) } @else { (what) " " (p.candidate) } }
        }
    }
}

/// Returns the bar of the colours of error maps.
fn scale() -> Markup {
    let (low, high) = error_colors::DECADES;
    let stop = |k: i32| {
        let place = f64::from(k - low) / f64::from(high - low);
        let byte = |x: f32| (vr_core::transfer::linear_to_srgb(f64::from(x)) * 255.0).round() as u8;
        let [r, g, b] = error_colors::at(place).map(byte);
        format!("rgb({r},{g},{b}) {:.1}%", 100.0 * place)
    };
    let stops: Vec<String> = (low..=high).map(stop).collect();
    html! {
        div.scale {
            div.bar style={ "background:linear-gradient(to right," (stops.join(",")) ")" } {}
            div.ticks { @for k in low..=high { span { "1e" (k) } } }
        }
    }
}

fn points(s: &SubjectResult, which: &[usize]) -> Markup {
    html! {
        table {
            thead {
                tr {
                    th { "#" } th { "renderer and setting" } th { "ms a frame" } th { "min … max" } th { "prepare ms" } th { "memory" }
                    th { "samples" } th { "RMSE" } th { "max" } th { "bias" } th { "99 %" } th { "own model" } th { "function" }
                }
            }
            tbody {
                @for &i in which {
                    @let p = &s.points[i];
                    tr {
                        td { (i + 1) }
                        td.left title=(options(p)) { (p.candidate()) }
                        @match p.times {
                            Some(t) => {
                                td { (milliseconds(t.frame.median)) }
                                td { (milliseconds(t.frame.min)) " … " (milliseconds(t.frame.max)) }
                                td { (milliseconds(t.prepare.median)) }
                            },
                            None => { td { "–" } td { "–" } td { "–" } },
                        }
                        td { (p.peak_bytes.map_or_else(|| "–".to_owned(), bytes)) }
                        td { (p.counts.get("samples").copied().unwrap_or(0)) }
                        td { (small(p.error.rmse)) }
                        td { (small(p.error.max)) }
                        td { (small(p.error.bias)) }
                        td { (small(p.error.p99)) }
                        td { (p.own_error.as_ref().map_or_else(|| "–".to_owned(), |e| small(e.rmse))) }
                        td { (p.function_error.as_ref().map_or_else(|| "–".to_owned(), |e| small(e.rmse))) }
                    }
                }
            }
        }
    }
}

fn options(p: &Point) -> String {
    p.options.0.iter().map(|(k, v)| format!("{k}={v}")).collect::<Vec<_>>().join(" ")
}

fn small(x: f64) -> String {
    if x == 0.0 { "0".to_owned() } else { format!("{x:.2e}") }
}

fn bytes(n: u64) -> String {
    match n {
        0..1_000_000 => format!("{:.0} kB", n as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", n as f64 / 1e6),
        _ => format!("{:.2} GB", n as f64 / 1e9),
    }
}

fn orders(results: &[Convergence]) -> Result<Markup, StudyError> {
    let mut renderers: Vec<&str> = results.iter().map(|c| c.renderer.as_str()).collect();
    renderers.dedup();
    let class = |c: &Convergence| match c.outcome() {
        Outcome::Holds | Outcome::Exact => "good",
        Outcome::Refused | Outcome::Empty => "plain",
        Outcome::Fails => "bad",
    };
    Ok(html! {
        section {
            h2 { "Orders of convergence" }
            p { "One thing is refined at a time, on a smooth field; thin lines have the documented slope. Legends tell the measured order, and the documented one." }
            @for renderer in renderers {
                @let own: Vec<&Convergence> = results.iter().filter(|c| c.renderer == renderer).collect();
                h3 { (renderer) }
                div.row {
                    @for refined in [Refined::Step, Refined::StepAtJumps, Refined::Grid, Refined::Pixels] {
                        @if own.iter().any(|c| c.refined == refined) {
                            figure { (PreEscaped(plots::orders(&own, refined)?)) }
                        }
                    }
                }
                div.wide {
                    table {
                        thead { tr { th { "claim" } th { "refined" } th { "documented" } th { "measured" } th { "may differ by" } th { "errors, coarse to fine" } th { "verdict" } } }
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
    })
}

fn stability(results: &[CaseResult], failures: usize) -> Markup {
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
    let class = |v: &Verdict| match v {
        Verdict::Held => "good",
        Verdict::Failed { .. } => "bad",
        _ => "plain",
    };
    html! {
        section {
            h2 { "Hard cases" }
            p {
                @if failures == 0 { "No unexplained failure." } @else { b.bad { (failures) " unexplained failures." } }
                " In each cell: largest error (or RMSE, where the bound is one of that), documented bound, verdict."
            }
            div.wide {
                table {
                    thead { tr { th { "case" } @for c in &candidates { th { (c) } } } }
                    tbody {
                        @for (case, summary) in &cases {
                            tr {
                                th title=(summary) { (case) }
                                @for candidate in &candidates {
                                    @match results.iter().find(|r| r.case == *case && r.candidate == *candidate) {
                                        Some(r) => td class=(class(&r.verdict)) {
                                            @let error = |e: &ErrorFigures| if r.bound_of_rmse { e.rmse } else { e.max };
                                            (r.error.as_ref().map_or_else(|| "–".to_owned(), |e| format!("{:.1e}", error(e))))
                                            " / " (r.bound.map_or_else(|| "–".to_owned(), |b| format!("{b:.1e}")))
                                            @if r.bound_of_rmse { " RMSE" }
                                            br; (r.verdict.word())
                                            @if let Verdict::Failed { reason } = &r.verdict { ": " (reason) }
                                        },
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

fn how() -> Markup {
    html! {
        section {
            h2 { "How this was measured" }
            ul {
                li { "Errors are frame − exact pixel, over red, green, blue and opacity of premultiplied linear light, divided by max(1, the largest magnitude of the picture). 1/255 ≈ 0.0039 is what 8 bits can show." }
                li { "The reference integrates the equation of transfer in f64 with a bound on its own error. " b { "own model" } ": RMSE against what the renderer itself integrates, another reconstruction filter say, done exactly. " b { "function" } ": against the phantom as the function that it is, without samples." }
                li { "Times are of frames after preparation. In each round every candidate prepares a copy of the scene, and draws two views of a turning camera in turns after a frame that counts nowhere; the shortest time of each view counts, and the mean of the two; of frames that take 40 ms or more, one is drawn each round, the first after preparation. Given is the median of the rounds, and the shortest and longest, corrected for how fast the machine was at the moment: a small computation, always the same, is timed before and after. Candidates take turns, so that a machine that slows down slows all." }
                li { "Memory is what preparation and frames need at once beyond the scene." }
            }
        }
    }
}
