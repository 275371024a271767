//! Frames as PNG: before a background, encoded for a screen, in 8 or 16 bits.

use std::io::Write;
use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};
use png::text_metadata::ITXtChunk;
use serde::{Deserialize, Serialize};
use vr_core::Frame;
use vr_core::transfer::linear_to_srgb;

use crate::atomic::write_bytes;
use crate::error::WriteError;
use crate::{maker, png_texts};

/// Options of a PNG.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PngOptions {
    /// Bits per channel.
    pub depth: PngDepth,
    /// Encoding of the numbers in the file.
    pub encode: Encode,
    /// Linear radiance behind everything, added as rgb + (1 − α)·background.
    pub background: [f32; 3],
    /// Keeps α, with colours that are not premultiplied (as PNG has them); there is no background then.
    pub alpha: bool,
}

impl Default for PngOptions {
    /// 8 bits, sRGB, before black.
    fn default() -> Self {
        Self { depth: PngDepth::Eight, encode: Encode::Srgb, background: [0.0; 3], alpha: false }
    }
}

/// Bits per channel of a PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PngDepth {
    /// 8 bits.
    #[default]
    Eight,
    /// 16 bits.
    Sixteen,
}

/// Encoding of the numbers in a PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Encode {
    /// The sRGB curve, as screens expect.
    #[default]
    Srgb,
    /// Linear light as it is, which is what VTK shows.
    None,
}

/// Writes a frame as PNG.
///
/// # Errors
/// A [`WriteError`] naming the file; no part of it is left behind then.
pub fn write_png(path: impl AsRef<Path>, frame: &Frame, options: &PngOptions) -> Result<(), WriteError> {
    let path = path.as_ref();
    let bytes = encode_samples(frame.size(), &samples(frame, options), &[])
        .map_err(|message| WriteError::Encode { path: path.into(), message })?;
    write_bytes(path, &bytes)
}

/// A frame as the bytes of a PNG.
///
/// # Panics
/// Panics if the frame has no pixels: there is no such PNG.
pub fn encode_png(frame: &Frame, options: &PngOptions) -> Vec<u8> {
    encode_samples(frame.size(), &samples(frame, options), &[]).expect("memory takes every picture that has pixels")
}

/// A picture that is bytes for a screen already, red, green, blue and opacity of each pixel, as the bytes of a PNG.
///
/// # Panics
/// Panics if there are no pixels, or not four bytes for each.
pub fn encode_rgba_png(size: [u32; 2], rgba: &[u8]) -> Vec<u8> {
    assert_eq!(rgba.len() as u64, 4 * u64::from(size[0]) * u64::from(size[1]), "four bytes a pixel");
    let samples = Samples { alpha: true, numbers: Numbers::Eight(rgba.to_vec()) };
    encode_samples(size, &samples, &[]).expect("memory takes every picture that has pixels")
}

/// Channels of a PNG, pixel by pixel.
pub(crate) struct Samples {
    /// True if α is the fourth channel.
    pub alpha: bool,
    /// The numbers.
    pub numbers: Numbers,
}

/// Numbers of a PNG.
pub(crate) enum Numbers {
    /// In 8 bits.
    Eight(Vec<u8>),
    /// In 16 bits.
    Sixteen(Vec<u16>),
}

/// Makes a PNG's numbers of a frame.
pub(crate) fn samples(frame: &Frame, options: &PngOptions) -> Samples {
    let channels = channels(frame, options);
    let numbers = match options.depth {
        PngDepth::Eight => Numbers::Eight(channels.map(|x| (x * 255.0).round() as u8).collect()),
        PngDepth::Sixteen => Numbers::Sixteen(channels.map(|x| (x * 65535.0).round() as u16).collect()),
    };
    Samples { alpha: options.alpha, numbers }
}

/// The bytes of a PNG, in which its maker stands, and some texts.
///
/// # Errors
/// The reason why there is no such PNG: a picture without pixels, a text that is too long.
pub(crate) fn encode_samples(size: [u32; 2], samples: &Samples, texts: &[ITXtChunk]) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    encode(&mut bytes, size, samples).map_err(|e| e.to_string())?;
    let texts = [&[ITXtChunk::new(maker::PNG_KEY, maker::MAKER)], texts].concat();
    png_texts::with_texts(&bytes, &texts)
}

