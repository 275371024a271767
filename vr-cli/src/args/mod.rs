//! The command line.

mod choices;
mod convert;
mod diff;
mod ray;
mod report;
mod scene;
mod tf;
mod value;
mod volume;

use std::path::{Path, PathBuf};

use clap::error::ErrorKind;
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use vr_io::{PngDepth, PngOptions};

pub use choices::{Bits, Curve, ErrorMeasure};
pub use convert::{ChangeArgs, ConvertArgs, CropBox};
pub use diff::DiffArgs;
pub use ray::RayArgs;
pub use report::{CacheArgs, ReportArgs, SuiteName, VerifyArgs};
pub use scene::{CameraArgs, CompositingArgs, Fit, ImageArgs, MeshArgs, SceneArgs, ShadingArgs, TransferArgs};
pub use tf::{PresetsArgs, TfArgs};
pub use volume::VolumeArgs;

use crate::failure::Failure;
use crate::renderers;

/// Pictures of volumes, and how far they are from the correct ones.
///
/// Every command but `diff` and `convert` works without arguments, on an embedded scene.
#[derive(Debug, Parser)]
#[command(name = "vr", version, args_override_self = true, after_help = EXIT_CODES)]
pub struct Cli {
    /// Options of every command.
    #[command(flatten)]
    pub global: GlobalArgs,
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// Exit codes, which scripts rely on.
const EXIT_CODES: &str = "\
Exit codes:
  0  done; an error bound that was asked for (--max-error) is proven for every pixel
  1  failed: a file, the scene in it, the disk, a check that did not pass
  2  wrong usage: the command line asks for something impossible, or for writing over a file that is read
  3  done and written, but the error bound could not be proven for every pixel; stderr says for how many, even under --quiet";

/// Options of every command.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Everywhere")]
pub struct GlobalArgs {
    /// Print nothing but errors
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Print the result as one JSON object
    #[arg(long, global = true)]
    pub json: bool,
    /// Use N threads; all processors if absent
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

/// The command.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a volume, and measure the picture's error
    Render(Box<RenderArgs>),
    /// Render one scene with every renderer, and compare time and error
    Compare(Box<CompareArgs>),
    /// Time a renderer: frames of a turning camera, after one preparation
    Bench(Box<BenchArgs>),
    /// Measure speed against error with every renderer and setting, and write a page about it
    Report(Box<ReportArgs>),
    /// Put every documented order of convergence to the test
    Verify(Box<VerifyArgs>),
    /// Compare two pictures from anywhere: error, similarity, heat map
    Diff(Box<DiffArgs>),
    /// Describe a volume: size, orientation, values, histogram, transfer functions worth a try; or a mesh
    Info(Box<InfoArgs>),
    /// Write a volume in another format, or a part of it, resampled, or with voxels of another type
    Convert(Box<ConvertArgs>),
    /// Draw a volume under every preset that suits it, on one sheet
    Presets(Box<PresetsArgs>),
    /// Print, draw or convert a transfer function: a preset, a file, or the automatic one
    Tf(Box<TfArgs>),
    /// Explain one pixel: faces and knots along its ray, the renderer's steps, and the reference
    Ray(Box<RayArgs>),
}

/// `vr render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The renderer and its options.
    #[command(flatten)]
    pub renderer: RendererArgs,
    /// The cheapest picture within an error.
    #[command(flatten)]
    pub target: TargetArgs,
    /// Output of the picture.
    #[command(flatten)]
    pub output: OutputArgs,
    /// Reference pixels that are kept.
    #[command(flatten)]
    pub cache: CacheArgs,
}

/// The renderer and its options.
#[derive(Debug, Args)]
#[command(next_help_heading = "Renderer")]
pub struct RendererArgs {
    /// Renderer; if absent the scene file's, else raycast (splat for scattered points)
    #[arg(long, value_name = "NAME")]
    pub renderer: Option<String>,
    /// Set an option of the renderer (listed below); may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = value::key_value)]
    pub set: Vec<(String, String)>,
    /// Bound the error of every pixel by E; renderers that cannot do so refuse. Exit code 3 where the bound is not proven for every pixel
    #[arg(long, value_name = "E")]
    pub max_error: Option<f64>,
}

/// The cheapest picture within an error.
#[derive(Debug, Args)]
#[command(next_help_heading = "Renderer")]
pub struct TargetArgs {
    /// Choose the cheapest renderer and setting whose RMSE is at most E, by trying them on the scene
    #[arg(long, value_name = "E", conflicts_with_all = ["set", "max_error"])]
    pub target_rmse: Option<f64>,
}

/// Output of the picture.
#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub struct OutputArgs {
    /// Picture to write: .png or .exr (linear floats, and depth); may be repeated
    #[arg(long = "output", short, value_name = "FILE", default_value = "vr.png")]
    pub outputs: Vec<PathBuf>,
    /// Encoding of light in a PNG: the sRGB curve, or linear values as they are
    #[arg(long, value_name = "CURVE", default_value = "srgb")]
    pub encode: Curve,
    /// Bits per channel of a PNG
    #[arg(long, value_name = "N", default_value = "8")]
    pub bits: Bits,
    /// Keep opacity in a PNG instead of blending with the background
    #[arg(long)]
    pub alpha: bool,
    /// Pixels that are compared with the reference: all, those of a 64x64 subgrid, or none
    #[arg(long, value_name = "PIXELS", default_value = "subgrid")]
    pub error: ErrorMeasure,
    /// Map of the error to write, interpolated between the compared pixels: .png (heat map) or .exr (signed, in floats)
    #[arg(long, value_name = "FILE")]
    pub error_map: Option<PathBuf>,
}

