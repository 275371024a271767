//! JPEG in DICOM: baseline and extended of 8 bits, and lossless up to 16 (DICOM PS3.5 2024, annex A.4.1; ISO/IEC 10918-1).

use std::io;

use jpeg_decoder::{CodingProcess, ColorTransform, Decoder, PixelFormat};

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
    if (width, height) != (shape.columns, shape.rows) {
        let (columns, rows) = (shape.columns, shape.rows);
        return Err(invalid(format!("{width}x{height} pixels, not {columns}x{rows} as Columns and Rows say")));
    }
    let (samples, bytes) = match info.pixel_format {
        PixelFormat::L8 => (1, 1),
        PixelFormat::L16 => (1, 2),
        PixelFormat::RGB24 => (3, 1),
        PixelFormat::CMYK32 => (4, 1),
    };
    let wanted = shape.numbers.scalar.bytes();
    if samples != shape.samples || bytes > wanted || wanted > 2 {
        let allowed = format!("not {} of {wanted} bytes as the header says", shape.samples);
        return Err(invalid(format!("{samples} samples of {bytes} bytes a pixel, {allowed}")));
    }
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
