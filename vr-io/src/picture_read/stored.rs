//! Pixels of a picture as its file holds them, so that two can be told apart to the last bit.

use std::path::Path;

use exr::prelude::{ReadChannels, ReadLayers};
use image::DynamicImage;
use vr_core::Frame;

use super::error::PictureError;
use super::{Opened, coded, exr as exr_reader, open};
use crate::digest::digest;
use crate::png::{Numbers, Samples};

/// Pixels of a picture, bit for bit as its file holds them, however they are packed there: a file that is compressed anew has the same ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredPixels {
    size: [u32; 2],
    kind: Kind,
    /// The pixels, one after the other.
    bytes: Vec<u8>,
}

/// Numbers of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Red, green, blue and α in 16 bits each; of a file of 8 bits each number twice, and α full where there is none.
    Integers,
    /// Red, green, blue and α as 32-bit floats.
    Floats,
    /// These, and depth.
    FloatsWithDepth,
}

impl Kind {
    fn bytes_per_pixel(self) -> usize {
        match self {
            Self::Integers => 8,
            Self::Floats => 16,
            Self::FloatsWithDepth => 20,
        }
    }
}

impl StoredPixels {
    /// Reads the pixels of a picture file of any format that [`crate::read_picture`] reads.
    ///
    /// # Errors
    /// Errors of [`crate::read_picture`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, PictureError> {
        let path = path.as_ref();
        match open(path)? {
            // What is checked there holds for all channels, depth among them.
            Opened::Exr(origin, file) => {
                let mut frame = exr_reader::read(origin, file)?.frame;
                if let Some(depth) = depth(path)?.filter(|depth| depth.len() == frame.pixels().len()) {
                    frame = Frame::new(frame.size(), frame.pixels().to_vec(), Some(depth));
                }
                Ok(Self::of_frame(&frame))
            }
            Opened::Coded(origin, file) => {
                let (format, image) = coded::decode(origin, file)?;
                Self::of_image(&image).ok_or_else(|| {
                    PictureError::unsupported(path, format, format!("colours of type {:?}", image.color()))
                })
            }
        }
    }

    /// Makes the pixels that an EXR file of a frame holds.
    pub(crate) fn of_frame(frame: &Frame) -> Self {
        let (kind, depth) = match frame.depth() {
            Some(depth) => (Kind::FloatsWithDepth, depth),
            None => (Kind::Floats, &[][..]),
        };
        let mut bytes = Vec::with_capacity(frame.pixels().len() * kind.bytes_per_pixel());
        for (i, pixel) in frame.pixels().iter().enumerate() {
            pixel.iter().chain(depth.get(i)).for_each(|x| bytes.extend(x.to_bits().to_le_bytes()));
        }
        Self { size: frame.size(), kind, bytes }
    }

    /// Makes the pixels that a PNG holds.
    pub(crate) fn of_samples(size: [u32; 2], samples: &Samples) -> Self {
        match (&samples.numbers, samples.alpha) {
            (Numbers::Eight(n), false) => Self::of_integers::<_, 3>(size, n, twice),
            (Numbers::Eight(n), true) => Self::of_integers::<_, 4>(size, n, twice),
            (Numbers::Sixteen(n), false) => Self::of_integers::<_, 3>(size, n, |x| x),
            (Numbers::Sixteen(n), true) => Self::of_integers::<_, 4>(size, n, |x| x),
        }
    }

    /// Takes a decoded picture; `None` for floats, which are no PNG's.
    fn of_image(image: &DynamicImage) -> Option<Self> {
        let size = [image.width(), image.height()];
        Some(match image {
            DynamicImage::ImageLuma8(i) => Self::of_integers::<_, 1>(size, i, twice),
            DynamicImage::ImageLumaA8(i) => Self::of_integers::<_, 2>(size, i, twice),
            DynamicImage::ImageRgb8(i) => Self::of_integers::<_, 3>(size, i, twice),
            DynamicImage::ImageRgba8(i) => Self::of_integers::<_, 4>(size, i, twice),
            DynamicImage::ImageLuma16(i) => Self::of_integers::<_, 1>(size, i, |x| x),
            DynamicImage::ImageLumaA16(i) => Self::of_integers::<_, 2>(size, i, |x| x),
            DynamicImage::ImageRgb16(i) => Self::of_integers::<_, 3>(size, i, |x| x),
            DynamicImage::ImageRgba16(i) => Self::of_integers::<_, 4>(size, i, |x| x),
            _ => return None,
        })
    }

    /// Takes pixels of N channels: grey, grey and α, RGB, or RGBA.
    fn of_integers<T: Copy, const N: usize>(size: [u32; 2], samples: &[T], widen: impl Fn(T) -> u16) -> Self {
        let (pixels, _) = samples.as_chunks::<N>();
        let mut bytes = Vec::with_capacity(pixels.len() * Kind::Integers.bytes_per_pixel());
        for pixel in pixels {
            let alpha = if N.is_multiple_of(2) { widen(pixel[N - 1]) } else { u16::MAX };
            let color = |c: usize| widen(pixel[if N < 3 { 0 } else { c }]);
            [color(0), color(1), color(2), alpha].iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        }
        Self { size, kind: Kind::Integers, bytes }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Hash of size and pixels, in hexadecimal digits.
    pub fn hash(&self) -> String {
        let [width, height] = self.size;
        digest(&format!("pixels {width} {height} {}", self.kind.bytes_per_pixel()), &[&self.bytes])
    }

    /// Returns the number of pixels that differ in any bit; `None` where the pictures differ in size or in what a pixel is.
    pub fn differing(&self, other: &Self) -> Option<u64> {
        if (self.size, self.kind) != (other.size, other.kind) {
            return None;
        }
        let length = self.kind.bytes_per_pixel();
        let pairs = self.bytes.chunks_exact(length).zip(other.bytes.chunks_exact(length));
        Some(pairs.filter(|(a, b)| a != b).count() as u64)
    }
}

