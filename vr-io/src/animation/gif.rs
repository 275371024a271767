//! GIF: one palette for all frames, and of each frame what has changed.

use std::borrow::Cow;

use gif::{DisposalMethod, Encoder, EncodingError, Extension, Frame, Repeat};

use super::dither::Ditherer;
use super::palette::{COLORS, ColorCount};
use super::still::Still;
use super::{Film, Output, ticks::ticks};
use crate::error::WriteError;
use crate::maker::MAKER;

/// Index of a pixel that is as it was in the frame before.
const AS_BEFORE: u8 = COLORS as u8;

/// Writes all frames: counts their colours in a first pass, and draws them with the palette in a second one.
pub(super) fn write(out: &mut dyn Output, film: &Film<'_>) -> Result<(), WriteError> {
    let failed = |e: EncodingError| match e {
        EncodingError::Io(e) => film.io(e),
        other => film.failed(other),
    };
    // Choose the palette.
    let mut count = ColorCount::new();
    film.each((0.0, 0.3), |_, still| {
        count.add(pixels(&still));
        Ok(())
    })?;
    let palette = count.palette();

    // A global palette has as many entries as fill a power of two, of which the last one is shown nowhere.
    let mut table: Vec<u8> = palette.iter().flatten().copied().collect();
    table.resize(3 * (COLORS + 1), 0);
    let edges = film.size.map(|edge| edge as u16);
    let mut encoder = Encoder::new(out, edges[0], edges[1], &table).map_err(failed)?;
    encoder.write_raw_extension(Extension::Comment.into(), &[MAKER.as_bytes()]).map_err(failed)?;
    if film.options.repeats {
        encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
    }

    // Draw, and write what differs from the frame before.
    let mut ditherer = Ditherer::new(palette);
    let mut before: Option<Vec<u8>> = None;
    let width = film.size[0] as usize;
    film.each((0.3, 0.7), |i, still| {
        let places = (0..).map(|k: usize| [k % width, k / width]);
        let now: Vec<u8> = pixels(&still).iter().zip(places).map(|(&p, at)| ditherer.entry(p, at)).collect();
        let mut frame = match &before {
            None => Frame { width: edges[0], height: edges[1], buffer: Cow::Borrowed(&now), ..Frame::default() },
            Some(before) => changes(before, &now, width),
        };
        frame.delay = u16::try_from(ticks(i, film.options.fps, 100.0)).unwrap_or(u16::MAX);
        frame.dispose = DisposalMethod::Keep;
        encoder.write_frame(&frame).map_err(failed)?;
        before = Some(now);
        Ok(())
    })
}

/// The frame of what differs: the smallest box around it, in which the rest is as before.
fn changes(before: &[u8], now: &[u8], width: usize) -> Frame<'static> {
    let differing = || (0..now.len()).filter(|&i| before[i] != now[i]);
    let (top, bottom) = (differing().next().unwrap_or(0) / width, differing().next_back().unwrap_or(0) / width);
    let columns = differing().map(|i| i % width);
    // A frame has at least one pixel.
    let (left, right) = columns
        .fold(None, |ends, x| match ends {
            None => Some((x, x)),
            Some((low, high)) => Some((x.min(low), x.max(high))),
        })
        .unwrap_or((0, 0));
    let inside = (top..=bottom).flat_map(|y| (left..=right).map(move |x| y * width + x));
    let buffer: Vec<u8> = inside.map(|i| if before[i] == now[i] { AS_BEFORE } else { now[i] }).collect();
    Frame {
        left: left as u16,
        top: top as u16,
        width: (right - left + 1) as u16,
        height: (bottom - top + 1) as u16,
        transparent: Some(AS_BEFORE),
        buffer: Cow::Owned(buffer),
        ..Frame::default()
    }
}

/// The pixels of a picture of three channels.
fn pixels(still: &Still) -> &[[u8; 3]] {
    still.bytes.as_chunks().0
}
