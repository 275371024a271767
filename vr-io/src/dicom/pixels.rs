//! The voxels of a stack: as they lie in the files, or decoded slice by slice.

use std::io::{self, BufReader, Read, Seek, SeekFrom};

use flate2::read::DeflateDecoder;
use vr_core::Calibration;
use vr_core::parallel;

use super::encapsulated::{self, Fragment};
use super::image::{Image, Numbers};
#[cfg(feature = "jpeg2000")]
use super::jpeg_2000;
use super::transfer_syntax::FrameCoding;
use super::{jpeg, jpeg_ls, rle};
use crate::encoding::Encoding;
use crate::error::{FileError, FileErrorKind};
use crate::payload::{Payload, Segment, Skip};
use crate::polled::Polled;
use crate::regular_file;
use crate::scalar::{Endian, ScalarType};
use crate::source::{Decoded, Source};

/// A slice: a frame of one of the images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SliceId {
    pub image: usize,
    pub frame: usize,
}

/// Source of the voxels of these slices, one after another, and what leads from its numbers to values.
pub(super) fn source(images: Vec<Image>, slices: &[SliceId], notes: &mut Vec<String>) -> (Source, Calibration) {
    let rescale = |s: &SliceId| images[s.image].frames[s.frame].rescale;
    let first = rescale(&slices[0]);
    let uniform = slices.iter().all(|s| rescale(s) == first);
    if !uniform {
        let slopes = || slices.iter().map(|s| rescale(s)[0]);
        let (low, high) = (slopes().fold(f64::INFINITY, f64::min), slopes().fold(f64::NEG_INFINITY, f64::max));
        notes.push(format!(
            "RescaleSlope and RescaleIntercept differ between slices (slopes from {low} to {high}): applied to each, values are held as f32"
        ));
    }
    let calibration =
        if uniform { Calibration { slope: first[0], intercept: first[1] } } else { Calibration::default() };

    let shape = images[0].shape;
    let as_they_are = |image: &Image| {
        image.syntax == images[0].syntax && image.syntax.frames == FrameCoding::Native && !image.syntax.deflated
    };
    if uniform && images.iter().all(as_they_are) && !images.iter().any(|i| i.shape.numbers.needs_masking) {
        return (payload(&images, slices).into(), calibration);
    }
    let encoding = match (&images[0].syntax.frames, images[0].syntax.deflated) {
        (FrameCoding::Rle, _) => "RLE",
        (FrameCoding::Jpeg, _) => "JPEG",
        (FrameCoding::JpegLs, _) => "JPEG-LS",
        (FrameCoding::Jpeg2000, _) => "JPEG 2000",
        (_, true) => "deflate",
        _ => "raw",
    };
    let scalar = if uniform { shape.numbers.scalar } else { ScalarType::F32 };
    let slices = slices.iter().map(|s| (*s, (!uniform).then(|| rescale(s)))).collect();
    let files = images.iter().map(|i| i.path.clone()).collect();
    let decoder = SliceDecoder { images, slices };
    let decode = Box::new(move |_: &mut Vec<String>| decoder.decode());
    (Decoded { decode, scalar, endian: Endian::Little, encoding, files }.into(), calibration)
}

/// One run of numbers a file where all its frames are there in their order, else one a frame.
fn payload(images: &[Image], slices: &[SliceId]) -> Payload {
    let shape = images[0].shape;
    let per_file = images[0].frames.len();
    let whole = |run: &[SliceId]| {
        let image = run[0].image;
        images[image].frames.len() == per_file
            && run.len() == per_file
            && run.iter().enumerate().all(|(frame, s)| *s == SliceId { image, frame })
    };
    let run = if slices.chunks(per_file).all(whole) { per_file } else { 1 };
    let segments = slices.chunks(run).map(|run| {
        let image = &images[run[0].image];
        let start = image.pixels.offset + run[0].frame as u64 * shape.frame_bytes();
        Segment { path: image.path.clone(), start, lines: 0, skip: Skip::Part(0) }
    });
    Payload {
        segments: segments.collect(),
        encoding: Encoding::Raw,
        scalar: shape.numbers.scalar,
        endian: images[0].syntax.endian(),
        excess_is_error: false,
        hint: "",
    }
}

struct SliceDecoder {
    images: Vec<Image>,
    /// With slope and intercept where these are applied here.
    slices: Vec<(SliceId, Option<[f64; 2]>)>,
}

/// Layout of the frames in a file.
enum Frames {
    Native,
    Inflated(Vec<u8>),
    Coded(Vec<Vec<Fragment>>),
}

impl SliceDecoder {
    fn decode(self) -> Result<Vec<u8>, FileError> {
        // Memory grows with what comes out, a few slices at a time.
        const AT_A_TIME: usize = 64;
        let found = parallel::try_collect(self.images.len(), |i| Self::find(&self.images[i]))?;
        let mut out = Vec::new();
        for slices in self.slices.chunks(AT_A_TIME) {
            let decoded = parallel::try_collect(slices.len(), |i| {
                let (slice, rescale) = &slices[i];
                let image = &self.images[slice.image];
                let bytes = frame(image, &found[slice.image], slice.frame);
                let bytes = bytes.map_err(|e| FileError::new(&image.path, e))?;
                Ok(convert(bytes, image, *rescale))
            })?;
            decoded.iter().for_each(|bytes| out.extend_from_slice(bytes));
        }
        Ok(out)
    }

