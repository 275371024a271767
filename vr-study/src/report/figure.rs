//! Figures of a page: a chart with its legend, a picture with the command that makes it.

use maud::{Markup, PreEscaped, html};

use crate::error::StudyError;
use crate::study::Picture;

use super::chart::{Chart, Format, Look};
use super::marker::swatch;

/// Returns a chart over the whole width of a page, in two forms of which the page shows the one that fits.
///
/// # Errors
/// A plot that cannot be drawn.
pub(super) fn wide(chart: &Chart, caption: Markup) -> Result<Markup, StudyError> {
    figure(chart, &[("plot broad", Format::WIDE), ("plot slim", Format::NARROW)], caption)
}

/// Returns a chart that stands beside others.
///
/// # Errors
/// A plot that cannot be drawn.
pub(super) fn narrow(chart: &Chart, caption: Markup) -> Result<Markup, StudyError> {
    figure(chart, &[("plot", Format::NARROW)], caption)
}

fn figure(chart: &Chart, forms: &[(&str, Format)], caption: Markup) -> Result<Markup, StudyError> {
    let forms: Vec<(&str, String)> =
        forms.iter().map(|&(class, format)| Ok((class, chart.svg(format)?))).collect::<Result<_, StudyError>>()?;
    let legend: Vec<(&str, String)> = chart
        .series
        .iter()
        .filter(|series| !series.name.is_empty() && series.look != Look::Guide)
        .map(|series| Ok((series.name.as_str(), swatch(series.color, series.look)?)))
        .collect::<Result<_, StudyError>>()?;
    Ok(html! {
        figure {
            figcaption.title { (chart.title) }
            @for (class, svg) in forms {
                div class=(class) role="img" aria-label={ (chart.title) ": " (chart.y) " over " (chart.x) } { (PreEscaped(svg)) }
            }
            ul.legend { @for (name, sample) in legend { li { (PreEscaped(sample)) (name) } } }
            figcaption { (caption) }
        }
    })
}

/// Returns a picture with a line on what it shows, and the command that makes it.
pub(super) fn picture(picture: &Picture, words: &str) -> Markup {
    html! {
        figure.picture {
            img src={ "data:image/png;base64," (picture.png) } alt={ (words) " " (picture.candidate) };
            figcaption { (words) " " b { (picture.candidate) } }
            @if let Some(line) = &picture.command { (command(line)) }
        }
    }
}

/// Returns a command as a block, all of which one click selects; lines break between flags.
pub(super) fn command(line: &str) -> Markup {
    let flags = line.match_indices(" -").map(|(at, _)| at);
    let starts: Vec<usize> = std::iter::once(0).chain(flags).collect();
    let ends = starts.iter().skip(1).copied().chain([line.len()]);
    html! {
        pre.command {
            code { @for (k, (&start, end)) in starts.iter().zip(ends).enumerate() { @if k > 0 { " " } span { (line[start..end].trim_start()) } } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_whole_and_in_parts() {
        let block = command("vr render a-b.nrrd --size 8x8 -o 'x - y.png'").into_string();
        let parts =
            ["vr render a-b.nrrd", "--size 8x8", "-o 'x", "- y.png'"].map(|part| format!("<span>{part}</span>"));
        assert!(block.contains(&format!("<code>{}</code>", parts.join(" "))), "{block}");
    }
}
