//! Digits in pictures, which number tiles and label a scale without a font.

use crate::canvas::Canvas;

/// Dots of the ten digits and the minus sign: each row is three bits, the left dot first.
const GLYPHS: [[u8; 5]; 11] = [
    [0b111, 0b101, 0b101, 0b101, 0b111],
    [0b010, 0b110, 0b010, 0b010, 0b111],
    [0b111, 0b001, 0b111, 0b100, 0b111],
    [0b111, 0b001, 0b111, 0b001, 0b111],
    [0b101, 0b101, 0b111, 0b001, 0b001],
    [0b111, 0b100, 0b111, 0b001, 0b111],
    [0b111, 0b100, 0b111, 0b101, 0b111],
    [0b111, 0b001, 0b010, 0b010, 0b010],
    [0b111, 0b101, 0b111, 0b101, 0b111],
    [0b111, 0b101, 0b111, 0b001, 0b111],
    [0b000, 0b000, 0b111, 0b000, 0b000],
];

/// Width of a dot in pixels.
const DOT: u32 = 2;
/// Height of a line of digits in pixels.
pub const HEIGHT: u32 = 5 * DOT;
/// Width of a digit with the gap after it.
const ADVANCE: u32 = 4 * DOT;

/// Returns the width of a number in pixels.
pub fn width(number: i32) -> u32 {
    number.to_string().len() as u32 * ADVANCE - DOT
}

/// Writes a number with its upper left corner at (x, y).
pub fn draw(canvas: &mut Canvas, number: i32, [x, y]: [u32; 2], color: [f32; 3]) {
    for (k, letter) in (0..).zip(number.to_string().chars()) {
        let glyph = GLYPHS[letter.to_digit(10).map_or(10, |d| d as usize)];
        for (row, bits) in (0..).zip(glyph) {
            for column in (0..3).filter(|c| bits >> (2 - c) & 1 == 1) {
                canvas.fill([x + k * ADVANCE + column * DOT, y + row * DOT], [DOT, DOT], color);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_fill_their_width() {
        let mut canvas = Canvas::new([width(-17), HEIGHT], [0.0; 3]);
        draw(&mut canvas, -17, [0, 0], [1.0; 3]);
        let frame = canvas.into_frame();
        let lit = |x: u32| (0..HEIGHT).any(|y| frame.pixel(x, y)[0] > 0.0);
        assert!(lit(0) && lit(width(-17) - 1) && !lit(ADVANCE - 1));
    }
}
