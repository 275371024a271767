//! Contact sheet of a comparison: each picture above the map of its error, below its name, and the scale of the maps at the end.

use vr_core::Frame;
use vr_study::error_colors;

use crate::canvas::Canvas;
use crate::error_scale::{self, GAP, INK, LINE, PAPER};
use crate::text;

/// Column of the sheet.
pub struct Entry<'a> {
    /// Name of the picture.
    pub name: String,
    /// Time and error in a few words.
    pub caption: String,
    /// The picture.
    pub frame: &'a Frame,
    /// Largest error of any component, per pixel; NaN where noise hides it.
    pub errors: &'a [f64],
}

/// Largest number of entries side by side: two rows of these fit a screen.
const MAX_COLUMNS: usize = 6;
/// Smallest width of a column, which names need.
const MIN_WIDTH: u32 = 200;
/// Smallest height of a line that is legible.
const MIN_LINE: f32 = 11.5;
/// Height of name and caption.
const WORDS: u32 = 2 * LINE + GAP / 2;
/// Colour of captions.
const PALE: [f32; 3] = [0.4; 3];

/// Draws the sheet below a title. All frames have the same size; there is at least one.
pub fn draw(title: &str, entries: &[Entry<'_>], background: [f32; 3]) -> Frame {
    let [w, h] = entries[0].frame.size();
    let column = w.max(MIN_WIDTH);
    let columns = entries.len().min(MAX_COLUMNS) as u32;
    let bands = entries.len().div_ceil(MAX_COLUMNS) as u32;
    let band = WORDS + 2 * h + 2 * GAP;
    let width = columns * (column + GAP) + GAP;
    let top = GAP + LINE + GAP;
    let height = top + bands * band + LINE + error_scale::HEIGHT + GAP;
    let mut canvas = Canvas::new([width, height], PAPER);
    write(&mut canvas, title, [GAP, GAP], width - 2 * GAP, INK);
    for (k, entry) in entries.iter().enumerate() {
        let x = GAP + (k % MAX_COLUMNS) as u32 * (column + GAP);
        let y = top + (k / MAX_COLUMNS) as u32 * band;
        write(&mut canvas, &entry.name, [x, y], column, INK);
        write(&mut canvas, &entry.caption, [x, y + LINE], column, PALE);
        let picture = y + WORDS;
        let map = picture + h + GAP / 2;
        let colors = entry.frame.over_background(background);
        for (i, (&color, &error)) in (0..).zip(colors.iter().zip(entry.errors)) {
            let [px, py] = [x + i % w, i / w];
            canvas.put([px, picture + py], color);
            canvas.put([px, map + py], error_colors::color(error));
        }
    }
    let y = top + bands * band;
    let hidden = entries.iter().any(|entry| entry.errors.iter().any(|error| error.is_nan()));
    let what =
        if hidden { "largest error of a component; grey: no more than chance" } else { "largest error of a component" };
    write(&mut canvas, what, [GAP, y], width - 2 * GAP, PALE);
    error_scale::draw(&mut canvas, [GAP, y + LINE], width - 2 * GAP);
    canvas.into_frame()
}

/// Writes a line that is no wider than a column: smaller where it has to be, and cut where that does not do.
fn write(canvas: &mut Canvas, words: &str, [x, y]: [u32; 2], width: u32, color: [f32; 3]) {
    let (width, line) = (width as f32, LINE as f32);
    let height = (line * width / text::width(words, line).max(1.0)).clamp(MIN_LINE, line);
    let mut words = words.to_owned();
    let mut cut = words.clone();
    while text::width(&cut, height) > width && words.pop().is_some() {
        cut = format!("{}…", words.trim_end());
    }
    text::draw(canvas, &cut, [x as f32, y as f32 + 0.5 * (line - height)], height, color);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_lie_above_their_errors_and_below_their_names() {
        let frame = Frame::new([40, 30], vec![[1.0; 4]; 1200], None);
        let errors = vec![1.0; 1200];
        let words = || "a name that is far too long for a narrow column".to_owned();
        let entries: Vec<Entry<'_>> =
            (0..7).map(|_| Entry { name: words(), caption: words(), frame: &frame, errors: &errors }).collect();
        let sheet = draw("title", &entries, [0.0; 3]);
        assert_eq!(sheet.size()[0], 6 * (MIN_WIDTH + GAP) + GAP);
        let (x, y) = (GAP + 1, GAP + LINE + GAP + WORDS);
        assert_eq!(sheet.pixel(x, y), [1.0; 4]);
        assert_eq!(sheet.pixel(x, y + 30 + GAP / 2)[..3], error_colors::at(1.0));
        // Words stay in their column.
        let gap =
            |x: u32| (0..sheet.size()[1] - error_scale::HEIGHT - LINE - GAP).all(|y| sheet.pixel(x, y)[..3] == PAPER);
        assert!(gap(GAP + MIN_WIDTH + GAP - 1) && !gap(GAP + 5));
    }
}
