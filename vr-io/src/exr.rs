//! Frames as OpenEXR: the floats as they are, with depth.

use std::path::Path;

use exr::meta::attribute::Text;
use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, Layer, LayerAttributes, Vec2, WritableImage};
use vr_core::Frame;

use crate::atomic::write_whole;
use crate::error::WriteError;
use crate::maker::MAKER;

/// Writes a frame as OpenEXR: premultiplied linear R, G, B and A in 32-bit floats, untouched, without the background; and a
/// channel Z where the frame has depth, channels error.R to error.A where it has its own errors.
///
/// # Errors
/// A [`WriteError`] naming the file; no part of it is left behind then.
pub fn write_exr(path: impl AsRef<Path>, frame: &Frame) -> Result<(), WriteError> {
    write_exr_with(path.as_ref(), frame, LayerAttributes::default())
}

/// Writes a frame as OpenEXR, with attributes.
pub(crate) fn write_exr_with(path: &Path, frame: &Frame, attributes: LayerAttributes) -> Result<(), WriteError> {
    let [width, height] = frame.size();
    let channel = |name: &str, samples: Vec<f32>| AnyChannel::new(name, FlatSamples::F32(samples));
    let component = |c: usize| frame.pixels().iter().map(|p| p[c]).collect();
    let mut channels: Vec<_> = ["R", "G", "B", "A"].iter().enumerate().map(|(c, n)| channel(n, component(c))).collect();
    channels.extend(frame.depth().map(|depth| channel("Z", depth.to_vec())));
    if let Some(uncertainty) = frame.uncertainty() {
        let error = |c: usize| uncertainty.components().iter().map(|p| p[c]).collect();
        channels.extend(["R", "G", "B", "A"].iter().enumerate().map(|(c, n)| channel(&format!("error.{n}"), error(c))));
    }
    let maker = Text::new_or_panic(MAKER);
    let layer = Layer::new(
        Vec2(width as usize, height as usize),
        LayerAttributes { software_name: Some(maker), ..attributes },
        exr::prelude::Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(channels.into()),
    );
    write_whole(path, |out| {
        Image::from_layer(layer)
            .write()
            .to_buffered(out)
            .map_err(|e| WriteError::Encode { path: path.into(), message: e.to_string() })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_come_back_untouched() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.exr");
        let pixels = vec![[0.1, -2.0, 1e6, 0.5], [0.0, 1e-30, 3.0, 1.0], [1.0; 4], [0.0; 4], [0.25; 4], [0.75; 4]];
        let frame = Frame::new([3, 2], pixels, Some(vec![1.0, 2.0, 3.0, f32::INFINITY, 5.0, 6.0]));
        write_exr(&path, &frame).unwrap();
        let image = exr::prelude::read_all_flat_layers_from_file(&path).unwrap();
        let layer = &image.layer_data[0];
        for (c, name) in ["R", "G", "B", "A", "Z"].iter().enumerate() {
            let found = layer.channel_data.list.iter().find(|ch| ch.name.eq(name)).unwrap();
            let found: Vec<f32> = found.sample_data.values_as_f32().collect();
            let expected: Vec<f32> = match c {
                4 => frame.depth().unwrap().to_vec(),
                c => frame.pixels().iter().map(|p| p[c]).collect(),
            };
            assert_eq!(found, expected, "{name}");
        }
    }
}
