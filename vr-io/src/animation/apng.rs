//! Animated PNG.

use super::{Film, Output, ticks};
use crate::error::WriteError;
use crate::maker;

/// Writes all frames, without loss.
pub(super) fn write(out: &mut dyn Output, film: &Film<'_>) -> Result<(), WriteError> {
    let failed = |e: png::EncodingError| match e {
        png::EncodingError::IoError(e) => film.io(e),
        other => film.failed(other),
    };
    let [width, height] = film.size;
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(if film.channels == 4 { png::ColorType::Rgba } else { png::ColorType::Rgb });
    encoder.set_depth(if film.bits == 16 { png::BitDepth::Sixteen } else { png::BitDepth::Eight });
    let count = u32::try_from(film.frames.len()).map_err(|e| film.failed(e))?;
    encoder.set_animated(count, if film.options.repeats { 0 } else { 1 }).map_err(failed)?;
    let (numerator, denominator) = ticks::delay(film.options.fps);
    encoder.set_frame_delay(numerator, denominator).map_err(failed)?;
    // With opacity, a frame replaces the one before.
    encoder.set_blend_op(png::BlendOp::Source).map_err(failed)?;
    encoder.add_itxt_chunk(maker::PNG_KEY.to_owned(), maker::MAKER.to_owned()).map_err(failed)?;
    let mut writer = encoder.write_header().map_err(failed)?;
    film.each((0.0, 1.0), |_, still| writer.write_image_data(&still.bytes).map_err(failed))?;
    writer.finish().map_err(failed)
}