impl OutputArgs {
    /// Returns every file that is written, with the flag that names it.
    pub fn places(&self) -> impl Iterator<Item = (&str, &Path)> {
        let outputs = self.outputs.iter().map(|path| ("--output", path.as_path()));
        outputs.chain(self.error_map.iter().map(|path| ("--error-map", path.as_path())))
    }

    /// Refuses options of PNGs where there is none.
    ///
    /// # Errors
    /// [`Failure::Usage`] naming the option.
    pub fn check_png_options(&self) -> Result<(), Failure> {
        let is_png = |path: &PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
        if self.outputs.iter().any(is_png) {
            return Ok(());
        }
        let set =
            [("--encode", self.encode != Curve::Srgb), ("--bits", self.bits != Bits::Eight), ("--alpha", self.alpha)];
        set.iter().find(|(_, set)| *set).map_or(Ok(()), |(flag, _)| {
            Err(Failure::usage(format!("{flag}: no picture is a PNG; OpenEXR holds linear floats, opacity among them")))
        })
    }

    /// Returns the options of the PNG, without the background.
    pub fn png(&self) -> PngOptions {
        PngOptions {
            depth: match self.bits {
                Bits::Eight => PngDepth::Eight,
                Bits::Sixteen => PngDepth::Sixteen,
            },
            encode: self.encode.into(),
            alpha: self.alpha,
            ..PngOptions::default()
        }
    }
}

/// `vr compare`.
#[derive(Debug, Args)]
pub struct CompareArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Compare only this renderer with the reference; may be repeated
    #[arg(long = "renderer", value_name = "NAME", help_heading = "Comparison")]
    pub renderers: Vec<String>,
    /// Contact sheet to write
    #[arg(long, short, value_name = "FILE", default_value = "vr-compare.png", help_heading = "Comparison")]
    pub output: PathBuf,
}

/// `vr bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The renderer and its options.
    #[command(flatten)]
    pub renderer: RendererArgs,
    /// Frames that are timed.
    #[command(flatten)]
    pub timing: TimingArgs,
}

/// Frames that are timed.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Timing")]
pub struct TimingArgs {
    /// Time this many frames
    #[arg(long, value_name = "N", default_value = "9", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: u32,
    /// Turn the camera about its target by this angle from frame to frame; frame 0 is the scene's own view
    #[arg(long, value_name = "DEGREES", default_value = "10", value_parser = value::angle, allow_hyphen_values = true)]
    pub azimuth_step: f64,
    /// Draw this many frames first that are not timed: the turns that lead up to frame 0
    #[arg(long, value_name = "N", default_value = "2", value_parser = clap::value_parser!(u32).range(0..=1000))]
    pub warm_up: u32,
    /// Compare frame 0 with the reference on a 64x64 subgrid of its pixels
    #[arg(long)]
    pub error: bool,
}

/// `vr info`.
#[derive(Debug, Args)]
pub struct InfoArgs {
    /// The volume.
    #[command(flatten)]
    pub volume: VolumeArgs,
}

impl Cli {
    /// Reads the command line. Help and the version are printed by clap, which then ends the program.
    ///
    /// # Errors
    /// [`Failure::Usage`] for anything else that is no command.
    pub fn from_command_line() -> Result<Self, Failure> {
        let matches = match Self::command().try_get_matches() {
            // Renderers are asked for their features and options only where help is read.
            Err(e) if e.kind() == ErrorKind::DisplayHelp => Self::command_with_renderers().try_get_matches(),
            read => read,
        };
        match matches.and_then(|matches| Self::from_arg_matches(&matches)) {
            Ok(cli) => Ok(cli),
            Err(e) if e.use_stderr() && e.kind() != ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
                Err(Failure::usage(first_words(&e.render().to_string())))
            }
            Err(e) => e.exit(),
        }
    }

    /// Returns the command, with the help on renderers.
    fn command_with_renderers() -> clap::Command {
        let (features, options) = (renderers::feature_table() + "\n", renderers::option_help());
        Self::command()
            .mut_subcommand("render", |render| render.after_help(features + &options + EXIT_CODES))
            .mut_subcommand("bench", |bench| bench.after_help(options.clone() + EXIT_CODES))
            .mut_subcommand("presets", |presets| presets.after_help(options.clone()))
            .mut_subcommand("ray", |ray| ray.after_help(options))
    }
}

/// Returns a message of clap without its usage lines.
fn first_words(message: &str) -> &str {
    let end = message.find("\nUsage:").or_else(|| message.find("\nFor more information")).unwrap_or(message.len());
    message[..end].trim_start_matches("error: ").trim_end()
}
