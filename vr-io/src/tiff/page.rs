//! Header of one page of a TIFF file: its directory.

use std::fmt;
use std::path::Path;

use tiff::ColorType;
use tiff::TiffResult;
use tiff::decoder::ifd::Value;
use tiff::decoder::{ChunkType, DecodingSampleType};
use tiff::tags::{CompressionMethod, Tag};

use crate::error::{FieldError, FileError};
use crate::length_unit::{LengthUnit, MILLIMETRE};
use crate::scalar::ScalarType;

use super::{Spacing, TiffFile, open, refuse};

/// Everything that a directory says about the numbers of its page.
#[derive(Clone, Debug)]
pub(crate) struct Page {
    /// Place in the file's chain of directories, from 0.
    pub index: usize,
    pub size: [usize; 2],
    /// Numbers per pixel.
    pub samples: usize,
    pub scalar: ScalarType,
    /// True if all first numbers come before all second ones.
    pub planar: bool,
    pub compression: &'static str,
    /// Offset of the numbers, where they are one run of the file, as they are.
    pub start: Option<u64>,
    pub resolution: Spacing,
    /// True if the numbers are red, green, blue and perhaps opacity.
    pub is_color: bool,
    palette: bool,
    white_is_zero: bool,
}

/// The header of the first page, and whether there are more.
pub(crate) fn first_page(path: &Path) -> Result<(Page, bool), FileError> {
    let mut file = open(path, 0)?;
    Ok((Page::read(path, &mut file, 0)?, file.more_images()))
}

impl Page {
    /// Reads the header of the page at which `file` stands.
    pub fn read(path: &Path, file: &mut TiffFile, index: usize) -> Result<Self, FileError> {
        let tiff = |e| refuse(path, e);
        let (width, height) = file.dimensions().map_err(tiff)?;
        let color = file.colortype().map_err(tiff)?;
        let samples = match color {
            ColorType::Gray(_) | ColorType::Palette(_) => 1,
            ColorType::GrayA(_) => 2,
            ColorType::RGB(_) => 3,
            ColorType::RGBA(_) => 4,
            ColorType::Multiband { num_samples, .. } => usize::from(num_samples),
            other => {
                let allowed = "must be grey, RGB, a palette, or these with other channels";
                return Err(
                    FieldError::new("PhotometricInterpretation", format_args!("{other:?}"), allowed).in_file(path)
                );
            }
        };
        let bits = color.bit_depth();
        if !matches!(bits, 8 | 16 | 32 | 64) {
            return Err(FieldError::new("BitsPerSample", bits, "must be 8, 16, 32 or 64").in_file(path));
        }
        let layout = file.image_buffer_layout().map_err(tiff)?;
        let (scalar, as_stored) = match layout.sample_type {
            Some(DecodingSampleType::U8) => (ScalarType::U8, true),
            Some(DecodingSampleType::I8) => (ScalarType::I8, true),
            Some(DecodingSampleType::U16) => (ScalarType::U16, true),
            Some(DecodingSampleType::I16) => (ScalarType::I16, true),
            Some(DecodingSampleType::U32) => (ScalarType::U32, true),
            Some(DecodingSampleType::I32) => (ScalarType::I32, true),
            Some(DecodingSampleType::U64) => (ScalarType::U64, true),
            Some(DecodingSampleType::I64) => (ScalarType::I64, true),
            Some(DecodingSampleType::F32) => (ScalarType::F32, true),
            Some(DecodingSampleType::F64) => (ScalarType::F64, true),
            // Half floats become floats.
            Some(DecodingSampleType::F16) => (ScalarType::F32, false),
            None => {
                let allowed = "must be integers or floats of 8 to 64 bits";
                return Err(
                    FieldError::new("SampleFormat", format_args!("{:?}", layout.sample_format), allowed).in_file(path)
                );
            }
        };
        let method = file.find_tag_unsigned::<u16>(Tag::Compression).map_err(tiff)?.unwrap_or(1);
        let photometric = file.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation).map_err(tiff)?.unwrap_or(1);
        let planar = file.find_tag_unsigned::<u16>(Tag::PlanarConfiguration).map_err(tiff)?.unwrap_or(1) == 2;
        let white_is_zero = photometric == 0;
        let mut page = Self {
            index,
            size: [width as usize, height as usize],
            samples,
            scalar,
            planar: planar && samples > 1,
            compression: compression(method),
            start: None,
            resolution: resolution(file).map_err(tiff)?,
            is_color: matches!(color, ColorType::RGB(_) | ColorType::RGBA(_)),
            palette: matches!(color, ColorType::Palette(_)),
            white_is_zero,
        };
        if method == 1 && as_stored && !white_is_zero && file.get_chunk_type() == ChunkType::Strip {
            page.start = run(file, page.page_bytes()).map_err(tiff)?;
        }
        Ok(page)
    }

    /// Bytes of the page's numbers.
    pub fn page_bytes(&self) -> u64 {
        let [width, height] = self.size.map(|n| n as u64);
        // Both sides are below 2^32.
        (width * height).saturating_mul(self.samples as u64).saturating_mul(self.scalar.bytes() as u64)
    }

    /// True if the pages may be slices of one volume.
    pub fn is_like(&self, other: &Self) -> bool {
        let kind = |p: &Self| (p.size, p.samples, p.scalar, p.planar, p.white_is_zero);
        kind(self) == kind(other)
    }

    /// Adds what is worth knowing about the numbers.
    pub fn note(&self, notes: &mut Vec<String>) {
        if self.palette {
            notes.push("pixels are indices into a palette: the indices are taken, not the colours".into());
        }
        if self.white_is_zero {
            notes.push("zero is white in this file: values are turned round, so that zero is black".into());
        }
    }
}

