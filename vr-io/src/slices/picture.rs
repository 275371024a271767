//! One picture of a stack: its header, and its pixels.

use std::fmt;
use std::io::{self, BufReader};
use std::path::Path;

use image::codecs::bmp::BmpDecoder;
use image::codecs::pnm::PnmDecoder;
use image::error::ImageError;
use image::{ColorType, ImageDecoder, ImageFormat, ImageReader, Limits};

use crate::claim::check_claim;
use crate::error::{FieldError, FileError, FileErrorKind};
use crate::memory_folder;
use crate::regular_file::{self, RegularFile};
use crate::scalar::ScalarType;
use crate::tiff::{self, Spacing, decode_page, first_directory, first_page};

/// The kinds of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Tiff,
    Png,
    Jpeg,
    Bmp,
    Pnm,
}

impl Kind {
    pub const ALL: [Self; 5] = [Self::Tiff, Self::Png, Self::Jpeg, Self::Bmp, Self::Pnm];

    /// The kind that the ending of a name tells.
    pub fn of(path: &Path) -> Option<Self> {
        Some(match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "tif" | "tiff" => Self::Tiff,
            "png" => Self::Png,
            "jpg" | "jpeg" => Self::Jpeg,
            "bmp" => Self::Bmp,
            "pgm" | "ppm" | "pnm" => Self::Pnm,
            _ => return None,
        })
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Tiff => "TIFF",
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Bmp => "BMP",
            Self::Pnm => "PNM",
        }
    }

    pub fn format(self) -> &'static str {
        match self {
            Self::Tiff => "TIFF slices",
            Self::Png => "PNG slices",
            Self::Jpeg => "JPEG slices",
            Self::Bmp => "BMP slices",
            Self::Pnm => "PNM slices",
        }
    }

    pub fn encoding(self) -> &'static str {
        match self {
            Self::Tiff => "tiff",
            Self::Png => "png",
            Self::Jpeg => "jpeg",
            Self::Bmp => "bmp",
            Self::Pnm => "pnm",
        }
    }
}

/// Everything that a picture's header says about its numbers.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    pub kind: Kind,
    pub size: [usize; 2],
    /// Numbers per pixel.
    pub samples: usize,
    pub scalar: ScalarType,
    pub spacing: Spacing,
    /// True if the numbers are red, green, blue and perhaps opacity.
    pub is_color: bool,
    /// Bytes of the file.
    pub stored: u64,
    /// True if all first numbers come before all second ones.
    planar: bool,
    /// Largest number of a PNM file, to which its decoder stretches the others.
    maximum: Option<u32>,
    /// The greys that a BMP's numbers stand for.
    greys: Option<Vec<u8>>,
}

impl Picture {
    /// Reads the header of a picture.
    pub fn describe(path: &Path) -> Result<Self, FileError> {
        let stored = memory_folder::length(path).map_err(|e| FileError::new(path, e))?;
        let picture = match kind_of(path)? {
            Kind::Tiff => {
                let (page, more) = first_page(path)?;
                if more {
                    let allowed = "a slice has one; a stack in one file is named by itself";
                    return Err(FieldError::new("pages", "several", allowed).in_file(path));
                }
                let (samples, planar, is_color) = (page.samples, page.planar, page.is_color);
                let (size, scalar, spacing) = (page.size, page.scalar, page.resolution);
                Self {
                    kind: Kind::Tiff,
                    size,
                    samples,
                    scalar,
                    spacing,
                    is_color,
                    stored,
                    planar,
                    maximum: None,
                    greys: None,
                }
            }
            kind => {
                let decoder = open(path, kind)?.into_decoder().map_err(|e| refuse(path, kind, e))?;
                let (width, height) = decoder.dimensions();
                let greys = if kind == Kind::Bmp { bmp(path)?.1 } else { None };
                let (samples, scalar) =
                    if greys.is_some() { (1, ScalarType::U8) } else { numbers(path, decoder.color_type())? };
                let size = [width as usize, height as usize];
                let (spacing, planar) = (Spacing::default(), false);
                let is_color = samples > 2;
                let maximum = if kind == Kind::Pnm { Some(pnm_maximum(path)?) } else { None };
                Self { kind, size, samples, scalar, spacing, is_color, stored, planar, maximum, greys }
            }
        };
        let [width, height] = picture.size.map(|n| n as u64);
        let pixel = (picture.samples * picture.scalar.bytes()) as u64;
        check_claim(path, "size of the picture", (width * height).saturating_mul(pixel), stored)?;
        Ok(picture)
    }

