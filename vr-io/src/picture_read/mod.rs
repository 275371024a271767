//! Pictures in: what this and other programs have drawn, as linear light, so that they can be compared.

mod coded;
mod error;
mod exr;
mod stored;

use std::io::{BufReader, Read, Seek};
use std::path::Path;

use vr_core::{Frame, memory};

use crate::png::Encode;
use crate::regular_file::{self, RegularFile};

pub use error::PictureError;
pub use stored::StoredPixels;

/// Pictures with more pixels than this (8192 × 8192) are refused.
pub const MAX_PIXELS: u64 = 1 << 26;

/// Most decoders give at most this many bytes for one byte of the file; a header that claims more lies.
///
/// The best that they do is about 2700 (LZW) and 1365 (JPEG); Deflate reaches 1032, and the lossless codecs of EXR no more. Only a
/// BMP or a fax-coded TIFF may leave out lines altogether, and such a file, if almost nothing is in it, is refused.
const BYTES_PER_BYTE: u64 = 1 << 12;

/// A picture from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Premultiplied linear RGBA, without depth; α is 1 where the file has none. Floats of a file are kept as they are, also
    /// those that are not finite.
    pub frame: Frame,
    /// True if the file has an α channel.
    pub alpha: bool,
    /// Number type of a channel, which limits how finely colours differ.
    pub samples: SampleKind,
    /// The file's format: `EXR`, `PNG`, `JPEG`, `TIFF`, `BMP` or `PNM`.
    pub format: &'static str,
    /// Name of the layer of an EXR file, where it has one.
    pub layer: Option<String>,
}

/// Number type of a channel in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleKind {
    /// Integers of up to 8 bits.
    Eight,
    /// Integers of 16 bits.
    Sixteen,
    /// Floats of 16 bits.
    Half,
    /// Floats of 32 bits (or, in an EXR file, integers of 32 bits).
    Float,
}

/// Reads a picture as linear light with premultiplied α. The format is told by what the file holds, not by its name.
///
/// * **EXR**: flat pictures in half or full floats, scan lines or tiles, all codecs but JPEG 2000 and Zstandard, linear and
///   premultiplied as they are. Channels R, G, B and A (or Y and A) of the first layer that has them, plain ones first; the
///   display window, with nothing (0, 0, 0, 0) where there are no data.
/// * **PNG**, **JPEG**, **TIFF**, **BMP**, **PNM**: grey or RGB, with or without α, in up to 16 bits. `encode` says whether the
///   integers hold sRGB or linear light; α is linear, and colours are taken as not premultiplied. Floats (RGB and RGBA in TIFF) are
///   linear. Gamma and colour profiles that a file carries are not looked at, and a JPEG that is cut off is grey at the bottom.
///
/// # Errors
/// A [`PictureError`] naming the file: one that cannot be opened, is of another format, damaged or cut off, claims more than it
/// can hold or more than [`MAX_PIXELS`], or has no colours.
pub fn read_picture(path: impl AsRef<Path>, encode: Encode) -> Result<Picture, PictureError> {
    match open(path.as_ref())? {
        Opened::Exr(origin, file) => exr::read(origin, file),
        Opened::Coded(origin, file) => coded::read(origin, file, encode),
    }
}

/// A file that is open at its beginning, by the library that reads it.
enum Opened<'a> {
    Exr(Origin<'a>, BufReader<RegularFile>),
    Coded(Origin<'a>, BufReader<RegularFile>),
}

fn open(path: &Path) -> Result<Opened<'_>, PictureError> {
    let io = |source| PictureError::Io { path: path.into(), source };
    let mut file = regular_file::open(path).map_err(io)?;
    let length = file.length().map_err(io)?;
    let mut head = Vec::new();
    (&mut file).take(4).read_to_end(&mut head).map_err(io)?;
    file.rewind().map_err(io)?;
    let (origin, file) = (Origin { path, length }, BufReader::new(file));
    let is_exr = head == ::exr::meta::magic_number::BYTES;
    Ok(if is_exr { Opened::Exr(origin, file) } else { Opened::Coded(origin, file) })
}

/// The file that is being read, and its length.
#[derive(Clone, Copy)]
struct Origin<'a> {
    path: &'a Path,
    length: u64,
}

impl Origin<'_> {
    /// Checks the size that a header claims against the length of the file, and against the memory that is left: called before anything is allocated for it.
    fn check(self, size: [u64; 2], bytes_per_pixel: u64, bytes_per_byte: u64) -> Result<(), PictureError> {
        let pixels = size[0].saturating_mul(size[1]);
        let max_bytes = self.length.saturating_mul(bytes_per_byte);
        if pixels == 0 || pixels > MAX_PIXELS || pixels.saturating_mul(bytes_per_pixel) > max_bytes {
            return Err(PictureError::Size { path: self.path.into(), size, length: self.length });
        }
        self.check_memory(pixels, bytes_per_pixel)
    }

    /// Checks that there is memory for the pixels as the file has them, and for those of a frame.
    fn check_memory(self, pixels: u64, bytes_per_pixel: u64) -> Result<(), PictureError> {
        let bytes = pixels.saturating_mul(bytes_per_pixel.saturating_add(size_of::<[f32; 4]>() as u64));
        memory::check("the picture", bytes).map_err(|source| PictureError::Memory { path: self.path.into(), source })
    }
}
