//! Pictures in OpenEXR, of this and of other programs.
//!
//! Only the channels that make up the picture are kept: a file of a film renderer may hold fifty.

use std::io::BufReader;

use exr::block::UncompressedBlock;
use exr::block::lines::LineRef;
use exr::block::reader::ChunksReader;
use exr::compression::Compression;
use exr::error::Error;
use exr::math::Vec2;
use exr::meta::attribute::{ChannelDescription, SampleType};
use exr::meta::header::Header;
use exr::prelude::f16;
use vr_core::Frame;

use super::error::PictureError;
use super::{BYTES_PER_BYTE, MAX_PIXELS, Origin, Picture, SampleKind};
use crate::regular_file::RegularFile;

const FORMAT: &str = "EXR";

/// Largest ratio of these codecs, which transform blocks of 64 values, of which one may be left, and deflate that.
const DWA_BYTES_PER_BYTE: u64 = 64 * BYTES_PER_BYTE;

/// Reads a file whose first bytes are those of EXR.
pub(super) fn read(origin: Origin<'_>, file: BufReader<RegularFile>) -> Result<Picture, PictureError> {
    let path = origin.path;
    let refuse = |error| match error {
        Error::Io(source) => PictureError::Io { path: path.into(), source },
        Error::NotSupported(message) => PictureError::unsupported(path, FORMAT, message),
        other => PictureError::damaged(path, FORMAT, other),
    };
    let unsupported = |message: &str| PictureError::unsupported(path, FORMAT, message);

    // Choose the layer, and refuse what is not read.
    let reader = exr::block::read(file, false).map_err(refuse)?;
    let layer = Layer::first_with_colors(reader.headers())
        .map_err(|found| PictureError::Channels { path: path.into(), found })?;
    let header = reader.headers()[layer.header].clone();
    if header.deep {
        return Err(unsupported("deep data"));
    }
    if header.channels.list.iter().any(|c| c.sampling != Vec2(1, 1)) {
        return Err(unsupported("channels of a lower resolution"));
    }
    // Check both sizes before anything is allocated.
    let Vec2(width, height) = header.layer_size;
    let bytes_per_byte = match header.compression {
        Compression::DWAA(_) | Compression::DWAB(_) => DWA_BYTES_PER_BYTE,
        _ => BYTES_PER_BYTE,
    };
    origin.check([width as u64, height as u64], header.channels.bytes_per_pixel as u64, bytes_per_byte)?;
    let window = header.shared_attributes.display_window;
    let Vec2(shown_width, shown_height) = window.size;
    let pixels = (shown_width as u64).saturating_mul(shown_height as u64);
    if pixels == 0 || pixels > MAX_PIXELS {
        let size = [shown_width as u64, shown_height as u64];
        return Err(PictureError::Size { path: path.into(), size, length: origin.length });
    }
    origin.check_memory(pixels, 0)?;

    // Prepare the display window.
    let data_position = header.own_attributes.layer_position;
    let offset = [(data_position.0, window.position.0), (data_position.1, window.position.1)]
        .map(|(data, shown)| i64::from(data) - i64::from(shown));
    let mut target = Target {
        size: [shown_width, shown_height],
        offset,
        pixels: vec![[0.0; 4]; shown_width * shown_height],
        layer: &layer,
    };
    if layer.alpha.is_none() {
        // What the file has no data for stays empty.
        target.fill_opaque([width, height]);
    }
    // Decompress the blocks of the layer's largest level into it.
    let largest = |level: Vec2<usize>| level == Vec2(0, 0);
    let mut blocks = reader
        .filter_chunks(false, |_, tile, block| block.layer == layer.header && largest(tile.level_index))
        .map_err(refuse)?
        .sequential_decompressor(false);
    while let Some(block) = blocks.decompress_next_block() {
        let block = block.map_err(refuse)?;
        if block.index.layer != layer.header || !largest(block.index.level) {
            return Err(PictureError::damaged(path, FORMAT, "a block of another layer"));
        }
        target.take(&block, &header).map_err(refuse)?;
    }
    let half = layer.channels().all(|c| header.channels.list[c].sample_type == SampleType::F16);
    let samples = if half { SampleKind::Half } else { SampleKind::Float };
    let Target { size, pixels, .. } = target;
    Ok(Picture {
        frame: Frame::new(size.map(|s| s as u32), pixels, None),
        alpha: layer.alpha.is_some(),
        samples,
        format: FORMAT,
        layer: layer.name,
    })
}

/// The channels that make up the picture.
struct Layer {
    header: usize,
    name: Option<String>,
    /// Indices of red, green and blue; the same one for grey.
    color: [usize; 3],
    alpha: Option<usize>,
}

