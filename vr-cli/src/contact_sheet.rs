//! Contact sheet of a comparison: each picture above the map of its error, numbered as in the table, and the scale of the
//! maps below.

use vr_core::Frame;
use vr_study::error_colors;

use crate::canvas::Canvas;
use crate::digits;
use crate::error_scale::{self, GAP, INK, PAPER};

/// Numbered column of the sheet.
pub struct Entry<'a> {
    /// The picture.
    pub frame: &'a Frame,
    /// Largest error of any component, per pixel.
    pub errors: &'a [f64],
}

/// Largest number of entries side by side.
const MAX_COLUMNS: usize = 4;

/// Draws the sheet. All frames have the same size; there is at least one.
pub fn draw(entries: &[Entry<'_>], background: [f32; 3]) -> Frame {
    let [w, h] = entries[0].frame.size();
    let columns = entries.len().min(MAX_COLUMNS) as u32;
    let bands = entries.len().div_ceil(MAX_COLUMNS) as u32;
    let band = digits::HEIGHT + 2 * h + 2 * GAP;
    let width = columns * (w + GAP) + GAP;
    let height = GAP + bands * band + error_scale::HEIGHT + GAP;
    let mut canvas = Canvas::new([width, height], PAPER);
    for (k, entry) in entries.iter().enumerate() {
        let x = GAP + (k % MAX_COLUMNS) as u32 * (w + GAP);
        let y = GAP + (k / MAX_COLUMNS) as u32 * band;
        digits::draw(&mut canvas, k as i32 + 1, [x, y], INK);
        let picture = y + digits::HEIGHT + GAP / 2;
        let map = picture + h + GAP / 2;
        let colors = entry.frame.over_background(background);
        for (i, (&color, &error)) in (0..).zip(colors.iter().zip(entry.errors)) {
            let [px, py] = [x + i % w, i / w];
            canvas.put([px, picture + py], color);
            canvas.put([px, map + py], error_colors::color(error));
        }
    }
    error_scale::draw(&mut canvas, [GAP, GAP + bands * band], width - 2 * GAP);
    canvas.into_frame()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_lie_above_their_errors() {
        let frame = Frame::new([40, 30], vec![[1.0; 4]; 1200], None);
        let errors = vec![1.0; 1200];
        let entries: Vec<Entry<'_>> = (0..5).map(|_| Entry { frame: &frame, errors: &errors }).collect();
        let sheet = draw(&entries, [0.0; 3]);
        assert_eq!(sheet.size()[0], 4 * 48 + 8);
        let (x, y) = (GAP + 1, GAP + digits::HEIGHT + GAP / 2);
        assert_eq!(sheet.pixel(x, y), [1.0; 4]);
        assert_eq!(sheet.pixel(x, y + 30 + GAP / 2)[..3], error_colors::at(1.0));
    }
}