/// Returns the number of 16 bits that stands for the same light as one of 8.
fn twice(x: u8) -> u16 {
    u16::from(x) * 257
}

/// Reads the channel Z of an EXR file, if it has one.
fn depth(path: &Path) -> Result<Option<Vec<f32>>, PictureError> {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .map_err(|error| PictureError::damaged(path, "EXR", error))?;
    let channels = image.layer_data.channel_data.list;
    Ok(channels.iter().find(|channel| channel.name.eq("Z")).map(|z| z.sample_data.values_as_f32().collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PngDepth, PngOptions, write_exr, write_png};

    fn frame(depth: bool) -> Frame {
        let pixels = vec![[0.1, 0.2, 0.3, 0.5], [0.0; 4], [f32::NAN, -0.0, 1e30, 1.0], [1.0; 4], [0.25; 4], [0.75; 4]];
        Frame::new([3, 2], pixels, depth.then(|| vec![1.0, 2.0, f32::INFINITY, 4.0, 5.0, 6.0]))
    }

    #[test]
    fn files_hold_what_frames_say() {
        let folder = tempfile::tempdir().unwrap();
        for depth in [false, true] {
            let path = folder.path().join("x.exr");
            write_exr(&path, &frame(depth)).unwrap();
            let stored = StoredPixels::read(&path).unwrap();
            assert_eq!(stored, StoredPixels::of_frame(&frame(depth)));
            assert_eq!(stored.kind == Kind::FloatsWithDepth, depth);
        }
        for (depth, alpha) in [(PngDepth::Eight, false), (PngDepth::Eight, true), (PngDepth::Sixteen, true)] {
            let path = folder.path().join("x.png");
            let options = PngOptions { depth, alpha, ..PngOptions::default() };
            write_png(&path, &frame(false), &options).unwrap();
            let made = StoredPixels::of_samples([3, 2], &crate::png::samples(&frame(false), &options));
            assert_eq!(StoredPixels::read(&path).unwrap(), made);
        }
    }

    #[test]
    fn packing_anew_changes_nothing_and_a_bit_does() {
        let folder = tempfile::tempdir().unwrap();
        let read = |name: &str, image: DynamicImage| {
            let path = folder.path().join(name);
            image.save(&path).unwrap();
            StoredPixels::read(path).unwrap()
        };
        let grey = image::GrayImage::from_raw(2, 2, vec![0, 7, 200, 255]).unwrap();
        let image = DynamicImage::ImageLuma8(grey);
        let own = read("grey.png", image.clone());
        for (name, again) in [("rgb.png", image.to_rgb8().into()), ("rgba.png", image.to_rgba8().into())] {
            let again: StoredPixels = read(name, again);
            assert_eq!((own.differing(&again), own.hash() == again.hash()), (Some(0), true), "{name}");
        }
        let mut other = image.to_rgb8();
        other.get_pixel_mut(1, 0).0[2] ^= 1;
        let other = read("other.png", other.into());
        assert_eq!((own.differing(&other), own.hash() == other.hash()), (Some(1), false));
        let wide = read("wide.png", image::GrayImage::from_raw(4, 1, vec![0, 7, 200, 255]).unwrap().into());
        assert_eq!(own.differing(&wide), None);
        assert_ne!(own.hash(), wide.hash());
    }
}
