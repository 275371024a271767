//! Sheet: a picture that annotations share, each in a place of its own, readable on whatever is below.

use crate::canvas::Canvas;
use crate::mask::Mask;
use crate::text;

/// Smallest height of a line of text, in pixels, that is legible.
const MIN_LINE: f32 = 13.0;
/// Height of a line of text as a share of the picture's shorter side.
const LINE: f32 = 0.03;
/// Opacity of the rim around what is drawn.
const RIM_OPACITY: f32 = 0.75;

/// Picture that is drawn on, the sizes and colours for it, and the places that are taken.
pub struct Sheet<'a> {
    canvas: &'a mut Canvas,
    /// Height of a line of text.
    pub line: f32,
    /// Distance from the edge of the picture.
    pub margin: f32,
    /// Linear colour of lines and letters.
    pub ink: [f32; 3],
    /// Linear colour of the rim around them: the opposite.
    rim: [f32; 3],
    taken: Vec<[f32; 4]>,
}

impl<'a> Sheet<'a> {
    /// Makes a sheet of a picture. Ink is white with a dark rim, or black with a light one where the margins of the picture are light.
    pub fn new(canvas: &'a mut Canvas) -> Self {
        let [w, h] = canvas.size();
        let line = (LINE * w.min(h) as f32).max(MIN_LINE).round();
        let (white, black) = ([1.0; 3], [0.0; 3]);
        let (ink, rim) = if canvas.margin_brightness() > 0.6 { (black, white) } else { (white, black) };
        Self { canvas, line, margin: (0.7 * line).round(), ink, rim, taken: Vec::new() }
    }

    /// Returns width and height of the picture.
    pub fn size(&self) -> [f32; 2] {
        self.canvas.size().map(|n| n as f32)
    }

    /// Width of a thin line.
    pub fn hairline(&self) -> f32 {
        (self.line / 13.0).round().max(1.0)
    }

    /// Takes a place, given by its upper left corner and its size, unless it leaves the picture or meets another one.
    pub fn reserve(&mut self, [x, y]: [f32; 2], [width, height]: [f32; 2]) -> bool {
        let place = [x, y, x + width, y + height];
        let [w, h] = self.size();
        let meets = |t: &[f32; 4]| t[0] < place[2] && place[0] < t[2] && t[1] < place[3] && place[1] < t[3];
        let free = x >= 0.0 && y >= 0.0 && place[2] <= w && place[3] <= h && !self.taken.iter().any(meets);
        if free {
            self.taken.push(place);
        }
        free
    }

    /// Paints the rim around a mask, below what is painted there next.
    pub fn rim(&mut self, mask: &Mask) {
        let width = (self.line / 10.0).max(1.4);
        self.canvas.paint(&mask.grown(width), self.rim, RIM_OPACITY);
    }

    /// Paints a mask in ink, with its rim.
    pub fn ink(&mut self, mask: &Mask) {
        self.rim(mask);
        self.color(mask, self.ink);
    }

    /// Paints a mask in a linear colour.
    pub fn color(&mut self, mask: &Mask, color: [f32; 3]) {
        self.canvas.paint(mask, color, 1.0);
    }

    /// Writes a line of text in ink with its upper left corner at a place.
    pub fn text(&mut self, text: &str, at: [f32; 2], height: f32) {
        self.ink(&text::mask(text, at, height));
    }

    /// Returns an empty mask of the whole picture's part between two corners.
    pub fn mask(&self, [x, y]: [f32; 2], [width, height]: [f32; 2]) -> Mask {
        Mask::new([x, y], [x + width, y + height])
    }
}
