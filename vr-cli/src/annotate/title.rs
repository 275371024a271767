//! Title above a picture.

use super::sheet::Sheet;
use crate::text;

/// Height of a line of a title in lines of other text.
const HEIGHT: f32 = 1.35;

/// Draws a title in the upper left corner, broken between words where it is wider than the picture; false where there is no room for it.
pub fn draw(title: &str, sheet: &mut Sheet<'_>) -> bool {
    let [w, h] = sheet.size();
    let (width, height) = (w - 2.0 * sheet.margin, (HEIGHT * sheet.line).round());
    let lines: Vec<String> = title.lines().flat_map(|line| wrapped(line, width, height)).collect();
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

/// Breaks a text between words into lines of a width; a word that is wider has a line of its own.
fn wrapped(text: &str, width: f32, height: f32) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("there is one");
        let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
        if line.is_empty() || text::width(&longer, height) <= width {
            *line = longer;
        } else {
            lines.push(word.to_owned());
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_are_broken_between_words() {
        let text = "A title of several words";
        let narrow = text::width("A title of ", 20.0);
        assert_eq!(wrapped(text, narrow, 20.0), ["A title of", "several", "words"]);
        assert_eq!(wrapped(text, 1e6, 20.0), [text]);
    }
}
