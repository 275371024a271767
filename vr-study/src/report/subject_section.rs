//! Section of a report about one subject: speed against error, pictures, and the table of its settings.

use maud::{Markup, html};

use crate::error::StudyError;
use crate::error_colors;
use crate::front::{best_within, pareto_front};
use crate::point::Point;
use crate::study::SubjectResult;

use super::figure::{picture, wide};
use super::point_table::{small, table};
use super::{plots, terms};

/// Returns the name of a subject's section within the page.
pub(super) fn anchor(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect()
}

/// Returns the section.
///
/// # Errors
/// A plot that cannot be drawn.
pub(super) fn section(s: &SubjectResult, timed: bool) -> Result<Markup, StudyError> {
    let pairs: Vec<(f64, f64)> = s.points.iter().map(Point::pair).collect();
    let front = pareto_front(&pairs);
    let [w, h] = s.size;
    let all: Vec<usize> = (0..s.points.len()).collect();
    Ok(html! {
        section id=(anchor(&s.name)) {
            h2 { (s.name) }
            p { (s.title) ", " (w) "×" (h) " pixels. " (certainty(s)) }
            @if timed && !s.points.is_empty() {
                (wide(&plots::speed_against_error(s), html! {
                    "Numbers, on a wide screen, are rows of the table below; lines are the " (terms::FRONT.word()) " of each renderer. Further left is faster, further down is nearer to the "
                    (terms::REFERENCE.word()) "."
                })?)
                p { (fastest(s, &pairs)) }
            }
            h3 { "Pictures" }
            @if let Some(note) = &s.note { p.note { (note) } }
            div.pictures {
                @if !s.points.is_empty() { (picture(&s.picture, "Picture of the smallest error, by")) }
                @for map in &s.error_maps { (picture(map, "Error of")) }
            }
            @if !s.error_maps.is_empty() { (scale()) }
            @if timed {
                h3 { "Settings that no other beats" }
                (table(s, &front))
            }
            details open[!timed] {
                summary { "All " (s.points.len()) " settings" }
                (table(s, &all))
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

/// Returns the renderers that are fastest, each for its range of errors.
fn fastest(s: &SubjectResult, pairs: &[(f64, f64)]) -> Markup {
    let winners = best_within(pairs, |i| s.points[i].renderer.clone());
    html! {
        @for (k, r) in winners.iter().enumerate() {
            @if k > 0 { "; " } @else { "Fastest: " }
            b { (s.points[r.fastest].renderer) } " for an " (terms::RMSE.word()) " "
            @match r.to {
                Some(to) => { "from " (small(r.from)) " to " (small(to)) },
                None => { "of " (small(r.from)) " or more" },
            }
        }
        "."
    }
}

/// Returns a sentence on the pixels that were compared, and with what.
fn certainty(s: &SubjectResult) -> Markup {
    let Some(e) = s.points.first().map(|p| &p.error) else { return html! {} };
    let proven = if e.reference_error_is == "bound" { "proven" } else { "estimated" };
    let all = u64::from(s.size[0]) * u64::from(s.size[1]);
    html! {
        "Errors are over " (e.pixels) " of " (all) " pixels, against a " (terms::REFERENCE.word())
        @if let Some(noise) = &e.noise {
            " by random paths, whose noise, RMS " (small(noise.reference_noise)) ", is subtracted from RMSE. Grey in the maps: no more than chance makes."
        } @else {
            " " (proven) " to within " (small(e.reference_error)) "."
        }
        @if (e.pixels as u64) < all { " Maps are interpolated between them." }
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
            div { "Colours of the maps: largest error of a component" }
            div.bar style={ "background:linear-gradient(to right," (stops.join(",")) ")" } {}
            div.ticks { @for k in low..=high { span { "1e" (k) } } }
        }
    }
}
