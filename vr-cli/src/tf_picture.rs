//! Drawing of a transfer function: its opacity in its colours, over the histogram of a volume, above a band of the colours.

use vr_core::{Frame, TransferFunction};
use vr_look::Histogram;

use crate::canvas::Canvas;
use crate::{number, text};

/// Size of the picture.
const SIZE: [u32; 2] = [800, 420];
/// Left, upper, right and lower margin.
const MARGIN: [u32; 4] = [70, 24, 24, 40];
/// Height of the band of colours.
const BAND: u32 = 28;
/// Gap between the curve and the band.
const GAP: u32 = 8;
/// Height of a line of text.
pub const TEXT: f32 = 16.0;

/// Colour of the paper.
pub const PAPER: [f32; 3] = [0.02, 0.02, 0.025];
/// Colour of lines behind.
pub const GRID: [f32; 3] = [0.10, 0.10, 0.11];
const BARS: [f32; 3] = [0.16, 0.17, 0.19];
const CURVE: [f32; 3] = [0.95; 3];
/// Colour of numbers.
pub const INK: [f32; 3] = [0.7; 3];

/// Draws a transfer function over the values of its points, and those of the histogram.
pub fn draw(transfer: &TransferFunction, histogram: Option<&Histogram>) -> Frame {
    let mut canvas = Canvas::new(SIZE, PAPER);
    let [left, top, right, bottom] = MARGIN;
    let width = SIZE[0] - left - right;
    let floor = SIZE[1] - bottom - BAND - GAP;
    let height = floor - top;
    let (low, high) = shown_range(transfer, histogram.map(|h| h.range));
    let value = |x: u32| low + (high - low) * (f64::from(x) + 0.5) / f64::from(width);
    let max_opacity = transfer.points().iter().map(|p| p.opacity).fold(0.0, f64::max);
    let full = axis_end(max_opacity);
    let level = |opacity: f64| (opacity / full * f64::from(height)).round() as u32;

    // Lines at quarters of the opacity, with their numbers.
    for k in 0..=4 {
        let opacity = 0.25 * f64::from(k) * full;
        let y = floor - level(opacity);
        canvas.fill([left, y], [width, 1], GRID);
        let text = number::value(opacity);
        let x = left as f32 - 8.0 - text::width(&text, TEXT);
        text::draw(&mut canvas, &text, [x.max(0.0), y as f32 - 0.5 * TEXT], TEXT, INK);
    }
    // The histogram, by the logarithm of its counts.
    if let Some(histogram) = histogram {
        let (first, last) = histogram.range;
        let largest = histogram.counts.iter().copied().max().unwrap_or(1).max(1) as f64;
        let bins = histogram.counts.len();
        for x in 0..width {
            let place = (value(x) - first) / (last - first).max(f64::MIN_POSITIVE) * bins as f64;
            if (0.0..bins as f64).contains(&place) {
                let count = histogram.counts[place as usize] as f64;
                let bar = (count.ln_1p() / largest.ln_1p() * f64::from(height)).round() as u32;
                canvas.fill([left + x, floor - bar], [1, bar], BARS);
            }
        }
    }
    // The colours under the curve, the band, and the curve itself, joined where it is steep.
    let mut before = None;
    for x in 0..width {
        let at = transfer.at(value(x));
        let color = at.color.map(|c| c.min(1.0) as f32);
        let top_of_curve = floor - level(at.opacity);
        for y in top_of_curve..floor {
            // Every other pixel: the histogram is seen between.
            if (x + y) % 2 == 0 {
                canvas.put([left + x, y], color);
            }
        }
        canvas.fill([left + x, floor + GAP], [1, BAND], color);
        let last: u32 = before.unwrap_or(top_of_curve);
        let (upper, lower) = (last.min(top_of_curve), last.max(top_of_curve));
        canvas.fill([left + x, upper.saturating_sub(1)], [1, lower - upper + 2], CURVE);
        before = Some(top_of_curve);
    }
    // Points, and values along the axis.
    for p in transfer.points() {
        let x = left + ((p.value - low) / (high - low) * f64::from(width)).round() as u32;
        canvas.fill([x.saturating_sub(2), (floor - level(p.opacity)).saturating_sub(2)], [5, 5], CURVE);
    }
    for k in 0..=4u32 {
        let place = f64::from(k) / 4.0;
        let x = left + (place * f64::from(width)).round() as u32;
        canvas.fill([x, floor + GAP + BAND], [1, 5], INK);
        let text = number::value(low + place * (high - low));
        let half = 0.5 * text::width(&text, TEXT);
        let x = (x as f32 - half).clamp(0.0, SIZE[0] as f32 - 2.0 * half);
        text::draw(&mut canvas, &text, [x, (floor + GAP + BAND + 9) as f32], TEXT, INK);
    }
    canvas.into_frame()
}

/// Values from end to end: of the points, and of the histogram as far as it is not far beyond them.
pub fn shown_range(transfer: &TransferFunction, histogram: Option<(f64, f64)>) -> (f64, f64) {
    let points = transfer.points();
    let (mut low, mut high) = (points[0].value, points[points.len() - 1].value);
    if let Some((first, last)) = histogram {
        let reach = if high > low { high - low } else { last - first };
        low = low.min(first.max(low - reach));
        high = high.max(last.min(high + reach));
    }
    if low < high { (low, high) } else { (low - 0.5, high + 0.5) }
}

/// End of the axis of opacity: 1, 0.5, 0.2, 0.1 and so on, the smallest that holds all.
fn axis_end(max_opacity: f64) -> f64 {
    let mut end = 1.0;
    for smaller in [0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001] {
        if max_opacity > 0.0 && max_opacity <= smaller {
            end = smaller;
        }
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::transfer::Preset;
    use vr_core::{ControlPoint, OpacityRule};

    #[test]
    fn the_curve_and_its_colours_are_there() {
        let transfer =
            TransferFunction::new(Preset::CtBone.points((-1024.0, 3071.0)), OpacityRule::Power, 1.0).unwrap();
        let histogram = Histogram { range: (-1024.0, 1500.0), counts: vec![1000, 10, 0, 5] };
        let picture = draw(&transfer, Some(&histogram));
        assert_eq!(picture.size(), SIZE);
        let band = SIZE[1] - MARGIN[3] - BAND / 2;
        let end = picture.pixel(SIZE[0] - MARGIN[2] - 1, band);
        assert!(end[0] > 0.95 && end[2] > 0.95, "white at the upper end: {end:?}");
        assert!((0..SIZE[1]).any(|y| picture.pixel(500, y)[..3] == CURVE));
        assert!((0..SIZE[1]).any(|y| picture.pixel(MARGIN[0] + 2, y)[..3] == BARS), "air's bar");
    }

    #[test]
    fn odd_functions_are_drawn() {
        for points in [
            vec![ControlPoint::new(7.0, [5.0; 3], 0.0)],
            vec![ControlPoint::new(0.0, [0.0; 3], 1.0), ControlPoint::new(0.0, [1.0; 3], 0.0)],
            vec![ControlPoint::new(-1e30, [0.0; 3], 1.0), ControlPoint::new(1e30, [1.0; 3], 1e-9)],
        ] {
            let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
            draw(&transfer, Some(&Histogram { range: (7.0, 7.0), counts: vec![0; 4] }));
            draw(&transfer, None);
        }
        assert_eq!([1.0, 0.6, 0.5, 0.19, 0.0, 1e-9].map(axis_end), [1.0, 1.0, 0.5, 0.2, 1.0, 0.001]);
    }
}