    fn find(image: &Image) -> Result<Frames, FileError> {
        let in_file = |e: FileErrorKind| FileError::new(&image.path, e);
        if image.syntax.deflated {
            return inflate(image).map(Frames::Inflated).map_err(in_file);
        }
        match image.syntax.frames {
            FrameCoding::Native => Ok(Frames::Native),
            _ => encapsulated::frames(&image.path, image.pixels.offset, image.frames.len())
                .map(Frames::Coded)
                .map_err(in_file),
        }
    }
}

/// The voxels of a deflated file.
fn inflate(image: &Image) -> Result<Vec<u8>, FileErrorKind> {
    let damaged = |source: io::Error| FileErrorKind::Damaged { encoding: "deflate", source };
    let mut file = regular_file::open(&image.path)?;
    file.seek(SeekFrom::Start(image.start))?;
    let mut inflated = Polled::new(DeflateDecoder::new(BufReader::new(file)));
    io::copy(&mut inflated.by_ref().take(image.pixels.offset), &mut io::sink()).map_err(damaged)?;
    let claimed = image.shape.frame_bytes().saturating_mul(image.frames.len() as u64);
    let mut out = Vec::new();
    inflated.take(claimed).read_to_end(&mut out).map_err(damaged)?;
    if (out.len() as u64) < claimed {
        return Err(FileErrorKind::Length { claimed, found: out.len() as u64, hint: "" });
    }
    Ok(out)
}

/// The numbers of a frame, in the file's byte order, or little endian where they were coded.
fn frame(image: &Image, frames: &Frames, index: usize) -> Result<Vec<u8>, FileErrorKind> {
    let shape = &image.shape;
    let bytes = shape.frame_bytes();
    let start = index as u64 * bytes;
    match frames {
        Frames::Native => {
            let mut file = regular_file::open(&image.path)?;
            file.seek(SeekFrom::Start(image.pixels.offset + start))?;
            let mut out = Vec::new();
            file.take(bytes).read_to_end(&mut out)?;
            if (out.len() as u64) < bytes {
                return Err(FileErrorKind::Length { claimed: bytes, found: out.len() as u64, hint: "" });
            }
            Ok(out)
        }
        // All frames are there: checked where they were inflated.
        Frames::Inflated(all) => Ok(all[start as usize..(start + bytes) as usize].to_vec()),
        Frames::Coded(fragments) => {
            let coded = encapsulated::read(&image.path, &fragments[index])?;
            let damaged = |encoding| move |source| FileErrorKind::Damaged { encoding, source };
            match image.syntax.frames {
                FrameCoding::Rle => {
                    let pixels = shape.rows * shape.columns;
                    rle::decode(&coded, pixels, shape.samples, shape.numbers.scalar.bytes()).map_err(damaged("RLE"))
                }
                FrameCoding::JpegLs => jpeg_ls::decode(&coded, shape).map_err(damaged("JPEG-LS")),
                #[cfg(feature = "jpeg2000")]
                FrameCoding::Jpeg2000 => jpeg_2000::decode(&coded, shape).map_err(damaged("JPEG 2000")),
                _ => jpeg::decode(&coded, shape, &image.photometric).map_err(damaged("JPEG")),
            }
        }
    }
}

/// Little-endian numbers: with unused bits cleared or filled with the sign, and calibrated to f32 where that is asked for.
fn convert(mut bytes: Vec<u8>, image: &Image, rescale: Option<[f64; 2]>) -> Vec<u8> {
    let numbers = image.shape.numbers;
    let big = image.syntax.frames == FrameCoding::Native && image.syntax.endian() == Endian::Big;
    if big {
        bytes.chunks_exact_mut(numbers.scalar.bytes()).for_each(<[u8]>::reverse);
    }
    macro_rules! of_type {
        ($t:ty, $value:expr) => {{
            let value: fn($t, &Numbers) -> $t = $value;
            match rescale {
                None if !numbers.needs_masking => bytes,
                None => {
                    for b in bytes.as_chunks_mut().0 {
                        *b = value(<$t>::from_le_bytes(*b), &numbers).to_le_bytes();
                    }
                    bytes
                }
                Some([slope, intercept]) => bytes
                    .as_chunks()
                    .0
                    .iter()
                    .flat_map(|b| {
                        let stored = value(<$t>::from_le_bytes(*b), &numbers);
                        ((stored as f64 * slope + intercept) as f32).to_le_bytes()
                    })
                    .collect(),
            }
        }};
    }
    // Shifting up and down again clears what is above, or repeats the sign there.
    macro_rules! integer {
        ($t:ty) => {
            of_type!($t, |x, n| x << (<$t>::BITS - n.bits - n.shift) >> (<$t>::BITS - n.bits))
        };
    }
    match numbers.scalar {
        ScalarType::U8 => integer!(u8),
        ScalarType::I8 => integer!(i8),
        ScalarType::U16 => integer!(u16),
        ScalarType::I16 => integer!(i16),
        ScalarType::U32 => integer!(u32),
        ScalarType::I32 => integer!(i32),
        ScalarType::U64 => integer!(u64),
        ScalarType::I64 => integer!(i64),
        ScalarType::F32 => of_type!(f32, |x, _| x),
        ScalarType::F64 => of_type!(f64, |x, _| x),
    }
}
