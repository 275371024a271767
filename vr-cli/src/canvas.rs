//! Canvas: a picture that is put together from parts.

use vr_core::Frame;

/// Canvas of opaque pixels in linear RGB.
pub struct Canvas {
    size: [u32; 2],
    pixels: Vec<[f32; 4]>,
}

impl Canvas {
    /// Makes a canvas of one colour.
    pub fn new(size: [u32; 2], color: [f32; 3]) -> Self {
        let [r, g, b] = color;
        Self { size, pixels: vec![[r, g, b, 1.0]; size[0] as usize * size[1] as usize] }
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

    /// Returns the picture.
    pub fn into_frame(self) -> Frame {
        Frame::new(self.size, self.pixels, None)
    }
}
