//! Scale of error maps: a bar from the smallest to the largest error that has a colour, with its powers of ten.

use vr_study::error_colors;

use crate::canvas::Canvas;
use crate::text;

/// Colour of the background: dark enough for the maps, light enough to tell it from their black.
pub const PAPER: [f32; 3] = [0.03, 0.03, 0.035];
/// The colour of text.
pub const INK: [f32; 3] = [0.8; 3];
/// Width in pixels of the gap between parts of a picture.
pub const GAP: u32 = 8;
/// Height of a line of text.
pub const LINE: u32 = 15;
/// Height of the bar alone.
const BAR: u32 = 10;
/// Height of the bar and its powers.
pub const HEIGHT: u32 = BAR + GAP / 2 + LINE;

/// Draws the scale with its upper left corner at (x, y).
pub fn draw(canvas: &mut Canvas, [left, y]: [u32; 2], width: u32) {
    for x in 0..width {
        let color = error_colors::at(f64::from(x) / f64::from(width.max(2) - 1));
        canvas.fill([left + x, y], [1, BAR], color);
    }
    let (low, high) = error_colors::DECADES;
    let height = LINE as f32;
    let widest = (low..=high).map(|decade| text::width(&power(decade), height)).fold(0.0, f32::max);
    // Each power, or each second, third, … of them, as there is room.
    let room = width as f32 / (high - low) as f32;
    let stride = ((widest + GAP as f32) / room).ceil().max(1.0) as usize;
    for decade in (low..=high).step_by(stride) {
        let (label, place) = (power(decade), (decade - low) as f32 / (high - low) as f32);
        let wide = text::width(&label, height);
        let x = (place * width as f32 - 0.5 * wide).clamp(0.0, (width as f32 - wide).max(0.0));
        text::draw(canvas, &label, [left as f32 + x, (y + BAR + GAP / 2) as f32], height, INK);
    }
}

/// Returns a power of ten as it is written.
fn power(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digits = exponent.unsigned_abs().to_string().bytes().map(|d| DIGITS[usize::from(d - b'0')]).collect::<String>();
    format!("10{}{digits}", if exponent < 0 { "⁻" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_can_be_written() {
        assert_eq!((power(-7), power(12)), ("10⁻⁷".to_owned(), "10¹²".to_owned()));
        assert_eq!(text::missing(&power(-1234567890)), None);
    }
}
