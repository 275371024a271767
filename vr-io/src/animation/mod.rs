//! Animations: frames that are PNG files already, put together in one file.

mod apng;
mod dither;
mod gif;
mod palette;
mod still;
mod ticks;
mod webp;

use std::path::{Path, PathBuf};

use vr_core::Control;

use crate::atomic::{Output, write_whole};
use crate::error::{FieldError, WriteError};

use still::Still;

/// Format of an animation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnimationFormat {
    /// GIF: 255 colours for the whole animation, dithered.
    Gif,
    /// Animated PNG: no loss, 8 or 16 bits.
    Apng,
    /// WebP: no loss, 8 bits.
    WebP,
}

/// Speed of an animation, and its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AnimationOptions {
    /// Frames per second.
    pub fps: f64,
    /// True if it begins again when it is over, and so for ever.
    pub repeats: bool,
}

/// Slowest and fastest animation in frames per second.
const FPS: std::ops::RangeInclusive<f64> = 0.02..=240.0;

impl AnimationFormat {
    /// Returns the format that a file's name asks for: `.gif`, `.apng` or `.png`, or `.webp`.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_string_lossy().to_lowercase().as_str() {
            "gif" => Some(Self::Gif),
            "apng" | "png" => Some(Self::Apng),
            "webp" => Some(Self::WebP),
            _ => None,
        }
    }

    /// Returns the name in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gif => "GIF",
            Self::Apng => "animated PNG",
            Self::WebP => "WebP",
        }
    }

    /// Returns the most bits per channel that it holds.
    pub fn bits(self) -> u8 {
        if self == Self::Apng { 16 } else { 8 }
    }

    /// True if it holds opacities between 0 and 1.
    pub fn has_opacity(self) -> bool {
        self != Self::Gif
    }

    /// Checks that it can hold frames of a size at a speed.
    ///
    /// # Errors
    /// A [`FieldError`] naming the number that is out of range.
    pub fn check(self, size: [u32; 2], fps: f64) -> Result<(), FieldError> {
        /// Larger steps than this are all that a GIF's clock of 1/100 s can make: browsers show one step as ten.
        const MAX_GIF_FPS: f64 = 50.0;
        if !FPS.contains(&fps) {
            return Err(FieldError::new("fps", fps, "must be 0.02 to 240"));
        }
        if self == Self::Gif && fps > MAX_GIF_FPS {
            let allowed =
                "must be at most 50 in a GIF, whose clock counts hundredths of a second; .webp and .png are faster";
            return Err(FieldError::new("fps", fps, allowed));
        }
        let max_edge = match self {
            Self::Gif => 65_535,
            Self::Apng => u32::MAX,
            Self::WebP => 16_384,
        };
        if size.iter().any(|&edge| edge > max_edge) {
            let found = format!("{}x{}", size[0], size[1]);
            let allowed = format!("{} holds pictures of at most {max_edge} pixels a side", self.name());
            return Err(FieldError::new("size", found, allowed));
        }
        Ok(())
    }
}

/// Puts PNG files together in an animation, in the format that the name asks for; one frame is in memory at a time. `control` is told the
/// fraction done, and can cancel.
///
/// # Errors
/// A [`WriteError`] naming the animation or the frame: another name, frames of several sizes, a format that cannot hold them. Cancelled,
/// it is one of [`Interrupted`](std::io::ErrorKind::Interrupted). No part of the animation is left behind then.
pub fn write_animation(
    path: impl AsRef<Path>,
    frames: &[PathBuf],
    options: &AnimationOptions,
    control: &Control,
) -> Result<(), WriteError> {
    let path = path.as_ref();
    let wrong = |message: String| WriteError::Encode { path: path.into(), message };
    let format = AnimationFormat::of(path).ok_or_else(|| wrong("must be a .gif, .png, .apng or .webp".to_owned()))?;
    let first = frames.first().ok_or_else(|| wrong("an animation needs at least one frame".to_owned()))?;
    let first = Still::read(first)?;
    format.check(first.size, options.fps).map_err(|e| wrong(e.to_string()))?;
    let film = Film { path, frames, options, size: first.size, channels: first.channels, bits: first.bits, control };
    if first.bits > format.bits() {
        return Err(wrong(format!("{} holds 8 bits per channel, not {}", format.name(), first.bits)));
    }
    if first.channels == 4 && !format.has_opacity() {
        return Err(wrong("a pixel of a GIF is there or not: opacity needs .webp or .png".to_owned()));
    }
    write_whole(path, |out| match format {
        AnimationFormat::Gif => gif::write(out, &film),
        AnimationFormat::Apng => apng::write(out, &film),
        AnimationFormat::WebP => webp::write(out, &film),
    })
}

/// Frames on their way into a file.
struct Film<'a> {
    path: &'a Path,
    frames: &'a [PathBuf],
    options: &'a AnimationOptions,
    size: [u32; 2],
    channels: u8,
    bits: u8,
    control: &'a Control,
}

