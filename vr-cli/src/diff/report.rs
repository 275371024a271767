//! Output of `vr diff`, for people and for machines.

use std::path::{Path, PathBuf};

use serde::Serialize;
use vr_io::{Picture, SampleKind};
use vr_physics::metrics::{Channels, Metrics};

use super::comparison::{Blended, Comparison, Worst};
use crate::args::Curve;
use crate::number;

/// Report of a comparison, to be printed.
pub struct Report<'a> {
    pub reference: Side<'a>,
    pub picture: Side<'a>,
    pub comparison: &'a Comparison,
    pub background: [f32; 3],
    pub ssim: Option<f64>,
    #[cfg(feature = "flip")]
    pub flip: f64,
    pub outputs: &'a [PathBuf],
}

/// One of the two pictures.
#[derive(Serialize)]
pub struct Side<'a> {
    path: &'a Path,
    format: &'static str,
    samples: &'static str,
    /// Encoding of the integers; `null` for floats, which are linear.
    encode: Option<&'static str>,
    opacity: bool,
    layer: Option<&'a str>,
}

impl<'a> Side<'a> {
    /// Describes a picture and where it came from.
    pub fn new(path: &'a Path, picture: &'a Picture, curve: Curve) -> Self {
        let curve = match curve {
            Curve::Srgb => "srgb",
            Curve::None => "linear",
        };
        let (samples, encode) = match picture.samples {
            SampleKind::Eight => ("8 bits", Some(curve)),
            SampleKind::Sixteen => ("16 bits", Some(curve)),
            SampleKind::Half => ("16-bit floats", None),
            SampleKind::Float => ("32-bit floats", None),
        };
        let &Picture { alpha, format, ref layer, .. } = picture;
        Self { path, format, samples, encode, opacity: alpha, layer: layer.as_deref() }
    }

    fn text(&self) -> String {
        let encode = self.encode.map(|e| format!(" ({e})")).unwrap_or_default();
        let layer = self.layer.map(|l| format!(", layer {l}")).unwrap_or_default();
        let opacity = if self.opacity { "with opacity" } else { "no opacity" };
        format!("{}: {}, {}{encode}, {opacity}{layer}", self.path.display(), self.format, self.samples)
    }
}

#[derive(Serialize)]
pub struct Json<'a> {
    reference: &'a Side<'a>,
    picture: &'a Side<'a>,
    size: [u32; 2],
    channels: &'static str,
    blended: Option<&'static str>,
    error: ErrorJson,
    /// SSIM; `null` where the picture is smaller than a window.
    ssim: Option<f64>,
    #[cfg(feature = "flip")]
    flip: f64,
    /// Worst pixel; `null` for equal pictures.
    largest: Option<LargestJson>,
    visible_pixels: usize,
    visible_share: f64,
    outputs: &'a [PathBuf],
}

/// Errors in JSON, which has no infinite numbers: they are `null`.
#[derive(Serialize)]
struct ErrorJson {
    max: f64,
    rmse: f64,
    bias: f64,
    p99: f64,
    psnr: f64,
}

#[derive(Serialize)]
struct LargestJson {
    pixel: [u32; 2],
    reference: Vec<f64>,
    picture: Vec<f64>,
}

impl Report<'_> {
    /// Returns the text for people.
    pub fn text(&self) -> String {
        let comparison = self.comparison;
        let [w, h] = comparison.size;
        let mut text = format!("A        {}\n", self.reference.text());
        text += &format!("B        {}\n", self.picture.text());
        let channels = match comparison.channels {
            Channels::Rgba => "R, G, B and opacity",
            Channels::Rgb => "R, G and B",
        };
        let blended = comparison.blended.map(|side| {
            let side = match side {
                Blended::Reference => "A",
                Blended::Picture => "B",
            };
            format!("; {side} before the background {}", number::triple(self.background, ", "))
        });
        text += &format!("compared {w}x{h} pixels: {channels} of linear light{}\n", blended.unwrap_or_default());
        text += &format!("error    {}\n", comparison.metrics);
        match comparison.worst() {
            Some(Worst { pixel: [x, y], colors, error }) => {
                let [a, b] = colors.map(|c| self.color(c).map(number::value).collect::<Vec<_>>().join(", "));
                text += &format!("largest  {} at pixel {x}, {y}: A {a}; B {b}\n", number::small(error));
            }
            None => text += "largest  none: the pictures are equal\n",
        }
        let visible = comparison.visible();
        let all = u64::from(w) * u64::from(h);
        text +=
            &format!("visible  {visible} of {all} pixels ({:.3} %) differ by more than 1/255\n", 100.0 * self.share());
        text += &match self.ssim {
            Some(ssim) => format!("SSIM     {ssim:.6} (luma as a screen shows it)\n"),
            None => "SSIM     none: the pictures are smaller than its window of 11x11 pixels\n".to_owned(),
        };
        #[cfg(feature = "flip")]
        {
            text += &format!("FLIP     {:.6} (mean, 8 bits, 67 pixels per degree)\n", self.flip);
        }
        if !self.outputs.is_empty() {
            let outputs: Vec<String> = self.outputs.iter().map(|p| p.display().to_string()).collect();
            text += &format!("wrote    {}\n", outputs.join(", "));
        }
        text
    }

    /// Returns the object for machines.
    pub fn json(&self) -> Json<'_> {
        let comparison = self.comparison;
        let Metrics { max, rmse, bias, p99, psnr, .. } = comparison.metrics;
        Json {
            reference: &self.reference,
            picture: &self.picture,
            size: comparison.size,
            channels: match comparison.channels {
                Channels::Rgba => "rgba",
                Channels::Rgb => "rgb",
            },
            blended: comparison.blended.map(|side| match side {
                Blended::Reference => "reference",
                Blended::Picture => "picture",
            }),
            error: ErrorJson { max, rmse, bias, p99, psnr },
            ssim: self.ssim,
            #[cfg(feature = "flip")]
            flip: self.flip,
            largest: comparison.worst().map(|Worst { pixel, colors, .. }| {
                let [reference, picture] = colors.map(|c| self.color(c).collect());
                LargestJson { pixel, reference, picture }
            }),
            visible_pixels: comparison.visible(),
            visible_share: self.share(),
            outputs: self.outputs,
        }
    }

    /// Returns the compared components of a colour.
    fn color(&self, color: [f64; 4]) -> impl Iterator<Item = f64> + use<> {
        let count = match self.comparison.channels {
            Channels::Rgba => 4,
            Channels::Rgb => 3,
        };
        color.into_iter().take(count)
    }

    /// Returns the share of pixels that differ visibly.
    fn share(&self) -> f64 {
        let [w, h] = self.comparison.size.map(f64::from);
        self.comparison.visible() as f64 / (w * h)
    }
}
