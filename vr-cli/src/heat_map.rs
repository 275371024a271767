//! Heat map of an error, and its scale below.

use vr_core::Frame;
use vr_study::error_colors;

use crate::canvas::Canvas;
use crate::error_scale::{self, GAP, PAPER};

/// Smallest width, which the numbers of the scale need.
const MIN_WIDTH: u32 = 160;

/// Draws an error per pixel, row by row from the top, in the logarithmic colours of [`error_colors`].
pub fn draw(size: [u32; 2], errors: impl IntoIterator<Item = f64>) -> Frame {
    let [w, h] = size;
    let width = w.max(MIN_WIDTH);
    let mut canvas = Canvas::new([width, h + GAP + error_scale::HEIGHT], PAPER);
    let left = (width - w) / 2;
    for (i, error) in (0..).zip(errors) {
        canvas.put([left + i % w, i / w], error_colors::color(error));
    }
    error_scale::draw(&mut canvas, [GAP, h + GAP], width - 2 * GAP);
    canvas.into_frame()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pixel_has_its_colour_above_the_scale() {
        let map = draw([200, 1], (0..200).map(|x| if x == 7 { 1e-4 } else { f64::NAN }));
        assert_eq!(map.size(), [200, 1 + GAP + error_scale::HEIGHT]);
        assert_eq!(map.pixel(7, 0)[..3], error_colors::color(1e-4));
        assert_eq!(map.pixel(8, 0)[..3], error_colors::HIDDEN);
        assert_eq!(map.pixel(GAP, 1 + GAP)[..3], error_colors::at(0.0));
        // A small map stands in the middle of a wider sheet.
        let small = draw([2, 2], [1.0; 4]);
        assert_eq!(small.size()[0], MIN_WIDTH);
        assert_eq!(small.pixel(MIN_WIDTH / 2, 1)[..3], error_colors::at(1.0));
        assert_eq!(small.pixel(0, 0)[..3], PAPER);
    }
}
