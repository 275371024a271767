//! One frame of an animation, read back from its PNG.

use std::io::BufReader;
use std::path::Path;

use image::DynamicImage;
use image::codecs::png::PngDecoder;

use crate::error::WriteError;
use crate::regular_file;

/// A picture of 3 or 4 channels of 8 or 16 bits.
pub(super) struct Still {
    pub size: [u32; 2],
    /// 3, or 4 with opacity.
    pub channels: u8,
    /// 8 or 16.
    pub bits: u8,
    /// Row by row; 16 bits are big-endian, as PNG has them.
    pub bytes: Vec<u8>,
}

impl Still {
    /// Reads a PNG file.
    ///
    /// # Errors
    /// A [`WriteError`] naming the file: one that is not there, or is no PNG of a frame.
    pub fn read(path: &Path) -> Result<Self, WriteError> {
        let file = regular_file::open(path).map_err(|source| WriteError::Io { path: path.into(), source })?;
        let wrong = |message: String| WriteError::Encode { path: path.into(), message };
        // The decoder of PNG alone, from a file as everywhere: each kind of reader is another copy of all that decodes.
        let picture = PngDecoder::new(BufReader::new(file)).and_then(DynamicImage::from_decoder);
        let picture = picture.map_err(|e| wrong(e.to_string()))?;
        let size = [picture.width(), picture.height()];
        let big_endian = |values: Vec<u16>| values.into_iter().flat_map(u16::to_be_bytes).collect();
        let (channels, bits, bytes) = match picture {
            DynamicImage::ImageRgb8(picture) => (3, 8, picture.into_raw()),
            DynamicImage::ImageRgba8(picture) => (4, 8, picture.into_raw()),
            DynamicImage::ImageRgb16(picture) => (3, 16, big_endian(picture.into_raw())),
            DynamicImage::ImageRgba16(picture) => (4, 16, big_endian(picture.into_raw())),
            _ => return Err(wrong("a frame has red, green and blue".to_owned())),
        };
        Ok(Self { size, channels, bits, bytes })
    }
}
