//! Canvas: a picture that is drawn on, or put together from parts.

use vr_core::Frame;
use vr_core::transfer::{linear_to_srgb, srgb_to_linear};
use vr_io::Encode;

use crate::mask::Mask;

/// Canvas of pixels in premultiplied linear RGBA.
///
/// Shapes are blended in the numbers that a screen is given, not in linear light, where light text on dark grows fat and dark text on light thin.
pub struct Canvas {
    size: [u32; 2],
    pixels: Vec<[f32; 4]>,
    /// Linear RGB behind the pixels; `None` keeps their opacity.
    background: Option<[f32; 3]>,
    encode: Encode,
}

impl Canvas {
    /// Makes a canvas of one opaque colour.
    pub fn new(size: [u32; 2], [r, g, b]: [f32; 3]) -> Self {
        let pixels = vec![[r, g, b, 1.0]; size[0] as usize * size[1] as usize];
        Self { size, pixels, background: None, encode: Encode::Srgb }
    }

    /// Makes a canvas of a frame that is going to be shown before a background (`None`: its opacity is kept) in an encoding. What is not drawn on
    /// keeps its bits.
    pub fn over(frame: &Frame, background: Option<[f32; 3]>, encode: Encode) -> Self {
        Self { size: frame.size(), pixels: frame.pixels().to_vec(), background, encode }
    }

    /// Returns width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Sets a pixel; outside of the picture nothing happens.
    pub fn put(&mut self, [x, y]: [u32; 2], [r, g, b]: [f32; 3]) {
        if x < self.size[0] && y < self.size[1] {
            self.pixels[y as usize * self.size[0] as usize + x as usize] = [r, g, b, 1.0];
        }
    }

