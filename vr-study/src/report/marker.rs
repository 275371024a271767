//! Markers of the series of a chart: told apart by colour and by shape.

use plotters::element::{ComposedElement, DynElement, IntoDynElement};
use plotters::prelude::*;

use crate::error::StudyError;

use super::chart::Look;

/// Colours that people with any kind of colour vision tell apart, on light and on dark (Okabe and Ito 2008, "Color universal design").
const COLORS: [RGBColor; 6] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
];
/// Length of the line of a sample in a legend.
const SAMPLE: i32 = 18;
/// Width and height of a sample for a page, in CSS pixels.
const SWATCH: (u32, u32) = (26, 14);

/// Returns the colour of a series.
pub(super) fn color(series: usize) -> RGBColor {
    COLORS[series % COLORS.len()]
}

/// Returns the marker of a series around a pixel: disc, triangle, cross, square, ring or diamond.
pub(super) fn shape<DB: DrawingBackend>((x, y): (i32, i32), series: usize) -> DynElement<'static, DB, (i32, i32)> {
    let color = color(series);
    let (filled, stroke) = (color.filled(), color.stroke_width(2));
    match series % 6 {
        0 => Circle::new((x, y), 4, filled).into_dyn(),
        1 => TriangleMarker::new((x, y), 5, filled).into_dyn(),
        2 => Cross::new((x, y), 4, stroke).into_dyn(),
        3 => Rectangle::new([(x - 4, y - 4), (x + 4, y + 4)], filled).into_dyn(),
        4 => Circle::new((x, y), 4, stroke).into_dyn(),
        _ => Polygon::new([(0, -6), (5, 0), (0, 6), (-5, 0)].map(|(dx, dy)| (x + dx, y + dy)), filled).into_dyn(),
    }
}

/// Sample of a series in a legend.
type Sample<DB> = ComposedElement<(i32, i32), DB, PathElement<(i32, i32)>, DynElement<'static, DB, (i32, i32)>>;

/// Returns the sample of a series in a legend, which begins at a pixel: its marker, on a piece of its line.
pub(super) fn sample<DB: DrawingBackend>(corner: (i32, i32), series: usize, look: Look) -> Sample<DB> {
    let width = if look == Look::Line { 2 } else { 0 };
    let line = PathElement::new([(0, 0), (SAMPLE, 0)], color(series).stroke_width(width));
    EmptyElement::at(corner) + line + shape((SAMPLE / 2, 0), series)
}

/// Returns the sample of a series as an SVG within a page.
///
/// # Errors
/// A plot that cannot be drawn.
pub(super) fn swatch(series: usize, look: Look) -> Result<String, StudyError> {
    let mut svg = String::new();
    let (width, height) = SWATCH;
    let corner = ((width as i32 - SAMPLE) / 2, height as i32 / 2);
    let root = SVGBackend::with_string(&mut svg, SWATCH).into_drawing_area();
    let drawn = root.draw(&sample(corner, series, look)).and_then(|()| root.present());
    drop(root);
    drawn.map_err(|e| StudyError::Plot(e.to_string()))?;
    Ok(svg)
}
