//! Pictures read: what this crate wrote comes back to rounding, what other programs write is understood, and what is damaged
//! is refused in one line.

use std::cell::Cell;
use std::path::Path;

use image::{DynamicImage, ImageFormat};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use vr_core::Frame;
use vr_core::transfer::{linear_to_srgb, srgb_to_linear};
use vr_io::{Encode, PictureError, PngDepth, PngOptions, SampleKind, read_picture, write};

/// Frames of ordinary light: premultiplied colours that α can carry.
fn frames() -> impl Strategy<Value = Frame> {
    (1u32..9, 1u32..9).prop_flat_map(|(w, h)| {
        let pixel = (0.0f32..=1.0, 0.0f32..=1.0, 0.0f32..=1.0, prop_oneof![0.0f32..=1.0, Just(0.0), Just(1.0)]);
        vec(pixel, (w * h) as usize).prop_map(move |pixels| {
            let premultiplied = pixels.into_iter().map(|(r, g, b, a)| [r * a, g * a, b * a, a]).collect();
            Frame::new([w, h], premultiplied, None)
        })
    })
}

fn options() -> impl Strategy<Value = PngOptions> {
    let depth = prop_oneof![Just(PngDepth::Eight), Just(PngDepth::Sixteen)];
    let encode = prop_oneof![Just(Encode::Srgb), Just(Encode::None)];
    (depth, encode, any::<bool>(), [0.0f32..=1.0, 0.0f32..=1.0, 0.0f32..=1.0])
        .prop_map(|(depth, encode, alpha, background)| PngOptions { depth, encode, alpha, background })
}

proptest! {
    #![proptest_config(Config { cases: 200, failure_persistence: None, ..Config::default() })]

    #[test]
    fn what_was_written_as_exr_comes_back_untouched(frame in frames()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.exr");
        write(&path, &frame, &PngOptions::default()).unwrap();
        let picture = read_picture(&path, Encode::Srgb).unwrap();
        prop_assert_eq!(&picture.frame, &frame);
        prop_assert!(picture.alpha && picture.samples == SampleKind::Float && picture.format == "EXR");
    }

    #[test]
    fn what_was_written_as_png_comes_back_to_rounding(frame in frames(), options in options()) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.png");
        write(&path, &frame, &options).unwrap();
        let picture = read_picture(&path, options.encode).unwrap();
        prop_assert_eq!(picture.alpha, options.alpha);
        let steps = match options.depth { PngDepth::Eight => 255.0, PngDepth::Sixteen => 65535.0 };
        let blended = frame.over_background(options.background);
        for ((read, written), behind) in picture.frame.pixels().iter().zip(frame.pixels()).zip(&blended) {
            // Half a step, and what f32 adds.
            let half = 0.5 / steps + 1e-6;
            let alpha = if options.alpha { f64::from(written[3]) } else { 1.0 };
            prop_assert!((f64::from(read[3]) - alpha).abs() <= half);
            for c in 0..3 {
                // The code of the colour is off by half a step where it is straight; then α is off, too.
                let straight = if !options.alpha {
                    f64::from(behind[c])
                } else if alpha > 0.0 {
                    (f64::from(written[c]) / alpha).min(1.0)
                } else {
                    0.0
                };
                let (low, high) = match options.encode {
                    Encode::None => (straight - half, straight + half),
                    Encode::Srgb => {
                        let code = linear_to_srgb(straight.clamp(0.0, 1.0));
                        (srgb_to_linear((code - half).max(0.0)), srgb_to_linear(code + half))
                    }
                };
                let low = low * (alpha - half).max(0.0) - 1e-6;
                let high = high * (alpha + half) + 1e-6;
                prop_assert!((low..=high).contains(&f64::from(read[c])), "{} not in {low}..{high}", read[c]);
            }
        }
    }
}

/// Writes a picture with the `image` crate, as another program would.
fn foreign(folder: &Path, image: &DynamicImage, format: ImageFormat) -> Result<vr_io::Picture, PictureError> {
    // A name that tells nothing.
    let path = folder.join("picture");
    image.save_with_format(&path, format).unwrap();
    read_picture(path, Encode::None)
}

