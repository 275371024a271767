//! Drawing of a two-dimensional transfer function: its colours over the plane of value and gradient magnitude, upon the joint histogram of a volume.

use vr_core::{Frame, TransferFunction};

use crate::canvas::Canvas;
use crate::joint_histogram::JointHistogram;
use crate::tf_picture::{GRID, INK, PAPER, TEXT, shown_range};
use crate::{number, text};

/// Size of the picture.
const SIZE: [u32; 2] = [800, 520];
/// Left, upper, right and lower margin.
const MARGIN: [u32; 4] = [90, 34, 24, 56];
/// Brightness of the fullest bin of the histogram.
const FULLEST: f32 = 0.55;
/// Line at the magnitude of a row.
const ROW: [f32; 3] = [0.35, 0.35, 0.38];

/// Draws a transfer function with rows over the values and magnitudes of its rows, and those of the histogram.
///
/// Each pixel has the colour of the medium there, as dense over the histogram as the medium's opacity of a unit distance; the histogram is grey by the
/// logarithm of its counts. Fine lines mark the rows.
pub fn draw(transfer: &TransferFunction, histogram: Option<&JointHistogram>) -> Frame {
    let mut canvas = Canvas::new(SIZE, PAPER);
    let [left, top, right, bottom] = MARGIN;
    let (width, height) = (SIZE[0] - left - right, SIZE[1] - top - bottom);
    let (low, high) = shown_range(transfer, histogram.map(|h| h.range));
    let steepest = shown_magnitude(transfer, histogram);
    let value = |x: u32| low + (high - low) * (f64::from(x) + 0.5) / f64::from(width);
    let magnitude = |y: u32| steepest * (1.0 - (f64::from(y) + 0.5) / f64::from(height));
    let row_of = |magnitude: f64| top + ((1.0 - magnitude / steepest) * f64::from(height)).round() as u32;

    // The histogram, and the medium upon it.
    let largest = histogram.map_or(0, JointHistogram::largest).max(1) as f64;
    for y in 0..height {
        for x in 0..width {
            let count = histogram.map_or(0, |h| h.count(value(x), magnitude(y)));
            let grey = ((count as f64).ln_1p() / largest.ln_1p()) as f32 * FULLEST;
            let (color, opacity) = shown(transfer, value(x), magnitude(y));
            let mixed = std::array::from_fn(|c| PAPER[c].max(grey * grey) * (1.0 - opacity) + color[c] * opacity);
            canvas.put([left + x, top + y], mixed);
        }
    }
    // A line at each row, over what is not covered alone: every fourth pixel.
    for row in transfer.rows().iter().filter(|row| row.gradient <= steepest) {
        let y = row_of(row.gradient).min(top + height - 1);
        (0..width).step_by(4).for_each(|x| canvas.put([left + x, y], ROW));
    }
    // Numbers along both axes, and their names.
    for k in 0..=4u32 {
        let place = f64::from(k) / 4.0;
        let x = left + (place * f64::from(width)).round() as u32;
        canvas.fill([x, top + height], [1, 6], INK);
        let label = number::value(low + place * (high - low));
        let half = 0.5 * text::width(&label, TEXT);
        let at = (x as f32 - half).clamp(0.0, SIZE[0] as f32 - 2.0 * half);
        text::draw(&mut canvas, &label, [at, (top + height + 9) as f32], TEXT, INK);
        let y = row_of(place * steepest);
        canvas.fill([left - 6, y.min(top + height - 1)], [6, 1], INK);
        let label = number::value(place * steepest);
        let x = left as f32 - 12.0 - text::width(&label, TEXT);
        text::draw(&mut canvas, &label, [x.max(0.0), y as f32 - 0.5 * TEXT], TEXT, INK);
    }
    canvas.fill([left, top + height], [width, 1], GRID);
    text::draw(&mut canvas, "gradient", [8.0, 6.0], TEXT, INK);
    let at = left as f32 + 0.5 * (width as f32 - text::width("value", TEXT));
    text::draw(&mut canvas, "value", [at, (SIZE[1] - 26) as f32], TEXT, INK);
    canvas.into_frame()
}

/// Colour of the medium at a place of the plane, and how dense it is drawn: the opacity of a unit distance, or that it emits at all.
fn shown(transfer: &TransferFunction, value: f64, magnitude: f64) -> ([f32; 3], f32) {
    let medium = transfer.mixture(value, magnitude);
    let [r, g, b, alpha] = medium.step(transfer.unit_distance());
    let strength = if transfer.has_emission() { r.max(g).max(b) } else { alpha };
    let color = [r, g, b].map(|c| if strength > 0.0 { (c / strength).min(1.0) as f32 } else { 0.0 });
    // Faint media are seen, and dense ones are told apart.
    (color, strength.clamp(0.0, 1.0).sqrt() as f32)
}

/// Magnitude at the upper end: a little beyond the last row, or of the histogram if that reaches further, though not far beyond.
fn shown_magnitude(transfer: &TransferFunction, histogram: Option<&JointHistogram>) -> f64 {
    let last = transfer.rows().last().map_or(0.0, |row| row.gradient);
    let found = histogram.map_or(0.0, |h| h.steepest);
    let steepest = if last > 0.0 { (1.1 * last).max(found.min(4.0 * last)) } else { found };
    if steepest > 0.0 { steepest } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{ControlPoint, OpacityRule};

    /// Clear where nothing changes, red from a magnitude of 4 on.
    fn boundaries() -> TransferFunction {
        let row = |gradient, opacity| (gradient, vec![ControlPoint::new(0.0, [1.0, 0.0, 0.0], opacity)]);
        TransferFunction::of_rows(vec![row(2.0, 0.0), row(4.0, 0.99)], OpacityRule::Power, 1.0).unwrap()
    }

    #[test]
    fn steep_places_have_the_color_and_flat_ones_the_paper() {
        let frame = draw(&boundaries(), None);
        assert_eq!(frame.size(), SIZE);
        let [left, top, _, bottom] = MARGIN;
        let [r, g, ..] = frame.pixel(left + 101, top + 5);
        assert!(r > 0.9 && g < 0.05, "{r} {g}");
        let [r, g, ..] = frame.pixel(left + 101, SIZE[1] - bottom - 5);
        assert!((r - PAPER[0]).abs() < 1e-6 && (g - PAPER[1]).abs() < 1e-6, "{r} {g}");
    }
}
