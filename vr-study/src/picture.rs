//! Pictures of a page: PNGs in base 64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use vr_core::Frame;
use vr_io::{PictureRecord, PngOptions, encode_png, encode_png_with_record};

use crate::error_colors;

/// Returns the PNG of a frame before a background, with a record if there is one that a text can hold.
pub(crate) fn encode_picture(frame: &Frame, background: [f32; 3], record: Option<PictureRecord>) -> String {
    let options = PngOptions { background, ..PngOptions::default() };
    let recorded = record.and_then(|record| encode_png_with_record(frame, &options, record).ok());
    STANDARD.encode(recorded.unwrap_or_else(|| encode_png(frame, &options)))
}

/// Returns the PNG of the errors of all pixels, row by row, in the colours of [`error_colors`].
pub(crate) fn encode_errors(size: [u32; 2], errors: &[f64]) -> String {
    let colors = errors.iter().map(|&e| {
        let [r, g, b] = error_colors::color(e);
        [r, g, b, 1.0]
    });
    STANDARD.encode(encode_png(&Frame::new(size, colors.collect(), None), &PngOptions::default()))
}