    /// Bytes of all numbers; held against the length of the file in `describe`.
    fn bytes(&self) -> usize {
        self.size[0] * self.size[1] * self.samples * self.scalar.bytes()
    }

    /// True if both may be slices of one volume.
    pub fn is_like(&self, other: &Self) -> bool {
        let kind = |p: &Self| (p.size, p.samples, p.scalar, p.planar);
        kind(self) == kind(other)
    }
}

impl fmt::Display for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        write!(f, "{width}×{height} {}", self.scalar)?;
        if self.samples > 1 { write!(f, " with {} channels", self.samples) } else { Ok(()) }
    }
}

/// Bytes of one component of a picture, in the machine's order.
pub(super) fn decode(path: &Path, like: &Picture, component: usize) -> Result<Vec<u8>, FileError> {
    let [width, height] = like.size;
    let count = width * height;
    // The file may have changed since its header was read.
    let found = Picture::describe(path)?;
    if !found.is_like(like) {
        return Err(FieldError::new("slice", found, format!("must be {like}")).in_file(path));
    }
    if found.kind == Kind::Tiff {
        let mut out = Vec::new();
        let (offset, step) = if like.planar { (component * count, 1) } else { (component, like.samples) };
        decode_page(path, &mut tiff::open(path, like.bytes())?, offset, step, count, &mut out)?;
        return Ok(out);
    }
    let kind = found.kind;
    if let Some(greys) = &found.greys {
        let mut decoder = bmp(path)?.0;
        decoder.set_indexed_color(true);
        let mut pixels = vec![0; like.bytes()];
        if decoder.total_bytes() != pixels.len() as u64 {
            return Err(FieldError::new("slice", "another size", format!("must be {like}")).in_file(path));
        }
        decoder.read_image(&mut pixels).map_err(|e| refuse(path, kind, e))?;
        // An index beyond the palette is black, as in other programs.
        pixels.iter_mut().for_each(|p| *p = greys.get(usize::from(*p)).copied().unwrap_or(0));
        return Ok(pixels);
    }
    let decoder = open(path, kind)?.into_decoder().map_err(|e| refuse(path, kind, e))?;
    let mut pixels = vec![0; like.bytes()];
    if decoder.total_bytes() != pixels.len() as u64 {
        return Err(FieldError::new("slice", "another size", format!("must be {like}")).in_file(path));
    }
    decoder.read_image(&mut pixels).map_err(|e| refuse(path, kind, e))?;
    if let Some(maximum) = found.maximum {
        unstretch(&mut pixels, like.scalar, maximum);
    }
    if like.samples == 1 {
        return Ok(pixels);
    }
    let bytes = like.scalar.bytes();
    let of_pixel = pixels.chunks_exact(like.samples * bytes);
    Ok(of_pixel.flat_map(|p| p[component * bytes..][..bytes].iter().copied()).collect())
}

type BmpFile = BmpDecoder<BufReader<RegularFile>>;

/// The decoder of a BMP file, and the greys of its palette, if there is one and nothing in it has a colour.
fn bmp(path: &Path) -> Result<(BmpFile, Option<Vec<u8>>), FileError> {
    let file = regular_file::open(path).map_err(|e| FileError::new(path, e))?;
    let decoder = BmpDecoder::new(BufReader::new(file)).map_err(|e| refuse(path, Kind::Bmp, e))?;
    let grey = |&[r, g, b]: &[u8; 3]| (r == g && g == b).then_some(r);
    let greys = decoder.get_palette().and_then(|palette| palette.iter().map(grey).collect());
    Ok((decoder, greys))
}

