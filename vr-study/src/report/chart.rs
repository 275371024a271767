//! Chart with logarithmic axes, as an SVG that takes its ink from the page around it.

use std::ops::Range;

use plotters::coord::combinators::LogCoord;
use plotters::prelude::*;

use crate::error::StudyError;

use super::marker::{color, sample, shape};

/// Placeholder of the page's ink until the SVG is done.
const INK: RGBColor = RGBColor(1, 2, 3);
const INK_TEXT: &str = "#010203";

/// Look of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Look {
    /// Single points.
    Points,
    /// Points joined by a line.
    Line,
    /// Thin line alone: what is expected, not measured.
    Guide,
}

/// Series of points of a chart.
pub(super) struct Series {
    /// Name in the legend; empty if it is not listed.
    pub(super) name: String,
    /// Points of the series; those that are not positive and finite have no place on such axes.
    pub(super) points: Vec<(f64, f64)>,
    /// Words beside the points; may be fewer.
    pub(super) labels: Vec<String>,
    /// Number of its colour and of its marker: up to six, the marker alone tells series apart, too.
    pub(super) color: usize,
    /// Look of the series.
    pub(super) look: Look,
}

/// Size of a chart and of its letters, for the place where it stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Format {
    /// Width and height in pixels; a page may make it smaller, by a tenth at most where letters are to stay legible.
    size: (u32, u32),
    /// Height of numbers and words along the axes, of which an SVG has four fifths as the size of its letters: 15 is 12 px.
    text: i32,
    /// Height of words beside points and levels.
    small: i32,
    /// Largest number of numbers along each axis.
    numbers: usize,
    /// Room for the numbers and the name of the vertical axis.
    left: u32,
    /// True if there is room for words beside points.
    labels: bool,
}

impl Format {
    /// Whole width of a page on a desk.
    pub(super) const WIDE: Self = Self { size: (860, 440), text: 15, small: 14, numbers: 10, left: 70, labels: true };
    /// Width of a telephone, and of one of several charts side by side.
    pub(super) const NARROW: Self = Self { size: (380, 340), text: 15, small: 15, numbers: 5, left: 66, labels: false };
}

/// Chart with logarithmic axes.
pub(super) struct Chart {
    pub(super) title: &'static str,
    pub(super) x: &'static str,
    pub(super) y: &'static str,
    pub(super) series: Vec<Series>,
    /// Horizontal lines with their names.
    pub(super) levels: &'static [(f64, &'static str)],
}

fn plottable(&(x, y): &(f64, f64)) -> bool {
    x > 0.0 && y > 0.0 && x.is_finite() && y.is_finite()
}

impl Chart {
    /// Returns the SVG, to stand within a page that tells title and legend: text and axes are drawn in the page's `currentColor`.
    pub(super) fn svg(&self, format: Format) -> Result<String, StudyError> {
        Ok(self.drawn(format, false)?.replace(INK_TEXT, "currentColor"))
    }

    /// Returns the SVG as a file of its own, with title and legend: dark ink on white.
    pub(super) fn standalone_svg(&self) -> Result<String, StudyError> {
        let svg = self.drawn(Format::WIDE, true)?.replace(INK_TEXT, "#24292f");
        let (w, h) = Format::WIDE.size;
        // Behind everything: right after the opening tag.
        let paper = format!("<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>");
        let open = svg.find("<svg").and_then(|start| svg[start..].find('>').map(|end| start + end + 1)).unwrap_or(0);
        Ok(format!("{}{paper}{}", &svg[..open], &svg[open..]))
    }