#[test]
fn every_format_and_colour_type() {
    let folder = tempfile::tempdir().unwrap();
    let rgba8 = image::RgbaImage::from_fn(3, 2, |x, y| image::Rgba([(x * 100) as u8, (y * 200) as u8, 50, 255]));
    let rgba8 = DynamicImage::ImageRgba8(rgba8);
    let variants = [
        (DynamicImage::ImageLuma8(rgba8.to_luma8()), false, SampleKind::Eight),
        (DynamicImage::ImageLumaA8(rgba8.to_luma_alpha8()), true, SampleKind::Eight),
        (DynamicImage::ImageRgb8(rgba8.to_rgb8()), false, SampleKind::Eight),
        (rgba8.clone(), true, SampleKind::Eight),
        (DynamicImage::ImageLuma16(rgba8.to_luma16()), false, SampleKind::Sixteen),
        (DynamicImage::ImageLumaA16(rgba8.to_luma_alpha16()), true, SampleKind::Sixteen),
        (DynamicImage::ImageRgb16(rgba8.to_rgb16()), false, SampleKind::Sixteen),
        (DynamicImage::ImageRgba16(rgba8.to_rgba16()), true, SampleKind::Sixteen),
    ];
    for (image, alpha, samples) in &variants {
        let picture = foreign(folder.path(), image, ImageFormat::Png).unwrap();
        assert_eq!((picture.alpha, picture.samples, picture.format), (*alpha, *samples, "PNG"));
        let expected = image.to_rgba32f();
        for (read, expected) in picture.frame.pixels().iter().zip(expected.pixels()) {
            assert!((0..4).all(|c| (read[c] - expected.0[c]).abs() < 1e-6), "{read:?} {expected:?}");
        }
    }
    let rgb = DynamicImage::ImageRgb8(rgba8.to_rgb8());
    for (format, name) in [(ImageFormat::Tiff, "TIFF"), (ImageFormat::Bmp, "BMP"), (ImageFormat::Pnm, "PNM")] {
        let picture = foreign(folder.path(), &rgb, format).unwrap();
        assert_eq!((picture.format, picture.frame.size()), (name, [3, 2]));
        assert_eq!(picture.frame.pixel(2, 1), [200.0 / 255.0, 200.0 / 255.0, 50.0 / 255.0, 1.0]);
    }
    let flat = DynamicImage::ImageRgb8(image::RgbImage::from_pixel(16, 16, image::Rgb([120, 130, 140])));
    let picture = foreign(folder.path(), &flat, ImageFormat::Jpeg).unwrap();
    assert_eq!((picture.format, picture.samples), ("JPEG", SampleKind::Eight));
    assert!((picture.frame.pixel(3, 5)[1] - 130.0 / 255.0).abs() < 0.01);
    let floats = DynamicImage::ImageRgb32F(image::Rgb32FImage::from_pixel(2, 2, image::Rgb([-1.5, 0.25, 7.0])));
    let picture = foreign(folder.path(), &floats, ImageFormat::Tiff).unwrap();
    assert_eq!((picture.samples, picture.frame.pixel(1, 1)), (SampleKind::Float, [-1.5, 0.25, 7.0, 1.0]));
}

#[test]
fn what_is_no_picture_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.png");
    let error = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        read_picture(&path, Encode::Srgb).unwrap_err()
    };
    assert!(matches!(error(b""), PictureError::Unrecognised { .. }));
    assert!(matches!(error(b"[volume]\nphantom = \"fog\"\n"), PictureError::Unrecognised { .. }));
    assert!(matches!(error(b"GIF89a\x01\0\x01\0"), PictureError::Unrecognised { .. }));
    assert!(matches!(error(b"P5 60000 60000 255\n"), PictureError::Size { .. }));
    assert!(matches!(error(b"P5 4000 4000 255\n0123"), PictureError::Size { .. }));
    assert!(matches!(error(b"P5 4 4 255\n0123"), PictureError::Damaged { .. }));
    assert!(matches!(read_picture(folder.path(), Encode::Srgb).unwrap_err(), PictureError::Io { .. }));
    assert!(matches!(read_picture(folder.path().join("no"), Encode::Srgb).unwrap_err(), PictureError::Io { .. }));
}

/// A file of each format.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x");
    let pixel = |x: u32, y: u32| [x as f32 / 20.0, y as f32 / 13.0, 0.5 * ((x * y) as f32).sin().abs(), 1.0];
    let pixels = (0..13).flat_map(|y| (0..20).map(move |x| pixel(x, y))).collect();
    let frame = Frame::new([20, 13], pixels, Some(vec![1.0; 260]));
    let mut files = Vec::new();
    for (name, options) in [
        ("exr", PngOptions::default()),
        ("png", PngOptions::default()),
        ("png", PngOptions { depth: PngDepth::Sixteen, alpha: true, ..PngOptions::default() }),
    ] {
        let path = path.with_extension(name);
        write(&path, &frame, &options).unwrap();
        files.push((name, std::fs::read(path).unwrap()));
    }
    let image = image::load_from_memory(&files[1].1).unwrap();
    for (name, format) in
        [("jpeg", ImageFormat::Jpeg), ("tiff", ImageFormat::Tiff), ("bmp", ImageFormat::Bmp), ("pnm", ImageFormat::Pnm)]
    {
        image.save_with_format(&path, format).unwrap();
        files.push((name, std::fs::read(&path).unwrap()));
    }
    files
}

#[test]
fn what_is_cut_off_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in samples() {
        for keep in [1, bytes.len() / 4, bytes.len() / 2] {
            let path = folder.path().join("x");
            std::fs::write(&path, &bytes[..keep]).unwrap();
            let outcome = read_picture(&path, Encode::Srgb);
            // A JPEG that is cut off is a picture that is grey at the bottom, to this decoder as to browsers.
            assert!(outcome.is_err() || name == "jpeg", "{name} cut to {keep} bytes was read");
        }
    }
}

#[test]
fn damaged_files_are_read_or_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in samples() {
        let case = Cell::new(0);
        let config = Config { cases: 300, failure_persistence: None, ..Config::default() };
        let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
        // Headers are where it hurts: half of the hits go to the first bytes.
        let place = prop_oneof![0..bytes.len().min(400), 0..bytes.len()];
        let outcome = runner.run(&(vec((place, any::<u8>()), 1..6), 0..bytes.len() * 4), |(hits, cut)| {
            case.set(case.get() + 1);
            let mut damaged = bytes.clone();
            for (at, value) in hits {
                damaged[at] = value;
            }
            damaged.truncate(cut.max(1));
            let path = folder.path().join(format!("{}{name}", case.get()));
            std::fs::write(&path, &damaged).unwrap();
            let outcome = read_picture(&path, Encode::Srgb);
            std::fs::remove_file(&path).unwrap();
            match outcome {
                Ok(picture) => prop_assert!(!picture.frame.pixels().is_empty()),
                Err(e) => prop_assert!(!e.to_string().contains('\n'), "two lines: {}", e),
            }
            Ok(())
        });
        outcome.unwrap_or_else(|e| panic!("{name}: {e}"));
    }
}
