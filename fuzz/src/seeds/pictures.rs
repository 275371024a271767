//! Pictures, with records and without.

use image::{ImageFormat, RgbImage};
use vr_core::{Camera, Frame, View, phantom};
use vr_io::{PictureRecord, PngDepth, PngOptions, SceneFile, VolumeRecord, volume_hash};

use super::written;

fn frame() -> Frame {
    let pixel = |i: u32| [i as f32 / 8.0, 0.25, 0.5, 1.0 - i as f32 / 16.0];
    Frame::new([4, 2], (0..8).map(pixel).collect(), Some((0..8).map(|i| i as f32).collect()))
}

fn image() -> RgbImage {
    RgbImage::from_fn(4, 3, |x, y| image::Rgb([60 * x as u8, 80 * y as u8, 7]))
}

fn encoded(format: ImageFormat) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image().write_to(&mut bytes, format).expect("a picture");
    bytes.into_inner()
}

pub fn png() -> Vec<Vec<u8>> {
    let deep = PngOptions { depth: PngDepth::Sixteen, alpha: true, ..PngOptions::default() };
    [PngOptions::default(), deep]
        .map(|options| written("x.png", |path| vr_io::write(path, &frame(), &options)))
        .to_vec()
}

pub fn exr() -> Vec<Vec<u8>> {
    vec![written("x.exr", |path| vr_io::write_exr(path, &frame()))]
}

pub fn others() -> Vec<Vec<u8>> {
    [ImageFormat::Jpeg, ImageFormat::Bmp, ImageFormat::Pnm, ImageFormat::Tiff].map(encoded).to_vec()
}

pub fn tiff() -> Vec<Vec<u8>> {
    vec![encoded(ImageFormat::Tiff)]
}

pub fn slices() -> Vec<Vec<u8>> {
    vec![encoded(ImageFormat::Png), encoded(ImageFormat::Jpeg)]
}

fn record() -> PictureRecord {
    let scene = phantom::by_name("fog").expect("a phantom").scene(2).expect("a scene");
    let view = View::new(Camera::framing(scene.bounds(), 0.0, 0.0, None), [4, 2]);
    let volume = VolumeRecord { title: "fog".to_owned(), hash: volume_hash(&scene.volume) };
    PictureRecord::new("0.1.0", SceneFile::describe(&scene, &view).expect("a scene file"), volume)
}

pub fn recorded_png() -> Vec<Vec<u8>> {
    recorded("x.png")
}

pub fn recorded_exr() -> Vec<Vec<u8>> {
    recorded("x.exr")
}

fn recorded(name: &str) -> Vec<Vec<u8>> {
    vec![written(name, |path| vr_io::write_with_record(path, &frame(), &PngOptions::default(), record()))]
}
