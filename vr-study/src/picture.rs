//! Pictures of a page: PNGs in base 64.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use vr_core::Frame;
use vr_io::{PngOptions, encode_png};

use crate::error_colors;

/// Returns the PNG of a frame before a background.
pub(crate) fn encode_picture(frame: &Frame, background: [f32; 3]) -> String {
    STANDARD.encode(encode_png(frame, &PngOptions { background, ..PngOptions::default() }))
}

/// Returns the PNG of the errors of all pixels, row by row, in the colours of [`error_colors`].
pub(crate) fn encode_errors(size: [u32; 2], errors: &[f64]) -> String {
    let colors = errors.iter().map(|&e| {
        let [r, g, b] = error_colors::color(e);
        [r, g, b, 1.0]
    });
    STANDARD.encode(encode_png(&Frame::new(size, colors.collect(), None), &PngOptions::default()))
}