impl Layer {
    /// Channels named R, G and B, or Y; else those of the first layer that has them, named `layer.R` as is the custom.
    ///
    /// # Errors
    /// The channels that are there instead.
    fn first_with_colors(headers: &[Header]) -> Result<Self, String> {
        let names = |header: &Header| -> Vec<String> {
            header.channels.list.iter().map(|c: &ChannelDescription| c.name.to_string()).collect()
        };
        let prefixes = |header: &Header| -> Vec<String> {
            let mut prefixes = vec![String::new()];
            for name in names(header) {
                if let Some(dot) = name.rfind('.')
                    && prefixes.last().is_none_or(|last| *last != name[..=dot])
                {
                    prefixes.push(name[..=dot].to_owned());
                }
            }
            prefixes
        };
        // Plain names in any part come before prefixed ones, colours before grey.
        for letters in [["R", "G", "B"], ["Y"; 3]] {
            for plain in [true, false] {
                for (index, header) in headers.iter().enumerate() {
                    let names = names(header);
                    for prefix in prefixes(header).into_iter().filter(|p| p.is_empty() == plain) {
                        let find = |letter: &str| {
                            names
                                .iter()
                                .position(|n| n.strip_prefix(&*prefix).is_some_and(|n| n.eq_ignore_ascii_case(letter)))
                        };
                        let [Some(r), Some(g), Some(b)] = letters.map(find) else { continue };
                        let part = header.own_attributes.layer_name.as_ref().map(ToString::to_string);
                        let name = if plain { part } else { Some(prefix.trim_end_matches('.').to_owned()) };
                        let name = name.map(|name| crate::error::shown(&name));
                        return Ok(Self { header: index, name, color: [r, g, b], alpha: find("A") });
                    }
                }
            }
        }
        let found: Vec<String> = headers.iter().flat_map(names).collect();
        Err(crate::error::shown(&found.join(", ")))
    }

    /// Indices of all its channels.
    fn channels(&self) -> impl Iterator<Item = usize> {
        self.color.into_iter().chain(self.alpha)
    }
}

/// The picture as it fills up.
struct Target<'a> {
    size: [usize; 2],
    /// Position in the picture at which the data begin; outside of it, maybe.
    offset: [i64; 2],
    pixels: Vec<[f32; 4]>,
    layer: &'a Layer,
}

