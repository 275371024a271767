//! Words in pictures, of five by seven dots.

use crate::canvas::Canvas;

/// Characters that have dots; capitals have those of small letters, and all others are blank.
const CHARACTERS: &str = "abcdefghijklmnopqrstuvwxyz0123456789-.,:/()+%";

/// Dots of each character: a number of five bits for each of seven rows, the left dot first.
const DOTS: [[u8; 7]; 45] = [
    [0b00000, 0b00000, 0b01110, 0b00001, 0b01111, 0b10001, 0b01111],
    [0b10000, 0b10000, 0b11110, 0b10001, 0b10001, 0b10001, 0b11110],
    [0b00000, 0b00000, 0b01111, 0b10000, 0b10000, 0b10000, 0b01111],
    [0b00001, 0b00001, 0b01111, 0b10001, 0b10001, 0b10001, 0b01111],
    [0b00000, 0b00000, 0b01110, 0b10001, 0b11111, 0b10000, 0b01110],
    [0b00110, 0b01001, 0b01000, 0b11110, 0b01000, 0b01000, 0b01000],
    [0b00000, 0b01111, 0b10001, 0b10001, 0b01111, 0b00001, 0b01110],
    [0b10000, 0b10000, 0b11110, 0b10001, 0b10001, 0b10001, 0b10001],
    [0b00100, 0b00000, 0b01100, 0b00100, 0b00100, 0b00100, 0b01110],
    [0b00010, 0b00000, 0b00110, 0b00010, 0b00010, 0b10010, 0b01100],
    [0b10000, 0b10000, 0b10010, 0b10100, 0b11000, 0b10100, 0b10010],
    [0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110],
    [0b00000, 0b00000, 0b11010, 0b10101, 0b10101, 0b10101, 0b10101],
    [0b00000, 0b00000, 0b11110, 0b10001, 0b10001, 0b10001, 0b10001],
    [0b00000, 0b00000, 0b01110, 0b10001, 0b10001, 0b10001, 0b01110],
    [0b00000, 0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000],
    [0b00000, 0b01111, 0b10001, 0b10001, 0b01111, 0b00001, 0b00001],
    [0b00000, 0b00000, 0b10111, 0b11000, 0b10000, 0b10000, 0b10000],
    [0b00000, 0b00000, 0b01111, 0b10000, 0b01110, 0b00001, 0b11110],
    [0b01000, 0b01000, 0b11110, 0b01000, 0b01000, 0b01001, 0b00110],
    [0b00000, 0b00000, 0b10001, 0b10001, 0b10001, 0b10001, 0b01111],
    [0b00000, 0b00000, 0b10001, 0b10001, 0b10001, 0b01010, 0b00100],
    [0b00000, 0b00000, 0b10101, 0b10101, 0b10101, 0b10101, 0b01010],
    [0b00000, 0b00000, 0b10001, 0b01010, 0b00100, 0b01010, 0b10001],
    [0b00000, 0b10001, 0b10001, 0b10001, 0b01111, 0b00001, 0b01110],
    [0b00000, 0b00000, 0b11111, 0b00010, 0b00100, 0b01000, 0b11111],
    [0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110],
    [0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110],
    [0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111],
    [0b01110, 0b10001, 0b00001, 0b00110, 0b00001, 0b10001, 0b01110],
    [0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010],
    [0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110],
    [0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110],
    [0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000],
    [0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110],
    [0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100],
    [0b00000, 0b00000, 0b00000, 0b11111, 0b00000, 0b00000, 0b00000],
    [0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b01100],
    [0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b00100, 0b01000],
    [0b00000, 0b01100, 0b01100, 0b00000, 0b01100, 0b01100, 0b00000],
    [0b00001, 0b00001, 0b00010, 0b00100, 0b01000, 0b10000, 0b10000],
    [0b00010, 0b00100, 0b01000, 0b01000, 0b01000, 0b00100, 0b00010],
    [0b01000, 0b00100, 0b00010, 0b00010, 0b00010, 0b00100, 0b01000],
    [0b00000, 0b00100, 0b00100, 0b11111, 0b00100, 0b00100, 0b00000],
    [0b11001, 0b11010, 0b00010, 0b00100, 0b01000, 0b01011, 0b10011],
];

/// Rows of dots of a character, and one between lines.
const ROWS: u32 = 8;
/// Columns of a character, the gap after it among them.
const COLUMNS: u32 = 6;

/// Returns the width in pixels of a line of text that is `height` pixels high.
pub fn width(text: &str, height: f32) -> f32 {
    (text.chars().count() as u32 * COLUMNS * dot(height)) as f32
}

/// Draws a line of text with its upper left corner at (x, y), in a linear colour.
pub fn draw(canvas: &mut Canvas, text: &str, [x, y]: [f32; 2], height: f32, color: [f32; 3]) {
    let dot = dot(height);
    // `as` takes what is left of the picture to its edge.
    let (x, y) = (x as u32, y as u32);
    for (k, letter) in (0..).zip(text.chars()) {
        let Some(index) = CHARACTERS.chars().position(|c| c == letter.to_ascii_lowercase()) else { continue };
        for (row, bits) in (0..).zip(DOTS[index]) {
            for column in (0..5).filter(|c| bits >> (4 - c) & 1 == 1) {
                canvas.fill([x + (k * COLUMNS + column) * dot, y + row * dot], [dot, dot], color);
            }
        }
    }
}

/// Side of a dot in pixels.
fn dot(height: f32) -> u32 {
    (height as u32 / ROWS).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_character_has_dots_of_its_own() {
        assert_eq!(CHARACTERS.len(), DOTS.len());
        for (i, a) in DOTS.iter().enumerate() {
            assert!(a.iter().any(|&row| row > 0) && a.iter().all(|&row| row < 32));
            assert!(DOTS[..i].iter().all(|b| a != b), "{i}");
        }
    }

    #[test]
    fn words_stay_in_their_width() {
        let (text, height) = ("ct-bone", 16.0);
        let mut canvas = Canvas::new([width(text, height) as u32, 16], [0.0; 3]);
        draw(&mut canvas, text, [0.0; 2], height, [1.0; 3]);
        let frame = canvas.into_frame();
        let lit = |x: u32| (0..16).any(|y| frame.pixel(x, y)[0] > 0.0);
        assert!(lit(0) && (72..82).any(lit));
        assert_eq!(width("", 16.0), 0.0);
    }
}
