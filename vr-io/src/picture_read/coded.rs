//! Pictures of integers, encoded for a screen: PNG, JPEG, TIFF, BMP and PNM.

use std::io::BufReader;

use image::error::{ImageError, LimitErrorKind};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use vr_core::Frame;
use vr_core::transfer::srgb_to_linear;

use super::error::PictureError;
use super::{BYTES_PER_BYTE, MAX_PIXELS, Origin, Picture, SampleKind};
use crate::png::Encode;
use crate::regular_file::RegularFile;
use crate::tiff::first_directory;

/// Reads a picture whose first bytes are not those of EXR.
pub(super) fn read(origin: Origin<'_>, file: BufReader<RegularFile>, encode: Encode) -> Result<Picture, PictureError> {
    let path = origin.path;
    let (format, image) = decode(origin, file)?;
    let color = image.color();
    let pixels = linear(&image, encode)
        .ok_or_else(|| PictureError::unsupported(path, format, format!("colours of type {color:?}")))?;
    Ok(Picture {
        frame: Frame::new([image.width(), image.height()], pixels, None),
        alpha: color.has_alpha(),
        samples: match color.bytes_per_pixel() / color.channel_count() {
            1 => SampleKind::Eight,
            2 => SampleKind::Sixteen,
            _ => SampleKind::Float,
        },
        format,
        layer: None,
    })
}

/// Decodes a picture whose first bytes are not those of EXR; returns the name of its format, too.
pub(super) fn decode(
    origin: Origin<'_>,
    mut file: BufReader<RegularFile>,
) -> Result<(&'static str, DynamicImage), PictureError> {
    let path = origin.path;
    if let Some(fault) =
        first_directory::fault(&mut file).map_err(|source| PictureError::Io { path: path.into(), source })?
    {
        return Err(PictureError::damaged(path, "TIFF", fault));
    }
    let mut reader = ImageReader::new(file)
        .with_guessed_format()
        .map_err(|source| PictureError::Io { path: path.into(), source })?;
    let format = match reader.format() {
        Some(ImageFormat::Png) => "PNG",
        Some(ImageFormat::Jpeg) => "JPEG",
        Some(ImageFormat::Tiff) => "TIFF",
        Some(ImageFormat::Bmp) => "BMP",
        Some(ImageFormat::Pnm) => "PNM",
        _ => return Err(PictureError::Unrecognised { path: path.into() }),
    };
    let mut limits = Limits::default();
    // The largest picture there may be, in the largest number type. (The struct cannot be built outside of its crate.)
    limits.max_alloc = Some(16 * MAX_PIXELS);
    reader.limits(limits);
    let refuse = |error: ImageError| match error {
        ImageError::Unsupported(e) => PictureError::unsupported(path, format, e),
        ImageError::IoError(source) if source.kind() != std::io::ErrorKind::UnexpectedEof => {
            PictureError::Io { path: path.into(), source }
        }
        // A limit other than on memory is the decoder's way to say that it cannot do this.
        ImageError::Limits(e) if matches!(e.kind(), LimitErrorKind::Unsupported { .. }) => {
            PictureError::unsupported(path, format, e)
        }
        e => PictureError::damaged(path, format, e),
    };
    let decoder = reader.into_decoder().map_err(refuse)?;
    let (width, height) = decoder.dimensions();
    let color = decoder.color_type();
    origin.check([width.into(), height.into()], color.bytes_per_pixel().into(), BYTES_PER_BYTE)?;
    Ok((format, DynamicImage::from_decoder(decoder).map_err(refuse)?))
}

/// Premultiplied linear RGBA of every pixel; `None` for number types that are not known here.
fn linear(image: &DynamicImage, encode: Encode) -> Option<Vec<[f32; 4]>> {
    // Every value that an integer can have is decoded once.
    let light = |values: usize| -> Vec<f64> {
        let decode = match encode {
            Encode::Srgb => srgb_to_linear,
            Encode::None => |x| x,
        };
        (0..values).map(|v| decode(v as f64 / (values - 1) as f64)).collect()
    };
    let eight = || {
        let light = light(1 << 8);
        move |c: u8| light[usize::from(c)]
    };
    let sixteen = || {
        let light = light(1 << 16);
        move |c: u16| light[usize::from(c)]
    };
    Some(match image {
        DynamicImage::ImageLuma8(i) => pixels::<_, 1>(i, eight(), 255.0),
        DynamicImage::ImageLumaA8(i) => pixels::<_, 2>(i, eight(), 255.0),
        DynamicImage::ImageRgb8(i) => pixels::<_, 3>(i, eight(), 255.0),
        DynamicImage::ImageRgba8(i) => pixels::<_, 4>(i, eight(), 255.0),
        DynamicImage::ImageLuma16(i) => pixels::<_, 1>(i, sixteen(), 65535.0),
        DynamicImage::ImageLumaA16(i) => pixels::<_, 2>(i, sixteen(), 65535.0),
        DynamicImage::ImageRgb16(i) => pixels::<_, 3>(i, sixteen(), 65535.0),
        DynamicImage::ImageRgba16(i) => pixels::<_, 4>(i, sixteen(), 65535.0),
        DynamicImage::ImageRgb32F(i) => pixels::<_, 3>(i, f64::from, 1.0),
        DynamicImage::ImageRgba32F(i) => pixels::<_, 4>(i, f64::from, 1.0),
        _ => return None,
    })
}

/// Pixels of N channels: grey, grey and α, RGB, or RGBA; α is the last one and counts to `opaque`.
fn pixels<T: Copy + Into<f64>, const N: usize>(samples: &[T], light: impl Fn(T) -> f64, opaque: f64) -> Vec<[f32; 4]> {
    let (pixels, _) = samples.as_chunks::<N>();
    let premultiplied = |pixel: &[T; N]| {
        let alpha = if N.is_multiple_of(2) { pixel[N - 1].into() / opaque } else { 1.0 };
        let color = |c: usize| (light(pixel[if N < 3 { 0 } else { c }]) * alpha) as f32;
        [color(0), color(1), color(2), alpha as f32]
    };
    pixels.iter().map(premultiplied).collect()
}