impl Target<'_> {
    /// Index of a place in the data; `None` where that is outside of the picture.
    fn index(&self, data: [usize; 2]) -> Option<usize> {
        let place = |axis: usize| {
            let place = usize::try_from(data[axis] as i64 + self.offset[axis]).ok()?;
            (place < self.size[axis]).then_some(place)
        };
        Some(place(1)? * self.size[0] + place(0)?)
    }

    /// Sets α to 1 wherever there are data.
    fn fill_opaque(&mut self, data_size: [usize; 2]) {
        for y in 0..data_size[1] {
            for x in 0..data_size[0] {
                if let Some(index) = self.index([x, y]) {
                    self.pixels[index][3] = 1.0;
                }
            }
        }
    }

    /// Takes what a block holds of the picture's channels.
    fn take(&mut self, block: &UncompressedBlock, header: &Header) -> Result<(), Error> {
        for line in block.lines(&header.channels) {
            let channel = line.location.channel;
            let [r, g, b] = self.layer.color.map(|c| c == channel);
            let components = [r, g, b, self.layer.alpha == Some(channel)];
            if components.contains(&true) {
                for (i, value) in samples(line, header.channels.list[channel].sample_type)?.into_iter().enumerate() {
                    let Vec2(x, y) = line.location.position;
                    if let Some(index) = self.index([x + i, y]) {
                        for c in (0..4).filter(|&c| components[c]) {
                            self.pixels[index][c] = value;
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

/// A line of a channel.
fn samples(line: LineRef<'_>, kind: SampleType) -> Result<Vec<f32>, Error> {
    match kind {
        SampleType::F16 => line.read_samples::<f16>().map(|v| v.map(f16::to_f32)).collect(),
        SampleType::F32 => line.read_samples::<f32>().collect(),
        SampleType::U32 => line.read_samples::<u32>().map(|v| v.map(|v| v as f32)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use exr::prelude::{
        AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer as ExrLayer,
        LayerAttributes, WritableImage,
    };

    use super::*;
    use crate::png::Encode;
    use crate::read_picture;

    type FlatLayer = ExrLayer<AnyChannels<FlatSamples>>;

    fn layer(size: [usize; 2], name: &str, channels: &[(&str, FlatSamples)]) -> FlatLayer {
        let channels = channels.iter().map(|(name, samples)| AnyChannel::new(*name, samples.clone())).collect();
        ExrLayer::new(
            Vec2(size[0], size[1]),
            if name.is_empty() { LayerAttributes::default() } else { LayerAttributes::named(name) },
            Encoding::SMALL_FAST_LOSSLESS,
            AnyChannels::sort(channels),
        )
    }

    fn halves(values: &[f32]) -> FlatSamples {
        FlatSamples::F16(values.iter().map(|&v| f16::from_f32(v)).collect())
    }

    fn floats(values: &[f32]) -> FlatSamples {
        FlatSamples::F32(values.to_vec())
    }

    fn read_back(display: [usize; 2], layers: &[FlatLayer]) -> Result<Picture, PictureError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.exr");
        let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((display[0], display[1])));
        Image::from_layers(attributes, layers.to_vec()).write().to_file(&path).unwrap();
        read_picture(path, Encode::Srgb)
    }

    #[test]
    fn rgb_in_halves_is_opaque() {
        let plain =
            layer([2, 1], "", &[("R", halves(&[0.1, 4.0])), ("G", halves(&[0.0; 2])), ("B", halves(&[1.0; 2]))]);
        let picture = read_back([2, 1], &[plain]).unwrap();
        assert_eq!(picture.frame.pixels(), [[f16::from_f32(0.1).to_f32(), 0.0, 1.0, 1.0], [4.0, 0.0, 1.0, 1.0]]);
        assert_eq!((picture.alpha, picture.samples, picture.layer), (false, SampleKind::Half, None));
    }

    #[test]
    fn grey_with_alpha() {
        let grey = layer([1, 1], "", &[("Y", floats(&[0.25])), ("A", floats(&[0.5])), ("Z", floats(&[9.0]))]);
        let picture = read_back([1, 1], &[grey]).unwrap();
        assert_eq!(picture.frame.pixels(), [[0.25, 0.25, 0.25, 0.5]]);
        assert_eq!((picture.alpha, picture.samples), (true, SampleKind::Float));
    }

    #[test]
    fn named_layers() {
        let many = layer(
            [1, 1],
            "",
            &[
                ("Depth.Z", floats(&[7.0])),
                ("View.Combined.R", floats(&[0.1])),
                ("View.Combined.G", floats(&[0.2])),
                ("View.Combined.B", floats(&[0.3])),
                ("View.Combined.A", floats(&[0.4])),
                ("View.Normal.X", floats(&[7.0])),
            ],
        );
        let picture = read_back([1, 1], &[many]).unwrap();
        assert_eq!(picture.frame.pixels(), [[0.1, 0.2, 0.3, 0.4]]);
        assert_eq!(picture.layer.as_deref(), Some("View.Combined"));
    }

    #[test]
    fn a_part_with_colours_comes_before_one_without() {
        let depth = layer([1, 1], "depth", &[("Z", floats(&[7.0]))]);
        let beauty = |name, v| layer([1, 1], name, &["R", "G", "B"].map(|c| (c, floats(&[v]))));
        let picture = read_back([1, 1], &[depth.clone(), beauty("beauty", 0.5), beauty("copy", 0.6)]).unwrap();
        assert_eq!((picture.frame.pixel(0, 0)[0], picture.layer.as_deref()), (0.5, Some("beauty")));
        let error = read_back([1, 1], &[depth]).unwrap_err();
        assert!(matches!(&error, PictureError::Channels { found, .. } if found == "Z"), "{error}");
    }

    #[test]
    fn data_lie_where_the_display_window_has_them() {
        let mut part = layer([2, 2], "", &["R", "G", "B"].map(|c| (c, floats(&[1.0, 2.0, 3.0, 4.0]))));
        part.attributes.layer_position = Vec2(2, -1);
        let picture = read_back([3, 2], &[part]).unwrap();
        assert_eq!(picture.frame.size(), [3, 2]);
        let red: Vec<[f32; 2]> = picture.frame.pixels().iter().map(|p| [p[0], p[3]]).collect();
        assert_eq!(red, [[0.0, 0.0], [0.0, 0.0], [3.0, 1.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0]]);
    }

    #[test]
    fn every_codec_that_the_library_writes() {
        for encoding in
            [Encoding::UNCOMPRESSED, Encoding::FAST_LOSSLESS, Encoding::SMALL_LOSSLESS, Encoding::SMALL_FAST_LOSSLESS]
        {
            let values: Vec<f32> = (0..70 * 40).map(|k| (k as f32).sin()).collect();
            let mut part = layer([70, 40], "", &["R", "G", "B"].map(|c| (c, floats(&values))));
            part.encoding = encoding;
            let picture = read_back([70, 40], &[part]).unwrap();
            assert!(picture.frame.pixels().iter().zip(&values).all(|(p, &v)| *p == [v, v, v, 1.0]), "{encoding:?}");
        }
    }

    #[test]
    fn a_large_picture_may_take_few_bytes() {
        let black = [Compression::DWAB(None), Compression::ZIP16].map(|compression| {
            let mut part = layer([2048, 1024], "", &["R", "G", "B"].map(|c| (c, halves(&[0.0; 2048 * 1024]))));
            part.encoding = Encoding { compression, ..Encoding::default() };
            part
        });
        for part in black {
            let picture = read_back([2048, 1024], &[part]).unwrap();
            assert!(picture.frame.pixels().iter().all(|p| *p == [0.0, 0.0, 0.0, 1.0]));
        }
    }
}
