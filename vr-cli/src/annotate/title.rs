//! Title above a picture.

use super::sheet::Sheet;
use crate::text;
use crate::wrapping::wrapped;

/// Height of a line of a title in lines of other text.
const HEIGHT: f32 = 1.35;

/// Draws a title in the upper left corner, broken between words where it is wider than the picture; false where there is no room for it.
pub fn draw(title: &str, sheet: &mut Sheet<'_>) -> bool {
    let [w, h] = sheet.size();
    let (width, height) = (w - 2.0 * sheet.margin, (HEIGHT * sheet.line).round());
    let lines: Vec<String> =
        title.lines().flat_map(|line| wrapped(line, |line| text::width(line, height) <= width)).collect();
    let widest = lines.iter().map(|line| text::width(line, height)).fold(0.0, f32::max);
    let corner = [sheet.margin, 0.6 * sheet.margin];
    let size = [widest, height * lines.len() as f32];
    if size[1] > h / 3.0 || !sheet.reserve(corner, size) {
        return false;
    }
    for (k, line) in lines.iter().enumerate() {
        sheet.text(line, [corner[0], corner[1] + k as f32 * height], height);
    }
    true
}