/// The largest number that a PNM file states.
fn pnm_maximum(path: &Path) -> Result<u32, FileError> {
    let file = regular_file::open(path).map_err(|e| FileError::new(path, e))?;
    let decoder = PnmDecoder::new(BufReader::new(file)).map_err(|e| refuse(path, Kind::Pnm, e))?;
    Ok(decoder.into_inner().1.maximal_sample())
}

/// Brings the numbers of a PNM file back from where the decoder stretched them: 12 bits stay 12 bits. Exact, since stretching only spreads.
fn unstretch(pixels: &mut [u8], scalar: ScalarType, maximum: u32) {
    let back = |x: u32, full: u32| (u64::from(x) * u64::from(maximum) + u64::from(full / 2)) / u64::from(full);
    match scalar {
        ScalarType::U8 if maximum < 0xff => pixels.iter_mut().for_each(|p| *p = back((*p).into(), 0xff) as u8),
        ScalarType::U16 if maximum < 0xffff => {
            for pair in pixels.as_chunks_mut::<2>().0 {
                *pair = (back(u16::from_ne_bytes(*pair).into(), 0xffff) as u16).to_ne_bytes();
            }
        }
        _ => {}
    }
}

/// The kind that the first bytes tell; the name may lie.
fn kind_of(path: &Path) -> Result<Kind, FileError> {
    let head = crate::read::file_head(path).map_err(|e| FileError::new(path, e))?;
    match image::guess_format(&head) {
        Ok(ImageFormat::Tiff) => Ok(Kind::Tiff),
        Ok(ImageFormat::Png) => Ok(Kind::Png),
        Ok(ImageFormat::Jpeg) => Ok(Kind::Jpeg),
        Ok(ImageFormat::Bmp) => Ok(Kind::Bmp),
        Ok(ImageFormat::Pnm) => Ok(Kind::Pnm),
        // BigTIFF.
        _ if head.starts_with(b"II+\0") || head.starts_with(b"MM\0+") => Ok(Kind::Tiff),
        _ => {
            let supported = "TIFF, PNG, JPEG, BMP and PNM";
            Err(FileError::new(path, FileErrorKind::Unrecognised { supported }))
        }
    }
}

fn open(path: &Path, kind: Kind) -> Result<ImageReader<BufReader<RegularFile>>, FileError> {
    let mut file = regular_file::open(path).map_err(|e| FileError::new(path, e))?;
    if matches!(kind, Kind::Tiff) {
        first_directory::check(path, &mut file)?;
    }
    let mut reader = ImageReader::new(BufReader::new(file));
    reader.set_format(match kind {
        Kind::Tiff => ImageFormat::Tiff,
        Kind::Png => ImageFormat::Png,
        Kind::Jpeg => ImageFormat::Jpeg,
        Kind::Bmp => ImageFormat::Bmp,
        Kind::Pnm => ImageFormat::Pnm,
    });
    reader.limits(Limits::default());
    Ok(reader)
}

fn refuse(path: &Path, kind: Kind, error: ImageError) -> FileError {
    match error {
        ImageError::IoError(e) if e.kind() != io::ErrorKind::UnexpectedEof => FileError::new(path, e),
        e => FileError::new(path, FileErrorKind::Damaged { encoding: kind.name(), source: io::Error::other(e) }),
    }
}

/// Numbers per pixel, and their type.
fn numbers(path: &Path, color: ColorType) -> Result<(usize, ScalarType), FileError> {
    let samples = usize::from(color.channel_count());
    let scalar = match color {
        ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8 => ScalarType::U8,
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => ScalarType::U16,
        ColorType::Rgb32F | ColorType::Rgba32F => ScalarType::F32,
        other => {
            let allowed = "must be grey or RGB in 8, 16 or 32 bits";
            return Err(FieldError::new("colours", format_args!("{other:?}"), allowed).in_file(path));
        }
    };
    Ok((samples, scalar))
}