impl fmt::Display for Page {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        write!(f, "{width}×{height} {}", self.scalar)?;
        if self.samples > 1 { write!(f, " with {} channels", self.samples) } else { Ok(()) }
    }
}

/// The text that describes the image, in whatever bytes it has.
pub(super) fn description(file: &mut TiffFile) -> TiffResult<Option<String>> {
    let Some(entry) = file.image_ifd().find_entry(Tag::ImageDescription) else { return Ok(None) };
    let length = file.inner().get_ref().length().unwrap_or(0);
    let Some(count) = usize::try_from(entry.count().min(length)).ok() else { return Ok(None) };
    let mut bytes = vec![0; count];
    let read = file.image_ifd().find_tag_bytes(Tag::ImageDescription, &mut bytes, 0)?.unwrap_or(0);
    bytes.truncate(read);
    let text = bytes.split(|&b| b == 0).next().unwrap_or_default();
    // ImageJ before 1.53 wrote µ as Latin-1 has it.
    Ok(Some(match str::from_utf8(text) {
        Ok(text) => text.to_owned(),
        Err(_) => text.iter().map(|&b| char::from(b)).collect(),
    }))
}

/// Offset of the strips, if they are one run of `bytes`.
fn run(file: &mut TiffFile, bytes: u64) -> TiffResult<Option<u64>> {
    let offsets = file.get_tag_u64_vec(Tag::StripOffsets)?;
    let Some(counts) = file.find_tag_unsigned_vec::<u64>(Tag::StripByteCounts)? else { return Ok(None) };
    let Some(&start) = offsets.first().filter(|_| offsets.len() == counts.len()) else { return Ok(None) };
    let mut end = start;
    for (&offset, &count) in offsets.iter().zip(&counts) {
        if offset != end {
            return Ok(None);
        }
        let Some(next) = end.checked_add(count) else { return Ok(None) };
        end = next;
    }
    // ImageJ counts the bytes of one strip wrongly where they are many; one strip is a run in any case.
    Ok((end - start == bytes || offsets.len() == 1).then_some(start))
}

/// The resolution tags: pixels per centimetre, per inch, or per something that another place names.
fn resolution(file: &mut TiffFile) -> TiffResult<Spacing> {
    let mut per_unit = |tag| -> TiffResult<Option<f64>> {
        Ok(match file.find_tag(tag)? {
            Some(Value::Rational(n, d)) => Some(f64::from(n) / f64::from(d)),
            _ => None,
        }
        .filter(|r| r.is_finite() && *r > 0.0))
    };
    let found: [Option<f64>; 2] = [per_unit(Tag::XResolution)?, per_unit(Tag::YResolution)?];
    let [Some(x), Some(y)] = found else { return Ok(Spacing::default()) };
    let unit = match file.find_tag_unsigned::<u16>(Tag::ResolutionUnit)?.unwrap_or(2) {
        2 => LengthUnit::from_name("in"),
        3 => LengthUnit::from_name("cm"),
        _ => None,
    };
    let millimetres = unit.map_or(1.0, |u| u.metres / MILLIMETRE.metres);
    let is_screen = unit.is_some_and(|u| u.symbol == "in") && x == y && [72.0, 96.0, 300.0].contains(&x);
    Ok(Spacing {
        plane: Some([millimetres / x, millimetres / y]),
        slices: None,
        unit: unit.map(|_| MILLIMETRE.symbol.to_owned()),
        by: "resolution tags",
        is_screen,
    })
}

fn compression(method: u16) -> &'static str {
    match CompressionMethod::from_u16(method) {
        Some(CompressionMethod::None) => "raw",
        Some(CompressionMethod::LZW) => "lzw",
        Some(CompressionMethod::Deflate | CompressionMethod::OldDeflate) => "deflate",
        Some(CompressionMethod::PackBits) => "packbits",
        Some(CompressionMethod::JPEG | CompressionMethod::ModernJPEG) => "jpeg",
        Some(CompressionMethod::Huffman | CompressionMethod::Fax3 | CompressionMethod::Fax4) => "fax",
        _ => "tiff",
    }
}
