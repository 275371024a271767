//! JPEG in DICOM: baseline and extended of 8 bits, and lossless up to 16 (DICOM PS3.5 2024, annex A.4.1; ISO/IEC 10918-1).

use std::io;

use jpeg_decoder::{CodingProcess, ColorTransform, Decoder, PixelFormat};

use super::coded_frame::CodedFrame;
use super::image::Shape;
use crate::encoding::invalid;

/// Pixels that a byte of code can stand for: a block of 64 needs two bits at least, and pixels at a quarter of the samples of colours.
const MAX_EXPANSION: u64 = 2048;

/// Decodes a frame: little endian, the numbers of a pixel together. Colours become RGB, unless they are called something else.
pub(super) fn decode(coded: &[u8], shape: &Shape, photometric: &str) -> io::Result<Vec<u8>> {
    let mut decoder = Decoder::new(coded);
    let refused = |e: jpeg_decoder::Error| invalid(e.to_string());
    decoder.read_info().map_err(refused)?;
    let info = decoder.info().ok_or_else(|| invalid("no frame".into()))?;
    let (width, height) = (usize::from(info.width), usize::from(info.height));
    let (samples, bytes) = match info.pixel_format {
        PixelFormat::L8 => (1, 1),
        PixelFormat::L16 => (1, 2),
        PixelFormat::RGB24 => (3, 1),
        PixelFormat::CMYK32 => (4, 1),
    };
    CodedFrame { columns: width, rows: height, samples, bits: 8 * bytes as u32 }.check(shape)?;
    let wanted = shape.numbers.scalar.bytes();
    if (width * height) as u64 > MAX_EXPANSION.saturating_mul(coded.len() as u64) {
        return Err(invalid(format!("{} bytes for {width}x{height} pixels", coded.len())));
    }
    if photometric == "RGB" && info.coding_process == CodingProcess::Lossless {
        decoder.set_color_transform(ColorTransform::RGB);
    }
    decoder.set_max_decoding_buffer_size(width * height * samples * bytes);
    let out = decoder.decode().map_err(refused)?;
    if out.len() != width * height * samples * bytes {
        return Err(invalid(format!("{} bytes of {width}x{height} pixels", out.len())));
    }
    Ok(match (bytes, wanted) {
        (1, 2) => out.iter().flat_map(|&x| [x, 0]).collect(),
        (2, _) => out.as_chunks().0.iter().flat_map(|b| u16::from_ne_bytes(*b).to_le_bytes()).collect(),
        _ => out,
    })
}

#[cfg(test)]
mod tests {
    use image::codecs::jpeg::JpegEncoder;
    use image::{ExtendedColorType, ImageEncoder};

    use super::*;
    use crate::dicom::image::Numbers;
    use crate::scalar::ScalarType;

    const SIZE: (usize, usize) = (24, 17);

    fn shape(samples: usize, scalar: ScalarType) -> Shape {
        let numbers = Numbers { scalar, shift: 0, bits: 8, needs_masking: false };
        Shape { rows: SIZE.1, columns: SIZE.0, samples, planar: false, numbers }
    }

    /// A ramp in every sample, and its code at the best quality.
    fn coded(samples: usize) -> (Vec<u8>, Vec<u8>) {
        let ramp = |x: usize, y: usize, c: usize| (40 + 5 * x + 3 * y + 20 * c) as u8;
        let pixels: Vec<u8> =
            (0..SIZE.1).flat_map(|y| (0..SIZE.0).flat_map(move |x| (0..samples).map(move |c| ramp(x, y, c)))).collect();
        let color = if samples == 1 { ExtendedColorType::L8 } else { ExtendedColorType::Rgb8 };
        let mut code = Vec::new();
        JpegEncoder::new_with_quality(&mut code, 100)
            .write_image(&pixels, SIZE.0 as u32, SIZE.1 as u32, color)
            .unwrap();
        (pixels, code)
    }

    #[test]
    fn frames_of_grey_and_of_colours() {
        for (samples, photometric) in [(1, "MONOCHROME2"), (3, "YBR_FULL_422")] {
            let (pixels, code) = coded(samples);
            let decoded = decode(&code, &shape(samples, ScalarType::U8), photometric).unwrap();
            assert_eq!(decoded.len(), pixels.len());
            let worst = decoded.iter().zip(&pixels).map(|(&a, &b)| a.abs_diff(b)).max();
            assert!(worst <= Some(3), "{samples}: {worst:?}");
        }
        // In a header of 16 bits, the same numbers.
        let (_, code) = coded(1);
        let bytes = decode(&code, &shape(1, ScalarType::U8), "MONOCHROME2").unwrap();
        let words = decode(&code, &shape(1, ScalarType::U16), "MONOCHROME2").unwrap();
        assert!(words.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).eq(bytes.into_iter().map(u16::from)));
    }

    #[test]
    fn what_the_header_does_not_say_is_refused() {
        let (_, code) = coded(1);
        let refused = |shape| decode(&code, &shape, "MONOCHROME2").unwrap_err().to_string();
        assert!(refused(Shape { rows: 16, ..shape(1, ScalarType::U8) }).contains("24x17 pixels, not 24x16"));
        assert!(refused(shape(3, ScalarType::U8)).contains("1 samples of 8 bits a pixel, not 3"));
        for cut in 0..code.len() / 2 {
            assert!(decode(&code[..cut], &shape(1, ScalarType::U8), "MONOCHROME2").is_err(), "{cut}");
        }
    }
}