    /// Returns the smallest ranges around all points, with a margin.
    fn ranges(&self) -> (Range<f64>, Range<f64>) {
        let points = || self.series.iter().flat_map(|s| s.points.iter().copied().filter(plottable));
        let around = |values: &mut dyn Iterator<Item = f64>| {
            let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(low, high), x| (low.min(x), high.max(x)));
            if low > high {
                return 0.1..10.0;
            }
            // A fifteenth of the decades that are there, at least a sixth of one.
            let more = 10f64.powf((libm::log10(high / low) / 15.0).max(0.16));
            low / more..high * more
        };
        (around(&mut points().map(|p| p.0)), around(&mut points().map(|p| p.1)))
    }

    /// Returns the corner with the fewest points, for the legend.
    fn emptiest_corner(&self) -> SeriesLabelPosition {
        let (x, y) = self.ranges();
        // Where on an axis a point lies, from 0 to 1.
        let share = |v: f64, r: &Range<f64>| libm::log(v / r.start) / libm::log(r.end / r.start);
        let crowd = |right: bool, upper: bool| {
            let inside = |&&(px, py): &&(f64, f64)| {
                let (h, v) = (share(px, &x), share(py, &y));
                (if right { h > 0.55 } else { h < 0.45 }) && (if upper { v > 0.65 } else { v < 0.35 })
            };
            self.series.iter().flat_map(|s| &s.points).filter(|&p| plottable(p)).filter(inside).count()
        };
        let corners = [
            (SeriesLabelPosition::UpperRight, crowd(true, true)),
            (SeriesLabelPosition::LowerLeft, crowd(false, false)),
            (SeriesLabelPosition::LowerRight, crowd(true, false)),
            (SeriesLabelPosition::UpperLeft, crowd(false, true)),
        ];
        corners.into_iter().min_by_key(|c| c.1).expect("four corners").0
    }

    fn drawn(&self, format: Format, alone: bool) -> Result<String, StudyError> {
        let mut svg = String::new();
        self.draw(&mut svg, format, alone).map_err(|e| StudyError::Plot(e.to_string()))?;
        Ok(svg)
    }

    fn draw(&self, svg: &mut String, format: Format, alone: bool) -> Result<(), Box<dyn std::error::Error>> {
        let Format { size, text: height, small, numbers, left, labels } = format;
        let root = SVGBackend::with_string(svg, size).into_drawing_area();
        let text = |size: i32| TextStyle::from(("sans-serif", size).into_font()).color(&INK);
        let (x, y) = self.ranges();
        let mut builder = ChartBuilder::on(&root);
        if alone {
            builder.caption(self.title, text(15));
        }
        let mut chart = builder
            .margin(8)
            .x_label_area_size(46)
            .y_label_area_size(left)
            .build_cartesian_2d(x.clone().log_scale(), y.clone().log_scale())?;
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .x_label_formatter(&|v| number(*v))
            .y_label_formatter(&|v| number(*v))
            .x_labels(numbers)
            .y_labels(numbers)
            .label_style(text(height))
            .axis_desc_style(text(height))
            .axis_style(INK.mix(0.6))
            .bold_line_style(INK.mix(0.16))
            .light_line_style(INK.mix(0.05))
            .draw()?;
        let pixels_apart = |a: f64, b: f64| f64::from(size.1) * libm::log(a / b) / libm::log(y.end / y.start);
        let mut named = f64::INFINITY;
        for &(level, name) in self.levels.iter().filter(|(level, _)| y.contains(level)) {
            let line = [(x.start, level), (x.end, level)];
            chart.draw_series(DashedLineSeries::new(line, 5, 4, INK.mix(0.45).into()))?;
            // A name needs room below the one above it.
            if pixels_apart(named, level) > 1.3 * f64::from(small) {
                chart.draw_series([Text::new(name.to_owned(), (x.end, level), right_above(&text(small)))])?;
                named = level;
            }
        }
        for series in &self.series {
            draw_series(&mut chart, series, labels.then(|| text(small)))?;
        }
        if alone && self.series.iter().any(|s| !s.name.is_empty()) {
            chart
                .configure_series_labels()
                .position(self.emptiest_corner())
                .label_font(text(12))
                .border_style(INK.mix(0.25))
                .margin(6)
                .draw()?;
        }
        drop(chart);
        root.present()?;
        Ok(())
    }
}

fn right_above<'a>(style: &TextStyle<'a>) -> TextStyle<'a> {
    use plotters::style::text_anchor::{HPos, Pos, VPos};
    style.pos(Pos::new(HPos::Right, VPos::Bottom))
}

type LogLog<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<LogCoord<f64>, LogCoord<f64>>>;

fn draw_series<'b>(chart: &mut LogLog<'b, 'b>, series: &Series, label: Option<TextStyle<'_>>) -> Result<(), String> {
    let color = color(series.color);
    let points: Vec<(f64, f64)> = series.points.iter().copied().filter(plottable).collect();
    match series.look {
        Look::Points => {}
        Look::Line => {
            let line = LineSeries::new(points.iter().copied(), color.stroke_width(2));
            chart.draw_series(line).map_err(|e| e.to_string())?;
        }
        Look::Guide => {
            let thin = color.mix(0.55).stroke_width(1);
            return chart.draw_series(LineSeries::new(points, thin)).map(drop).map_err(|e| e.to_string());
        }
    }
    let (number, look) = (series.color, series.look);
    let marked = points.iter().map(|&p| EmptyElement::at(p) + shape((0, 0), number));
    let drawn = chart.draw_series(marked).map_err(|e| e.to_string())?;
    if !series.name.is_empty() {
        drawn.label(series.name.clone()).legend(move |at| sample(at, number, look));
    }
    let Some(label) = label else { return Ok(()) };
    let labelled = series.points.iter().zip(&series.labels).filter(|(p, _)| plottable(p));
    chart
        .draw_series(labelled.map(|(&p, word)| EmptyElement::at(p) + Text::new(word.clone(), (6, -12), label.clone())))
        .map_err(|e| e.to_string())?;
    Ok(())
}

/// Formats a number as short as it can be: `0.001`, `1`, `250`, `1e-6`.
fn number(x: f64) -> String {
    if (1e-3..1e5).contains(&x) {
        let text = format!("{x:.4}");
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    format!("{x:.0e}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<(f64, f64)>) -> String {
        let series =
            vec![Series { name: "one".to_owned(), points, labels: vec!["7".to_owned()], color: 0, look: Look::Line }];
        let chart = Chart { title: "t", x: "ms", y: "RMSE", series, levels: &[(1e-3, "a thousandth")] };
        assert!(chart.standalone_svg().unwrap().contains(">\none\n"), "the legend");
        chart.svg(Format::NARROW).unwrap()
    }

    #[test]
    fn charts_are_svgs_in_the_ink_of_the_page() {
        let svg = chart(vec![(1.0, 1e-2), (10.0, 1e-4), (f64::NAN, 1.0), (3.0, 0.0)]);
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"), "{svg}");
        assert!(svg.contains("currentColor") && !svg.contains(INK_TEXT));
        assert!(svg.contains("a thousandth") && svg.contains("RMSE") && svg.contains("#0072B2"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn nothing_to_draw_is_an_empty_chart() {
        assert!(chart(Vec::new()).contains("<svg"));
        assert!(chart(vec![(f64::NAN, f64::INFINITY)]).contains("<svg"));
    }

    #[test]
    fn numbers_are_short() {
        for (x, text) in [(0.001, "0.001"), (1.0, "1"), (250.0, "250"), (1e-6, "1e-6"), (0.25, "0.25"), (1e6, "1e6")] {
            assert_eq!(number(x), text);
        }
    }
}
