//! Drawing of a histogram for a terminal.

use vr_look::Histogram;

use crate::number;

/// Draws the bins as columns, as high as the logarithm of their counts, above the ends of the range.
pub fn drawing(histogram: &Histogram, rows: usize) -> String {
    /// Characters of columns, each an eighth of a row higher than the one before.
    const BLOCKS: [char; 9] = [' ', '▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let height = |count: u64| (1.0 + count as f64).ln();
    let max_height = histogram.counts.iter().copied().map(height).fold(0.0, f64::max);
    let eighths = |count: u64| {
        let exact = height(count) / max_height * (8 * rows) as f64;
        // Whatever occurs at all is seen.
        (exact.round() as usize).max(usize::from(count > 0))
    };
    let mut text = String::new();
    for row in (0..rows).rev() {
        let line: String =
            histogram.counts.iter().map(|&c| BLOCKS[eighths(c).saturating_sub(8 * row).min(8)]).collect();
        text += &format!("  {}\n", line.trim_end());
    }
    let (low, high) = (number::value(histogram.range.0), number::value(histogram.range.1));
    let gap = histogram.counts.len().saturating_sub(low.chars().count());
    text + &format!("  {low}{high:>gap$}\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_what_occurs_once_and_what_occurs_often() {
        let h = Histogram { range: (0.0, 255.0), counts: vec![1_000_000, 0, 1] };
        let drawing = drawing(&h, 2);
        let lines: Vec<&str> = drawing.lines().collect();
        assert_eq!(lines, ["  █", "  █ ▁", "  0255"]);
    }
}
