//! Scale of error maps: a bar from the smallest to the largest error that has a colour, with the exponents of its decades.

use vr_study::error_colors;

use crate::canvas::Canvas;
use crate::digits;

/// Colour of the background: dark enough for the maps, light enough to tell it from their black.
pub const PAPER: [f32; 3] = [0.03, 0.03, 0.035];
/// The colour of numbers.
pub const INK: [f32; 3] = [0.8; 3];
/// Width in pixels of the gap between parts of a picture.
pub const GAP: u32 = 8;
/// Height of the bar alone.
const BAR: u32 = 10;
/// Height of the bar and its numbers.
pub const HEIGHT: u32 = BAR + GAP + digits::HEIGHT;

/// Draws the scale with its upper left corner at (x, y).
pub fn draw(canvas: &mut Canvas, [left, y]: [u32; 2], width: u32) {
    for x in 0..width {
        let color = error_colors::at(f64::from(x) / f64::from(width.max(2) - 1));
        canvas.fill([left + x, y], [1, BAR], color);
    }
    let (low, high) = error_colors::DECADES;
    for decade in low..=high {
        let place = f64::from(decade - low) / f64::from(high - low);
        let half = digits::width(decade) / 2;
        let middle = left + (place * f64::from(width)) as u32;
        let last = (left + width).saturating_sub(2 * half).max(left);
        let x = middle.saturating_sub(half).clamp(left, last);
        digits::draw(canvas, decade, [x, y + BAR + GAP / 2], INK);
    }
}