impl Film<'_> {
    /// Reads every frame in turn. `done` and `share` place the pass in the whole work.
    fn each(
        &self,
        (done, share): (f64, f64),
        mut take: impl FnMut(usize, Still) -> Result<(), WriteError>,
    ) -> Result<(), WriteError> {
        for (i, path) in self.frames.iter().enumerate() {
            if self.control.is_cancelled() {
                return Err(WriteError::Io { path: self.path.into(), source: std::io::ErrorKind::Interrupted.into() });
            }
            let still = Still::read(path)?;
            if (still.size, still.channels, still.bits) != (self.size, self.channels, self.bits) {
                let message = "differs from the first frame in size, channels or bits".to_owned();
                return Err(WriteError::Encode { path: path.clone(), message });
            }
            take(i, still)?;
            self.control.report(done + share * (i + 1) as f64 / self.frames.len() as f64);
        }
        Ok(())
    }

    /// Makes an error of the file that is written.
    fn failed(&self, message: impl std::fmt::Display) -> WriteError {
        WriteError::Encode { path: self.path.into(), message: message.to_string() }
    }

    fn io(&self, source: std::io::Error) -> WriteError {
        WriteError::Io { path: self.path.into(), source }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use image::{AnimationDecoder, ImageDecoder};

    use super::*;

    /// Frames of a bright spot that moves over a smooth ground, and their folder.
    fn frames(count: u32, alpha: bool) -> (tempfile::TempDir, Vec<PathBuf>, Vec<image::RgbaImage>) {
        let folder = tempfile::tempdir().unwrap();
        let mut pictures = Vec::new();
        let mut paths = Vec::new();
        for i in 0..count {
            let opacity = |x: u32| if alpha { (x * 6) as u8 } else { 255 };
            let picture = image::RgbaImage::from_fn(40, 30, |x, y| match (x / 4, y / 4) {
                (0, _) => image::Rgba([0, 0, 0, opacity(x)]),
                (k, 3) if k == i + 1 => image::Rgba([250, 240, 60, opacity(x)]),
                _ => image::Rgba([(x * 6) as u8, (y * 5) as u8, (x + 2 * y) as u8, opacity(x)]),
            });
            let path = folder.path().join(format!("{i}.png"));
            match alpha {
                true => picture.save(&path).unwrap(),
                false => image::DynamicImage::from(picture.clone()).to_rgb8().save(&path).unwrap(),
            }
            paths.push(path);
            pictures.push(picture);
        }
        (folder, paths, pictures)
    }

    fn written(name: &str, paths: &[PathBuf], folder: &Path, fps: f64, repeats: bool) -> Vec<u8> {
        let path = folder.join(name);
        write_animation(&path, paths, &AnimationOptions { fps, repeats }, &Control::default()).unwrap();
        fs::read(path).unwrap()
    }

    #[test]
    fn animated_pngs_hold_every_frame_without_loss() {
        for alpha in [false, true] {
            let (folder, paths, pictures) = frames(4, alpha);
            let bytes = written("x.png", &paths, folder.path(), 24.0, true);
            let decoder = image::codecs::png::PngDecoder::new(std::io::Cursor::new(&bytes)).unwrap();
            let read: Vec<image::Frame> = decoder.apng().unwrap().into_frames().collect_frames().unwrap();
            assert_eq!(read.len(), 4);
            for (frame, picture) in read.iter().zip(&pictures) {
                assert_eq!(frame.buffer(), picture);
                let (numerator, denominator) = frame.delay().numer_denom_ms();
                assert!((f64::from(numerator) / f64::from(denominator) - 1000.0 / 24.0).abs() < 0.01);
            }
        }
    }

    #[test]
    fn webp_holds_every_frame_without_loss() {
        for (alpha, repeats) in [(false, true), (true, false)] {
            let (folder, paths, pictures) = frames(5, alpha);
            let bytes = written("x.webp", &paths, folder.path(), 24.0, repeats);
            let mut decoder = image_webp::WebPDecoder::new(std::io::Cursor::new(&bytes)).unwrap();
            assert!(decoder.is_animated() && decoder.num_frames() == 5 && decoder.has_alpha() == alpha);
            let forever = matches!(decoder.loop_count(), image_webp::LoopCount::Forever);
            assert_eq!(forever, repeats);
            let mut total = 0;
            for picture in &pictures {
                let mut pixels = vec![0; decoder.output_buffer_size().unwrap()];
                total += decoder.read_frame(&mut pixels).unwrap();
                let expected = match alpha {
                    true => picture.as_raw().clone(),
                    false => image::DynamicImage::from(picture.clone()).to_rgb8().into_raw(),
                };
                assert!(pixels == expected);
            }
            assert_eq!(total, 208, "five frames of 1000/24 ms");
        }
    }

    #[test]
    fn gifs_keep_size_count_time_and_nearly_the_colours() {
        let (folder, paths, pictures) = frames(6, false);
        let bytes = written("x.gif", &paths, folder.path(), 24.0, true);
        let mut options = ::gif::DecodeOptions::new();
        options.set_color_output(::gif::ColorOutput::Indexed);
        let mut decoder = options.read_info(&bytes[..]).unwrap();
        assert_eq!((decoder.width(), decoder.height()), (40, 30));
        assert!(matches!(decoder.repeat(), ::gif::Repeat::Infinite));
        let palette = decoder.global_palette().unwrap().to_vec();
        let mut canvas = vec![0u8; 40 * 30];
        let (mut delay, mut count) = (0, 0);
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            for y in 0..usize::from(frame.height) {
                for x in 0..usize::from(frame.width) {
                    let index = frame.buffer[y * usize::from(frame.width) + x];
                    if Some(index) != frame.transparent {
                        canvas[(y + usize::from(frame.top)) * 40 + x + usize::from(frame.left)] = index;
                    }
                }
            }
            let picture = &pictures[count];
            let color = |i: usize| &palette[3 * usize::from(canvas[i])..][..3];
            // Black, the most common colour, is black; means over 4x4 pixels are near, as dithering wants.
            assert!((0..30).all(|y| color(40 * y) == [0, 0, 0]));
            for (by, bx) in (0..7).flat_map(|y| (1..10).map(move |x| (y, x))) {
                for c in 0..3 {
                    let cell = || (0..16).map(|k| (4 * bx + k % 4, 4 * by + k / 4));
                    let drawn: i32 = cell().map(|(x, y)| i32::from(color(40 * y + x)[c])).sum();
                    let wanted: i32 = cell().map(|(x, y)| i32::from(picture.get_pixel(x as u32, y as u32)[c])).sum();
                    assert!((drawn - wanted).abs() < 16 * 6, "{count} {bx} {by}: {drawn} {wanted}");
                }
            }
            delay += frame.delay;
            count += 1;
        }
        assert_eq!((count, delay), (6, 25), "six frames of 1/24 s are a quarter of a second");
        let once = written("y.gif", &paths, folder.path(), 24.0, false);
        assert!(!once.windows(11).any(|w| w == b"NETSCAPE2.0") && bytes.windows(11).any(|w| w == b"NETSCAPE2.0"));
    }

    #[test]
    fn few_colours_are_kept_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        let picture = image::RgbImage::from_fn(16, 10, |x, y| image::Rgb([x as u8 * 16, y as u8, 7]));
        let path = folder.path().join("0.png");
        picture.save(&path).unwrap();
        let bytes = written("x.gif", &[path], folder.path(), 10.0, true);
        let mut options = ::gif::DecodeOptions::new();
        options.set_color_output(::gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(&bytes[..]).unwrap();
        let frame = decoder.read_next_frame().unwrap().unwrap();
        assert_eq!(&*frame.buffer, image::DynamicImage::from(picture).to_rgba8().as_raw().as_slice());
    }

    #[test]
    fn what_a_format_cannot_hold_is_refused_in_words() {
        let (folder, paths, _) = frames(2, true);
        let control = Control::default();
        let refused = |name: &str, paths: &[PathBuf], fps: f64| {
            let options = AnimationOptions { fps, repeats: true };
            let error = write_animation(folder.path().join(name), paths, &options, &control).unwrap_err();
            assert!(!folder.path().join(name).exists());
            error.to_string()
        };
        assert!(refused("x.gif", &paths, 24.0).contains("opacity needs .webp or .png"));
        assert!(refused("x.gif", &paths, 60.0).contains("at most 50"));
        assert!(refused("x.webp", &paths, 0.0).contains("0.02 to 240"));
        assert!(refused("x.mp4", &paths, 24.0).contains(".gif"));
        assert!(refused("x.png", &[], 24.0).contains("at least one frame"));
        let other = folder.path().join("other.png");
        image::RgbImage::new(3, 3).save(&other).unwrap();
        assert!(refused("x.webp", &[paths[0].clone(), other], 24.0).contains("other.png: differs"));
        control.cancel_flag().store(true, std::sync::atomic::Ordering::Relaxed);
        assert!(refused("x.webp", &paths, 24.0).contains("cannot be written"));
        assert_eq!(AnimationFormat::of(Path::new("a/b.WEBP")), Some(AnimationFormat::WebP));
    }

    #[test]
    fn sixteen_bits_stay_in_animated_pngs() {
        let folder = tempfile::tempdir().unwrap();
        let picture = image::ImageBuffer::<image::Rgb<u16>, _>::from_fn(3, 2, |x, y| {
            image::Rgb([x as u16 * 257 + 1, y as u16, 65535])
        });
        let path = folder.path().join("0.png");
        picture.save(&path).unwrap();
        let bytes = written("x.apng", std::slice::from_ref(&path), folder.path(), 10.0, true);
        let decoder = image::codecs::png::PngDecoder::new(std::io::Cursor::new(&bytes)).unwrap();
        let mut raw = vec![0; decoder.total_bytes() as usize];
        decoder.read_image(&mut raw).unwrap();
        let expected: Vec<u8> = picture.into_raw().into_iter().flat_map(u16::to_ne_bytes).collect();
        assert_eq!(raw, expected);
        let options = AnimationOptions { fps: 10.0, repeats: true };
        let error = write_animation(folder.path().join("x.webp"), &[path], &options, &Control::default()).unwrap_err();
        assert!(error.to_string().contains("8 bits per channel, not 16"));
    }
}