    /// Fills a rectangle.
    pub fn fill(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2], color: [f32; 3]) {
        for dy in 0..height {
            for dx in 0..width {
                self.put([x + dx, y + dy], color);
            }
        }
    }

    /// Paints what a mask covers with a linear colour of an opacity; what lies outside of the picture is left out.
    pub fn paint(&mut self, mask: &Mask, color: [f32; 3], opacity: f32) {
        let ink = color.map(|c| self.encoded(c));
        for ([x, y], coverage) in mask.covered() {
            let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else { continue };
            if x < self.size[0] && y < self.size[1] {
                self.blend([x, y], ink, f64::from(coverage * opacity));
            }
        }
    }

    /// Mixes an encoded colour into a pixel, `share` of it.
    fn blend(&mut self, [x, y]: [u32; 2], ink: [f64; 3], share: f64) {
        let i = y as usize * self.size[0] as usize + x as usize;
        let (below, alpha) = self.straight(self.pixels[i]);
        let out = share + alpha * (1.0 - share);
        if out <= 0.0 {
            return;
        }
        let mix = |c: usize| self.decoded((share * ink[c] + alpha * (1.0 - share) * self.encoded(below[c])) / out);
        let [r, g, b] = [mix(0), mix(1), mix(2)].map(|c| (c * out) as f32);
        self.pixels[i] = [r, g, b, out as f32];
    }

    /// Returns the colour that a pixel shows, not premultiplied, and its opacity; NaN counts as 0.
    fn straight(&self, pixel: [f32; 4]) -> ([f32; 3], f64) {
        let [r, g, b, a] = pixel.map(|c| if c.is_nan() { 0.0 } else { c });
        match self.background {
            Some(behind) => (std::array::from_fn(|c| [r, g, b][c] + (1.0 - a) * behind[c]), 1.0),
            None if a > 0.0 => ([r, g, b].map(|c| c / a), f64::from(a.min(1.0))),
            None => ([0.0; 3], 0.0),
        }
    }

    /// Returns the mean brightness, as shown from 0 to 1, of the outer sixth of the picture all around; what is transparent counts as grey.
    pub fn margin_brightness(&self) -> f64 {
        let [w, h] = self.size;
        let inner = |k: u32, n: u32| (n / 6..n - n / 6).contains(&k);
        let (mut sum, mut count) = (0.0, 0.0);
        for (i, &pixel) in (0..).zip(&self.pixels) {
            if !(inner(i % w, w) && inner(i / w, h)) {
                let (color, alpha) = self.straight(pixel);
                let [r, g, b] = color.map(|c| self.encoded(c));
                sum += alpha * (0.3 * r + 0.59 * g + 0.11 * b) + (1.0 - alpha) * 0.4;
                count += 1.0;
            }
        }
        sum / f64::max(count, 1.0)
    }

    fn encoded(&self, linear: f32) -> f64 {
        let x = f64::from(linear).clamp(0.0, 1.0);
        match self.encode {
            Encode::Srgb => linear_to_srgb(x),
            Encode::None => x,
        }
    }

    fn decoded(&self, shown: f64) -> f64 {
        match self.encode {
            Encode::Srgb => srgb_to_linear(shown),
            Encode::None => shown,
        }
    }

    /// Returns the bytes that each pixel is shown by, its opacity last; colours are not premultiplied.
    pub fn shown(&self) -> Vec<[u8; 4]> {
        let byte = |x: f64| (255.0 * x.clamp(0.0, 1.0)).round() as u8;
        let shown = |&pixel: &[f32; 4]| {
            let ([r, g, b], alpha) = self.straight(pixel);
            [byte(self.encoded(r)), byte(self.encoded(g)), byte(self.encoded(b)), byte(alpha)]
        };
        self.pixels.iter().map(shown).collect()
    }

    /// Returns the picture.
    pub fn into_frame(self) -> Frame {
        Frame::new(self.size, self.pixels, None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mask of a whole pixel at the origin.
    fn dot() -> Mask {
        let mut mask = Mask::new([0.0, 0.0], [1.0, 1.0]);
        mask.add_rectangle([0.0, 0.0], [1.0, 1.0]);
        mask
    }

    #[test]
    fn half_of_white_over_black_is_the_middle_of_the_screens_scale() {
        let mut canvas = Canvas::new([1, 1], [0.0; 3]);
        canvas.paint(&dot(), [1.0; 3], 0.5);
        let [r, _, _, a] = canvas.into_frame().pixel(0, 0);
        assert!((linear_to_srgb(f64::from(r)) - 0.5).abs() < 1e-6 && a == 1.0);
    }

    #[test]
    fn ink_on_nothing_keeps_its_colour_and_makes_opacity() {
        let frame = Frame::new([2, 1], vec![[0.0; 4], [0.25, 0.0, 0.0, 0.5]], None);
        let mut canvas = Canvas::over(&frame, None, Encode::Srgb);
        canvas.paint(&dot(), [1.0; 3], 0.5);
        let drawn = canvas.into_frame();
        assert_eq!(drawn.pixel(0, 0), [0.5; 4], "premultiplied white");
        assert_eq!(drawn.pixel(1, 0), frame.pixel(1, 0), "not drawn on");
    }

    #[test]
    fn what_is_not_drawn_on_keeps_its_bits_and_the_rest_has_its_background() {
        let frame = Frame::new([2, 1], vec![[0.1, 0.2, 0.3, 0.4]; 2], None);
        let mut canvas = Canvas::over(&frame, Some([1.0, 0.0, 0.0]), Encode::None);
        canvas.paint(&dot(), [0.0, 0.0, 1.0], 0.5);
        let drawn = canvas.into_frame();
        let [r, g, b, a] = drawn.pixel(0, 0);
        for (found, right) in [(r, 0.35), (g, 0.1), (b, 0.65), (a, 1.0)] {
            assert!((found - right).abs() < 1e-6, "{:?}", drawn.pixel(0, 0));
        }
        assert_eq!(drawn.pixel(1, 0), frame.pixel(1, 0));
    }
}
