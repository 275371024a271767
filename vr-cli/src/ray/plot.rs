//! Curves in a terminal.

use super::figures;

/// Dots of a character along x and y (Unicode's Braille patterns).
const DOTS: [usize; 2] = [2, 4];
/// Bits of the dots, row by row from the top.
const BITS: [[u32; 2]; 4] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];
/// Number of characters before the curve, for its name and the ends of its scale.
pub const MARGIN: usize = 21;

/// Plot of two curves over the same ray: a fine one in dots, and marks wherever the other differs.
pub struct Plot<'a> {
    /// Name of the quantity.
    pub name: &'a str,
    /// Number of characters from top to bottom.
    pub rows: usize,
    /// Values at the bottom and at the top.
    pub scale: [f64; 2],
    /// Smallest and largest value in each column of dots, two of them a character; `None` where there is nothing.
    pub curve: &'a [Option<[f64; 2]>],
    /// True if the curve is bars, of which only the top is a value.
    pub bars: bool,
    /// Values of the other curve, one a character.
    pub marks: &'a [Option<f64>],
}

/// Returns a scale that holds all values and is not a point.
pub fn scale(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] =
        values.filter(|v| v.is_finite()).fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
    match high - low {
        _ if low > high => [0.0, 1.0],
        // A constant stands in the middle.
        0.0 if low == 0.0 => [0.0, 1.0],
        0.0 => [low - 0.5 * low.abs(), low + 0.5 * low.abs()],
        // Not the rounding of a zero.
        span => [low, high].map(|end| if end.abs() < 1e-9 * span { 0.0 } else { end }),
    }
}

impl Plot<'_> {
    /// Returns the lines of the plot.
    pub fn text(&self) -> String {
        let height = self.rows * DOTS[1];
        let [low, high] = self.scale;
        // Row of dots from the top.
        let place = |v: f64| {
            let part = ((v - low) / (high - low)).clamp(0.0, 1.0);
            ((1.0 - part) * (height - 1) as f64).round() as usize
        };
        let columns = self.curve.len() / DOTS[0];
        let mut cells = vec![0u32; columns * self.rows];
        for (x, extent) in self.curve.iter().take(columns * DOTS[0]).enumerate() {
            let Some([bottom, top]) = extent else { continue };
            for y in place(*top)..=place(*bottom) {
                cells[y / DOTS[1] * columns + x / DOTS[0]] |= BITS[y % DOTS[1]][x % DOTS[0]];
            }
        }
        let mut characters: Vec<char> = cells
            .iter()
            .map(|&bits| if bits == 0 { ' ' } else { char::from_u32(0x2800 + bits).unwrap_or(' ') })
            .collect();
        for (x, mark) in self.marks.iter().take(columns).enumerate() {
            let Some(mark) = mark.filter(|mark| !mark.is_nan()) else { continue };
            let row = place(mark) / DOTS[1];
            let mut tops = self.curve[DOTS[0] * x..][..DOTS[0]].iter().flatten().map(|[_, top]| place(*top) / DOTS[1]);
            let met = if self.bars { tops.any(|top| top == row) } else { cells[row * columns + x] != 0 };
            if !met {
                characters[row * columns + x] = '×';
            }
        }
        let mut text = String::new();
        for (row, line) in characters.chunks(columns.max(1)).enumerate() {
            let name = if row == 0 { self.name } else { "" };
            let end = match row {
                0 => figures::short(high),
                r if r + 1 == self.rows => figures::short(low),
                _ => String::new(),
            };
            let line: String = line.iter().collect();
            text += &format!("{name:<10}{end:>10}│{}\n", line.trim_end());
        }
        text
    }
}

/// Draws a row of counts: a digit a character, `+` from ten on.
pub fn counts(name: &str, counts: &[usize]) -> String {
    let digit = |&n: &usize| match n {
        0 => ' ',
        1..10 => char::from_digit(n as u32, 10).unwrap_or('+'),
        _ => '+',
    };
    let line: String = counts.iter().map(digit).collect();
    format!("{name:<20}│{}\n", line.trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_rises_and_what_lies_elsewhere_is_marked() {
        let curve: Vec<_> = (0..8).map(|i| Some([f64::from(i); 2])).collect();
        let marks = [Some(0.5), None, None, Some(0.0)];
        let plot = Plot {
            name: "ramp",
            rows: 2,
            scale: scale((0..8).map(f64::from)),
            curve: &curve,
            bars: false,
            marks: &marks,
        };
        let text = plot.text();
        let lines: Vec<&str> = text.lines().map(|line| line.split_once('│').unwrap().1).collect();
        assert_eq!(lines, ["  ⡠⠊", "⡠⠊ ×"]);
        assert!(text.starts_with("ramp               7│") && text.lines().all(|l| l.chars().count() <= MARGIN + 4));
    }

    #[test]
    fn marks_inside_a_bar_are_seen_and_at_its_top_are_not() {
        let curve = [Some([0.0, 8.0]); 4];
        let marks = [Some(1.0), Some(7.9)];
        let text = Plot { name: "bar", rows: 2, scale: [0.0, 8.0], curve: &curve, bars: true, marks: &marks }.text();
        let lines: Vec<&str> = text.lines().map(|line| line.split_once('│').unwrap().1).collect();
        assert_eq!(lines, ["⣿⣿", "×⣿"]);
    }

    #[test]
    fn scales_and_counts() {
        assert_eq!(scale([f64::NAN, 2.0, 1.0, f64::INFINITY].into_iter()), [1.0, 2.0]);
        assert_eq!(scale(std::iter::empty()), [0.0, 1.0]);
        assert_eq!(scale([4.0].into_iter()), [2.0, 6.0]);
        assert_eq!(counts("faces", &[0, 3, 0, 12, 0]), "faces               │ 3 +\n");
    }
}
