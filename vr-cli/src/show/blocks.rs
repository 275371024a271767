//! Pictures of half blocks: a character is two pixels, one above the other, in the colours of its upper half and of what is below.

use std::fmt::Write;

/// Opacity from which on a pixel is drawn; the terminal's own background is in place of the others.
const MIN_ALPHA: u8 = 128;

/// Returns the lines of a picture, in 24 bits of colour or in the 256 colours that nearly every terminal has.
pub fn text([width, height]: [u32; 2], pixels: &[[u8; 4]], true_color: bool) -> String {
    let color = |x: u32, y: u32| {
        let inside = y < height;
        let [r, g, b, a] = if inside { pixels[(y * width + x) as usize] } else { [0; 4] };
        (a >= MIN_ALPHA)
            .then(|| if true_color { format!("2;{r};{g};{b}") } else { format!("5;{}", palette([r, g, b])) })
    };
    let mut text = String::new();
    for y in (0..height).step_by(2) {
        // Colours are told where they change.
        let mut now: [Option<String>; 2] = [None, None];
        for x in 0..width {
            let (upper, lower) = (color(x, y), color(x, y + 1));
            let (front, behind, sign) = match (upper, lower) {
                (None, None) => (None, None, ' '),
                (None, lower) => (lower, None, '▄'),
                (upper, lower) => (upper, lower, '▀'),
            };
            if front.is_some() && front != now[0] {
                let _ = write!(text, "\u{1b}[38;{}m", front.as_deref().unwrap_or_default());
                now[0] = front;
            }
            if behind != now[1] {
                match &behind {
                    Some(color) => write!(text, "\u{1b}[48;{color}m"),
                    None => write!(text, "\u{1b}[49m"),
                }
                .unwrap_or_default();
                now[1] = behind;
            }
            text.push(sign);
        }
        text += "\u{1b}[0m\n";
    }
    text
}

/// Returns the number of the nearest of 216 colours and 24 greys.
fn palette(color: [u8; 3]) -> u8 {
    const LEVELS: [u8; 6] = [0, 95, 135, 175, 215, 255];
    let nearest = |c: u8| (0..6u8).min_by_key(|&k| LEVELS[k as usize].abs_diff(c)).unwrap_or(0);
    let cube = color.map(nearest);
    let grey =
        (0..24u8).min_by_key(|&k| color.iter().map(|&c| u32::from((8 + 10 * k).abs_diff(c))).sum::<u32>()).unwrap_or(0);
    let distance = |other: [u8; 3]| -> u32 { (0..3).map(|c| u32::from(color[c].abs_diff(other[c])).pow(2)).sum() };
    let of_cube = distance(cube.map(|k| LEVELS[k as usize]));
    if distance([8 + 10 * grey; 3]) < of_cube { 232 + grey } else { 16 + 36 * cube[0] + 6 * cube[1] + cube[2] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_rows_are_a_line() {
        let (red, blue, none) = ([255, 0, 0, 255], [0, 0, 255, 255], [9, 9, 9, 0]);
        let found = text([2, 3], &[red, red, blue, none, none, none], true);
        let lines: Vec<&str> = found.lines().collect();
        assert_eq!(lines[0], "\u{1b}[38;2;255;0;0m\u{1b}[48;2;0;0;255m▀\u{1b}[49m▀\u{1b}[0m");
        assert_eq!(lines[1], "  \u{1b}[0m");
        assert!(text([1, 2], &[none, blue], true).contains('▄'));
    }

    #[test]
    fn nearest_colours_of_the_palette() {
        assert_eq!([palette([255, 0, 0]), palette([0, 0, 0]), palette([255; 3])], [196, 16, 231]);
        assert_eq!([palette([128; 3]), palette([100, 140, 180])], [244, 67]);
    }
}
