//! Contact sheet of presets: each picture above the name that draws it.

use vr_core::Frame;

use crate::canvas::Canvas;
use crate::error_scale::{GAP, INK, PAPER};
use crate::text;

/// Picture and its name.
pub struct Entry<'a> {
    /// The picture.
    pub frame: &'a Frame,
    /// Linear RGB behind it.
    pub background: [f32; 3],
    /// The name below it.
    pub name: &'a str,
}

/// Height of a name in pixels.
const TEXT: u32 = 16;
/// Largest number of entries side by side.
const MAX_COLUMNS: usize = 6;

/// Draws the sheet. All frames have the same size; there is at least one.
pub fn draw(entries: &[Entry<'_>]) -> Frame {
    let [w, h] = entries[0].frame.size();
    let columns = columns(entries.len());
    let rows = entries.len().div_ceil(columns) as u32;
    let (across, down) = (w + GAP, h + TEXT + GAP + GAP / 2);
    let mut canvas = Canvas::new([columns as u32 * across + GAP, rows * down + GAP], PAPER);
    for (k, entry) in entries.iter().enumerate() {
        let x = GAP + (k % columns) as u32 * across;
        let y = GAP + (k / columns) as u32 * down;
        for (i, color) in (0..).zip(entry.frame.over_background(entry.background)) {
            canvas.put([x + i % w, y + i / w], color);
        }
        // In the middle below the picture.
        let left = x as f32 + 0.5 * (w as f32 - text::width(entry.name, TEXT as f32)).max(0.0);
        text::draw(&mut canvas, entry.name, [left, (y + h + GAP / 2) as f32], TEXT as f32, INK);
    }
    canvas.into_frame()
}

/// Number of columns: a sheet about as wide as high, and no row of one.
fn columns(count: usize) -> usize {
    let square = (1..=MAX_COLUMNS).find(|n| n * n >= count).unwrap_or(MAX_COLUMNS);
    let leaves_one = square > 1 && square < MAX_COLUMNS && count % square == 1;
    square + usize::from(leaves_one)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_lie_above_their_names() {
        let frame = Frame::new([96, 50], vec![[1.0; 4]; 4800], None);
        let entries: Vec<Entry<'_>> = ["grey", "ct-bone", "x-ray", "pet-hot"]
            .iter()
            .map(|name| Entry { frame: &frame, background: [0.0; 3], name })
            .collect();
        let sheet = draw(&entries);
        assert_eq!(sheet.size(), [2 * (96 + GAP) + GAP, 2 * (50 + TEXT + GAP + GAP / 2) + GAP]);
        assert_eq!(sheet.pixel(GAP + 1, GAP + 1), [1.0; 4]);
        // Letters are smooth, and thin at this size.
        let is_ink = |x, y| sheet.pixel(GAP + x, GAP + 50 + GAP / 2 + y)[0] > 3.0 * PAPER[0];
        let named = (0..96).any(|x| (0..TEXT).any(|y| is_ink(x, y)));
        assert!(named);
        assert_eq!([1, 2, 3, 4, 5, 7, 9, 15, 22, 100].map(columns), [1, 2, 3, 2, 3, 4, 3, 4, 5, 6]);
    }
}
