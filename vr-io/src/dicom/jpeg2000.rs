//! JPEG 2000 in DICOM (PS3.5 2024, annex A.4.4; ISO/IEC 15444-1): lossless and lossy, up to 16 bits.

use std::io;

use dicom_toolkit_jpeg2000::{DecodeSettings, Image};

use super::image::Shape;
use crate::encoding::invalid;

/// Most pixels of a frame: nothing that a scanner makes is larger, and decoding takes some twenty bytes for each.
const MAX_PIXELS: usize = 1 << 26;
/// Places in a code stream: the number of components, and the first one's type, behind the markers SOC and SIZ and the sizes.
const COMPONENTS: usize = 40;
const FIRST_COMPONENT: usize = 42;
const SIGNED: u8 = 0x80;

/// Decodes a frame: little endian, the numbers of a pixel together.
pub(super) fn decode(coded: &[u8], shape: &Shape) -> io::Result<Vec<u8>> {
    if !coded.starts_with(&[0xff, 0x4f, 0xff, 0x51]) {
        return Err(invalid("no code stream: it must begin with the markers SOC and SIZ".into()));
    }
    let cut_off = || invalid("the code stream is cut off".into());
    let components = coded.get(COMPONENTS..FIRST_COMPONENT).ok_or_else(cut_off)?;
    let components = usize::from(u16::from_be_bytes([components[0], components[1]]));
    if components != shape.samples {
        let message = format!("{components} samples a pixel, not {} as the header says", shape.samples);
        return Err(invalid(message));
    }
    // Each has its type, and its distances of pixels.
    let kinds = coded.get(FIRST_COMPONENT..FIRST_COMPONENT + 3 * components).ok_or_else(cut_off)?;
    let first = *kinds.first_chunk::<3>().ok_or_else(cut_off)?;
    if kinds.as_chunks::<3>().0.iter().any(|kind| *kind != first) || first[1..] != [1, 1] {
        return Err(invalid("samples of different types or resolutions; they must be alike".into()));
    }
    let (is_signed, bits) = (first[0] & SIGNED != 0, u32::from(first[0] & !SIGNED) + 1);
    let wanted = shape.numbers.scalar.bytes();
    if bits > 16 || bits as usize > 8 * wanted || wanted > 2 {
        return Err(invalid(format!(
            "samples of {bits} bits, not of {} at most as the header says",
            8 * wanted.min(2)
        )));
    }
    // The decoder gives numbers from 0 on: signed ones are read as if they were unsigned, which adds half of their range.
    let mut coded = coded.to_vec();
    for kind in coded[FIRST_COMPONENT..FIRST_COMPONENT + 3 * components].as_chunks_mut::<3>().0 {
        kind[0] &= !SIGNED;
    }
    let settings = DecodeSettings { resolve_palette_indices: false, strict: true, target_resolution: None };
    let damaged = |e: dicom_toolkit_jpeg2000::error::DecodeError| invalid(e.to_string());
    let image = Image::new(&coded, &settings).map_err(damaged)?;
    let (width, height) = (image.width() as usize, image.height() as usize);
    if (width, height) != (shape.columns, shape.rows) || width * height > MAX_PIXELS {
        let (columns, rows) = (shape.columns, shape.rows);
        let message =
            format!("{width}x{height} pixels, not {columns}x{rows} as Columns and Rows say, of {MAX_PIXELS} at most");
        return Err(invalid(message));
    }
    let decoded = image.decode_native().map_err(damaged)?;
    let stored: Vec<u16> = match decoded.bytes_per_sample {
        1 => decoded.data.iter().copied().map(u16::from).collect(),
        _ => decoded.data.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).collect(),
    };
    if stored.len() != width * height * components {
        return Err(invalid(format!("{} numbers of {width}x{height} pixels", stored.len())));
    }
    let half = if is_signed { 1u16 << (bits - 1) } else { 0 };
    let numbers = stored.into_iter().map(|n| n.wrapping_sub(half));
    Ok(if wanted == 1 { numbers.map(|n| n as u8).collect() } else { numbers.flat_map(u16::to_le_bytes).collect() })
}

#[cfg(test)]
mod tests {
    use dicom_toolkit_jpeg2000::{EncodeOptions, encode};

    use super::*;
    use crate::dicom::image::Numbers;
    use crate::scalar::ScalarType;

    const SIZE: (usize, usize) = (37, 24);

    fn shape(samples: usize, scalar: ScalarType, bits: u32) -> Shape {
        let numbers = Numbers { scalar, shift: 0, bits, needs_masking: false };
        Shape { rows: SIZE.1, columns: SIZE.0, samples, planar: false, numbers }
    }

    fn code(bytes: &[u8], samples: u8, bits: u8, signed: bool) -> Vec<u8> {
        encode(bytes, SIZE.0 as u32, SIZE.1 as u32, samples, bits, signed, &EncodeOptions::default()).unwrap()
    }

    fn ramp(first: i32, last: i32) -> impl Iterator<Item = i32> {
        let count = (SIZE.0 * SIZE.1) as i32;
        (0..count).map(move |i| first + (last - first) * ((i * 7) % count) / (count - 1))
    }

    #[test]
    fn lossless_frames_come_back_with_their_signs() {
        let unsigned: Vec<u8> = ramp(0, 4095).flat_map(|v| (v as u16).to_le_bytes()).collect();
        assert_eq!(decode(&code(&unsigned, 1, 12, false), &shape(1, ScalarType::U16, 12)).unwrap(), unsigned);
        let signed: Vec<u8> = ramp(-2048, 2047).flat_map(|v| (v as i16).to_le_bytes()).collect();
        assert_eq!(decode(&code(&signed, 1, 16, true), &shape(1, ScalarType::I16, 16)).unwrap(), signed);
        let bytes: Vec<u8> = ramp(0, 255).map(|v| v as u8).collect();
        assert_eq!(decode(&code(&bytes, 1, 8, false), &shape(1, ScalarType::U8, 8)).unwrap(), bytes);
        let colors: Vec<u8> = bytes.iter().flat_map(|&v| [v, 255 - v, v / 2]).collect();
        assert_eq!(decode(&code(&colors, 3, 8, false), &shape(3, ScalarType::U8, 8)).unwrap(), colors);
    }

    #[test]
    fn what_the_header_does_not_say_is_refused() {
        let bytes: Vec<u8> = ramp(0, 255).map(|v| v as u8).collect();
        let code = code(&bytes, 1, 8, false);
        let refused = |shape| decode(&code, &shape).unwrap_err().to_string();
        let other = Shape { rows: 23, ..shape(1, ScalarType::U8, 8) };
        assert!(refused(other).contains("37x24 pixels, not 37x23"));
        assert!(refused(shape(3, ScalarType::U8, 8)).contains("1 samples a pixel, not 3"));
        assert!(decode(b"\x89PNG", &shape(1, ScalarType::U8, 8)).unwrap_err().to_string().contains("SOC"));
        // Damage is an error or another picture, never a panic.
        for at in (0..code.len()).step_by(3) {
            let mut bad = code.clone();
            bad[at] ^= 0xff;
            let _ = decode(&bad, &shape(1, ScalarType::U8, 8));
            let _ = decode(&code[..at], &shape(1, ScalarType::U8, 8));
        }
    }
}
