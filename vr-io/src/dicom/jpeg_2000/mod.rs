//! JPEG 2000, without loss and with, of 1 to 16 bits (DICOM PS3.5 2024, annex A.4.4; ITU-T T.800), by the crate `hayro-jpeg2000`.
//!
//! Claims on memory are checked before it is called, since it believes them.

mod header;
#[cfg(test)]
mod tests;

use std::io;

use hayro_jpeg2000::{DecodeError, DecodeSettings, DecoderContext, Image};

use super::coded_frame::pack;
use super::image::Shape;
use crate::encoding::invalid;

use header::{Header, code_stream};

/// Decodes a frame: little endian, the numbers of a pixel together. Components that the code itself transformed (YBR_RCT, YBR_ICT) become RGB.
pub(super) fn decode(coded: &[u8], shape: &Shape) -> io::Result<Vec<u8>> {
    let code = code_stream(coded)?;
    let Header { frame, signed } = Header::read(code)?;
    frame.check(shape)?;
    // A stream that ends early would else give a blurred picture without a word.
    let settings = DecodeSettings { resolve_palette_indices: false, strict: true, target_resolution: None };
    let refused = |e: DecodeError| invalid(e.to_string());
    let image = Image::new(code, &settings).map_err(refused)?;
    let mut context = DecoderContext::default();
    let decoded = image.decode(&mut context).map_err(refused)?;
    let planes: Vec<&[f32]> = decoded.components().iter().map(|c| c.samples()).collect();
    let pixels = frame.columns * frame.rows;
    if planes.len() != frame.samples || planes.iter().any(|plane| plane.len() != pixels) {
        return Err(invalid(format!("{} components, not {}x{} each", planes.len(), frame.columns, frame.rows)));
    }

    // Numbers come as if none were negative; loss may put them outside of their range.
    let max = ((1 << frame.bits) - 1) as f32;
    let zero = if signed { 1 << (frame.bits - 1) } else { 0 };
    let number = |x: f32| x.round().clamp(0.0, max) as i32 - zero;
    Ok(pack(&planes, number, frame.bits, shape.numbers.scalar))
}
