//! Frames as the bytes that a screen is given, quickly: those of a PNG of 8 bits before a background.

use std::sync::LazyLock;

use vr_core::Frame;
use vr_core::parallel::each_part;
use vr_core::transfer::linear_to_srgb;

/// Cells of equal length in [0, 1] for which the byte at their beginning is kept. The curve rises by less than one byte in each: its steepest
/// slope is 12.92 · 255 = 3295.
const CELLS: usize = 4096;

/// Pixels that a thread converts at once.
const PART: usize = 1 << 14;

/// Bytes of linear light under the sRGB curve.
struct SrgbBytes {
    /// Smallest number that becomes a byte, by byte; infinite beyond the last one.
    thresholds: [f64; 257],
    /// Byte of the beginning of each cell.
    cells: [u8; CELLS + 1],
}

static SRGB_BYTES: LazyLock<SrgbBytes> = LazyLock::new(SrgbBytes::new);

/// Rounds as a PNG's numbers of 8 bits are ([`crate::encode_png`]).
fn rounded(linear: f64) -> u8 {
    (linear_to_srgb(linear.clamp(0.0, 1.0)) * 255.0).round() as u8
}

impl SrgbBytes {
    fn new() -> Self {
        let mut thresholds = [f64::INFINITY; 257];
        thresholds[0] = 0.0;
        for byte in 1..=255u8 {
            // The curve rises, and so do the bits of numbers that are not negative.
            let (mut below, mut above) = (0f64.to_bits(), 1f64.to_bits());
            while above - below > 1 {
                let middle = below + (above - below) / 2;
                if rounded(f64::from_bits(middle)) < byte { below = middle } else { above = middle }
            }
            thresholds[usize::from(byte)] = f64::from_bits(above);
        }
        let cells = std::array::from_fn(|i| rounded(i as f64 / CELLS as f64));
        Self { thresholds, cells }
    }

    fn byte(&self, linear: f64) -> u8 {
        let x = linear.clamp(0.0, 1.0);
        let mut byte = self.cells[(x * CELLS as f64) as usize];
        while x >= self.thresholds[usize::from(byte) + 1] {
            byte += 1;
        }
        byte
    }
}

/// Red, green, blue and 255 of each pixel before a background, under the sRGB curve: bit for bit the colours of the PNG that [`crate::encode_png`]
/// makes with the default options and that background. NaN counts as 0.
///
/// # Examples
/// ```
/// use vr_core::Frame;
///
/// let frame = Frame::new([1, 1], vec![[0.25, 0.0, 0.0, 0.5]], None);
/// assert_eq!(vr_io::screen_rgba(&frame, [0.0, 0.0, 1.0]), [137, 0, 188, 255]);
/// ```
pub fn screen_rgba(frame: &Frame, background: [f32; 3]) -> Vec<u8> {
    let table = &*SRGB_BYTES;
    let mut bytes = vec![255; 4 * frame.pixels().len()];
    let parts = bytes.chunks_mut(4 * PART).zip(frame.pixels().chunks(PART));
    each_part(parts, |_, (bytes, pixels)| {
        for (out, pixel) in bytes.chunks_exact_mut(4).zip(*pixels) {
            let [r, g, b, a] = pixel.map(|x| if x.is_nan() { 0.0 } else { f64::from(x) });
            for (c, light) in [r, g, b].into_iter().enumerate() {
                out[c] = table.byte(light + (1.0 - a) * f64::from(background[c]));
            }
        }
    });
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PngOptions, encode_png};

    #[test]
    fn bytes_are_those_of_a_png() {
        // Numbers next to every threshold, on a fine lattice, and out of range.
        let near = |x: f64| [x.next_down(), x, x.next_up()];
        let edges = SRGB_BYTES.thresholds.iter().take(256).flat_map(|&x| near(x));
        let lattice = (0..100_000).map(|i| f64::from(i) / 99_999.0);
        for x in edges.chain(lattice).chain([-1.0, 2.0]) {
            assert_eq!(SRGB_BYTES.byte(x), rounded(x), "{x:e}");
        }
    }

    #[test]
    fn a_picture_is_that_of_a_png() {
        let light = |i: u32| [0.1, 0.37, 1.3].map(|f| ((f * f64::from(i)).sin() * 0.7 + 0.3) as f32);
        let pixel = |i: u32| match i % 17 {
            0 => [f32::NAN, 0.5, 0.25, f32::NAN],
            n => [light(i)[0], light(i)[1], light(i)[2], n as f32 / 16.0],
        };
        let size = [173, 211];
        let frame = Frame::new(size, (0..size[0] * size[1]).map(pixel).collect(), None);
        let background = [0.1, 0.8, 0.004];
        let png = encode_png(&frame, &PngOptions { background, ..PngOptions::default() });
        let png = image::load_from_memory_with_format(&png, image::ImageFormat::Png).unwrap().to_rgba8().into_raw();
        assert!(screen_rgba(&frame, background) == png);
    }
}
