//! Text in pictures, in the embedded font.

use std::sync::LazyLock;

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};

use crate::canvas::Canvas;
use crate::mask::Mask;

/// DejaVu Sans: Latin, Greek, Cyrillic, punctuation, and signs of mathematics. `font/README.md` tells how it was made.
static FONT: LazyLock<FontRef<'static>> = LazyLock::new(|| {
    FontRef::try_from_slice(include_bytes!("../font/DejaVuSans-subset.ttf")).expect("the embedded font is whole")
});

/// Height of digits and capitals as a part of that of a line.
pub const CAPITALS: f32 = 0.626;
/// Depth of the baseline below the top of a line as a part of its height.
pub const BASELINE: f32 = 0.797;

/// Returns the width in pixels of a line of text that is `height` pixels high, from the ascenders to the descenders.
pub fn width(text: &str, height: f32) -> f32 {
    placed(text, [0.0; 2], height).1
}

/// Returns the first character that the font lacks.
pub fn missing(text: &str) -> Option<char> {
    text.chars().find(|&c| FONT.glyph_id(c).0 == 0)
}

/// Draws a line of text with its upper left corner at (x, y), in a linear colour.
pub fn draw(canvas: &mut Canvas, text: &str, [x, y]: [f32; 2], height: f32, color: [f32; 3]) {
    canvas.paint(&mask(text, [x, y], height), color, 1.0);
}

/// Returns the coverage by a line of text with its upper left corner at (x, y).
pub fn mask(text: &str, [x, y]: [f32; 2], height: f32) -> Mask {
    // Accents reach above the line, and some letters to the left of their place.
    let end = x + width(text, height);
    let mut mask = Mask::new([x - 0.3 * height, y - 0.2 * height], [end + 0.3 * height, y + 1.2 * height]);
    add(&mut mask, text, [x, y], height);
    mask
}

/// Adds a line of text to a mask.
pub fn add(mask: &mut Mask, text: &str, at: [f32; 2], height: f32) {
    for glyph in placed(text, at, height).0 {
        if let Some(outlined) = FONT.outline_glyph(glyph) {
            let corner = outlined.px_bounds().min;
            let corner = [corner.x as i32, corner.y as i32];
            outlined.draw(|x, y, coverage| mask.add([corner[0] + x as i32, corner[1] + y as i32], coverage));
        }
    }
}

/// Returns the glyphs of a line in their places, and its width.
fn placed(text: &str, [x, y]: [f32; 2], height: f32) -> (Vec<Glyph>, f32) {
    let font = FONT.as_scaled(PxScale::from(height));
    let mut pen = x;
    let mut before = None;
    let mut glyphs = Vec::new();
    for c in text.chars() {
        let id = font.glyph_id(c);
        pen += before.map_or(0.0, |before| font.kern(before, id));
        glyphs.push(id.with_scale_and_position(height, point(pen, y + BASELINE * height)));
        pen += font.h_advance(id);
        before = Some(id);
    }
    (glyphs, pen - x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_font_has_what_is_printed_and_its_sizes_are_the_stated_ones() {
        assert_eq!(missing("raycast midpoint 0.5: −1.5e−3 µm, 50 Å ≈ Größe ΔΩ × ² R L A P S I Жизнь"), None);
        assert_eq!(missing("voxel 体"), Some('体'));
        let font = FONT.as_scaled(1.0);
        assert!((font.ascent() - BASELINE).abs() < 1e-3 && (font.height() - 1.0).abs() < 1e-5);
        let top = FONT.outline_glyph(FONT.glyph_id('H').with_scale(1000.0)).unwrap().px_bounds();
        assert!((-top.min.y / 1000.0 - CAPITALS).abs() < 2e-3, "{top:?}");
    }

    #[test]
    fn text_fills_its_width_and_kerning_is_kept() {
        let text = "Hill";
        let covered: Vec<_> = mask(text, [10.0, 0.0], 20.0).covered().collect();
        let [low, high] = [covered.iter().map(|c| c.0[0]).min(), covered.iter().map(|c| c.0[0]).max()];
        let end = 10.0 + width(text, 20.0);
        assert!((10..13).contains(&low.unwrap()) && (end - 4.0..=end).contains(&(high.unwrap() as f32)));
        assert!(width("AV", 100.0) < width("A", 100.0) + width("V", 100.0));
        assert!((width(text, 200.0) / width(text, 20.0) - 10.0).abs() < 1e-3);
    }
}