/// Writes to anything: a copy of the encoder for each kind of output would cost the compiler much.
fn encode(out: &mut dyn Write, [width, height]: [u32; 2], samples: &Samples) -> Result<(), ImageError> {
    let encoder = PngEncoder::new(out);
    match &samples.numbers {
        Numbers::Eight(bytes) => {
            let color = if samples.alpha { ExtendedColorType::Rgba8 } else { ExtendedColorType::Rgb8 };
            encoder.write_image(bytes, width, height, color)
        }
        Numbers::Sixteen(numbers) => {
            let color = if samples.alpha { ExtendedColorType::Rgba16 } else { ExtendedColorType::Rgb16 };
            // `image` takes 16-bit channels in the machine's byte order.
            encoder.write_image(bytemuck::cast_slice(numbers), width, height, color)
        }
    }
}

/// The numbers of the file in [0, 1], pixel by pixel; NaN counts as 0.
fn channels(frame: &Frame, options: &PngOptions) -> impl Iterator<Item = f64> {
    let encode = match options.encode {
        Encode::Srgb => |x: f64| linear_to_srgb(x.clamp(0.0, 1.0)),
        Encode::None => |x: f64| x.clamp(0.0, 1.0),
    };
    let PngOptions { background, alpha, .. } = *options;
    let count = if alpha { 4 } else { 3 };
    frame.pixels().iter().flat_map(move |&[r, g, b, a]| {
        let [r, g, b, a] = [r, g, b, a].map(|x| if x.is_nan() { 0.0 } else { f64::from(x) });
        let color = |c: f64, behind: f32| match (alpha, a) {
            (true, 0.0) => 0.0,
            (true, _) => c / a,
            (false, _) => c + (1.0 - a) * f64::from(behind),
        };
        let rgb = [color(r, background[0]), color(g, background[1]), color(b, background[2])].map(encode);
        [rgb[0], rgb[1], rgb[2], a.clamp(0.0, 1.0)].into_iter().take(count)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(pixels: Vec<[f32; 4]>, options: PngOptions) -> image::DynamicImage {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.png");
        let frame = Frame::new([pixels.len() as u32, 1], pixels, None);
        write_png(&path, &frame, &options).unwrap();
        image::load_from_memory_with_format(&std::fs::read(path).unwrap(), image::ImageFormat::Png).unwrap()
    }

    #[test]
    fn the_background_is_behind() {
        let options = PngOptions { encode: Encode::None, background: [1.0, 0.0, 0.0], ..PngOptions::default() };
        let image = written(vec![[0.0, 0.25, 0.0, 0.75], [0.0, 0.0, 0.0, 1.0]], options);
        assert_eq!(image.to_rgb8().into_raw(), [64, 64, 0, 0, 0, 0]);
    }

    #[test]
    fn srgb_and_what_is_out_of_range() {
        let image = written(vec![[0.214_041_14, 2.0, f32::NAN, 1.0]], PngOptions::default());
        assert_eq!(image.to_rgb8().into_raw(), [128, 255, 0]);
    }

    #[test]
    fn sixteen_bits_keep_one_part_in_65535() {
        let options = PngOptions { depth: PngDepth::Sixteen, encode: Encode::None, ..PngOptions::default() };
        let image = written(vec![[0.5, 1.0 / 65535.0, 1.0, 1.0]], options);
        assert_eq!(image.to_rgb16().into_raw(), [32768, 1, 65535]);
    }

    #[test]
    fn alpha_is_kept_with_straight_colours() {
        let options = PngOptions { encode: Encode::None, alpha: true, ..PngOptions::default() };
        let image = written(vec![[0.2, 0.0, 0.4, 0.4], [0.0; 4]], options);
        assert_eq!(image.to_rgba8().into_raw(), [128, 0, 255, 102, 0, 0, 0, 0]);
    }
}
