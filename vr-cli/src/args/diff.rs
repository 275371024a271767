//! Arguments of `vr diff`.

use std::path::PathBuf;

use clap::Args;

use super::ReplaceArgs;
use super::choices::Curve;
use super::value;

/// `vr diff`.
#[derive(Debug, Args)]
#[command(after_help = DETAILS)]
pub struct DiffArgs {
    /// The reference: .exr, .png, .jpg, .tif, .bmp, .pnm (told by content)
    #[arg(value_name = "A")]
    pub reference: PathBuf,
    /// The picture that is compared with it
    #[arg(value_name = "B")]
    pub picture: PathBuf,
    /// Encoding of integers in a file: the sRGB curve, or linear values as they are; floats are linear
    #[arg(long, value_name = "CURVE", default_value = "srgb", help_heading = "Comparison")]
    pub encode: Curve,
    /// Linear RGB behind a picture with opacity, where the other one has none
    #[arg(
        long,
        value_name = "R,G,B",
        default_value = "0,0,0",
        value_parser = value::triple::<f32>,
        allow_hyphen_values = true,
        help_heading = "Comparison"
    )]
    pub background: [f32; 3],
    /// End with exit code 1 if the RMSE is above E
    #[arg(long, value_name = "E", value_parser = value::tolerance, allow_hyphen_values = true, help_heading = "Comparison")]
    pub fail_above: Option<f64>,
    /// Map of the difference to write: .png (heat map) or .exr (B - A per channel, in floats); may be repeated
    #[arg(long = "output", short, value_name = "FILE", help_heading = "Output")]
    pub outputs: Vec<PathBuf>,
    /// Files that are there.
    #[command(flatten)]
    pub replace: ReplaceArgs,
}

const DETAILS: &str = "\
Measures:
  error    B - A in premultiplied linear light, R, G, B and A, divided by max(1, largest magnitude in A); R, G and B alone
           unless both pictures have opacity
  SSIM     structural similarity (Wang 2004) of the luma of both pictures as a screen shows them: before the background,
           sRGB-encoded, in [0, 1]; Gaussian windows of 11x11 pixels; 1 for equal pictures
  FLIP     visibility of the difference when flipping between the pictures (Andersson 2020, as NVIDIA's code computes it
           from 8 bits at 67 pixels per degree); 0 for equal pictures; only in builds with the cargo feature `flip`";
