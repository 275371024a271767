//! Animated WebP, without loss: pictures as `image-webp` encodes them, in a container of frames.
//!
//! The container is RIFF: a header `VP8X` with the size, `ANIM` with the loops, and an `ANMF` for each frame, around the picture's own
//! chunk, `VP8L`; last, `XMP ` names the maker (<https://developers.google.com/speed/webp/docs/riff_container>).

use std::io::SeekFrom;

use image_webp::{ColorType, WebPEncoder};

use super::{Film, Output, ticks::ticks};
use crate::error::WriteError;
use crate::maker;

/// Flags of `VP8X`.
const ANIMATION: u8 = 0x02;
const ALPHA: u8 = 0x10;
const METADATA: u8 = 0x04;
/// Flag of `ANMF`: the frame replaces what was there.
const NO_BLENDING: u8 = 0x02;

/// Writes all frames, without loss.
pub(super) fn write(out: &mut dyn Output, film: &Film<'_>) -> Result<(), WriteError> {
    let io = |e| film.io(e);
    let (alpha, color) = if film.channels == 4 { (ALPHA, ColorType::Rgba8) } else { (0, ColorType::Rgb8) };
    let size = film.size.map(|edge| u24(edge - 1)).concat();
    // The length of everything follows when it is known.
    out.write_all(b"RIFF\0\0\0\0WEBP").map_err(io)?;
    let mut length = 4 + chunk(out, *b"VP8X", &[&[ANIMATION | METADATA | alpha, 0, 0, 0], &size]).map_err(io)?;
    let loops = u16::from(!film.options.repeats).to_le_bytes();
    length += chunk(out, *b"ANIM", &[&[0; 4], &loops]).map_err(io)?;
    film.each((0.0, 1.0), |i, still| {
        let mut file = Vec::new();
        let [width, height] = still.size;
        WebPEncoder::new(&mut file).encode(&still.bytes, width, height, color).map_err(|e| film.failed(e))?;
        let picture = picture_chunk(&file).ok_or_else(|| film.failed("the encoder gave no lossless picture"))?;
        let duration = u24(ticks(i, film.options.fps, 1000.0));
        length += chunk(out, *b"ANMF", &[&[0; 6], &size, &duration, &[NO_BLENDING], picture]).map_err(io)?;
        Ok(())
    })?;
    let [before, behind] = maker::XMP.map(str::as_bytes);
    length += chunk(out, *b"XMP ", &[before, maker::MAKER.as_bytes(), behind]).map_err(io)?;
    let length = u32::try_from(length).map_err(|_| film.failed("would be longer than the 4 GiB that a WebP can be"))?;
    out.seek(SeekFrom::Start(4)).map_err(io)?;
    out.write_all(&length.to_le_bytes()).map_err(io)
}

/// Writes a chunk, padded to an even length; returns its length with name and padding.
fn chunk(out: &mut dyn Output, name: [u8; 4], parts: &[&[u8]]) -> std::io::Result<u64> {
    let length: usize = parts.iter().map(|part| part.len()).sum();
    let claimed = u32::try_from(length).map_err(std::io::Error::other)?;
    out.write_all(&name)?;
    out.write_all(&claimed.to_le_bytes())?;
    parts.iter().try_for_each(|part| out.write_all(part))?;
    out.write_all(&[0][..length % 2])?;
    Ok((8 + length + length % 2) as u64)
}

/// Returns the chunk of the picture in a WebP of one, with its name, length and padding.
fn picture_chunk(file: &[u8]) -> Option<&[u8]> {
    let mut rest = file.get(12..)?;
    loop {
        let length = u32::from_le_bytes(rest.get(4..8)?.try_into().ok()?) as usize;
        let end = 8 + length + length % 2;
        if rest.starts_with(b"VP8L") {
            return rest.get(..end);
        }
        rest = rest.get(end..)?;
    }
}

/// The lower 24 bits.
fn u24(number: u32) -> [u8; 3] {
    let [a, b, c, _] = number.to_le_bytes();
    [a, b, c]
}
