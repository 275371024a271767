//! The command line.

mod animation;
mod annotate;
mod background;
mod choices;
mod convert;
mod diff;
mod labels;
mod physics;
mod ray;
mod replace;
mod report;
mod rerun;
mod resample;
mod scattering;
mod scene;
mod scene_file;
mod show;
mod surface;
mod tf;
mod value;
#[cfg(feature = "view")]
mod view;
mod volume;

use std::path::{Path, PathBuf};

use clap::error::ErrorKind;
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand, ValueEnum};
use vr_io::{PngDepth, PngOptions};

pub use animation::{AnimateArgs, AnimationArgs, Axis, LookFrom, TurnArgs, TurntableArgs};
pub use annotate::{AnnotateArgs, Annotation};
pub use background::Background;
pub use choices::{Bits, Curve, ErrorMeasure};
pub use convert::{ChangeArgs, ConvertArgs, CropBox, LevelArgs, Reduce};
pub use diff::DiffArgs;
pub use labels::LabelArgs;
pub use physics::PhysicsArgs;
pub use ray::RayArgs;
pub use replace::ReplaceArgs;
pub use report::{CacheArgs, ReportArgs, SuiteName, VerifyArgs};
pub use rerun::RerunArgs;
pub use resample::ResampleArgs;
pub use scattering::{LightModel, ScatteringArgs};
pub use scene::{CameraArgs, CompositingArgs, Fit, ImageArgs, MeshArgs, SceneArgs, ShadingArgs, TransferArgs};
pub use scene_file::SceneFileArgs;
pub use show::{Protocol, ShowArgs};
pub use tf::{PresetsArgs, TfArgs};
#[cfg(feature = "view")]
pub use view::ViewArgs;
pub use volume::VolumeArgs;

use crate::failure::Failure;
use crate::{help, memory_limit, output_file};

/// Pictures of volumes, and how far they are from the correct ones.
///
/// Every command but `diff`, `convert`, `animate` and `rerun` works without arguments, on an embedded scene.
#[derive(Debug, Parser)]
#[command(name = "vr", version, args_override_self = true, disable_help_subcommand = true)]
pub struct Cli {
    /// Options of every command.
    #[command(flatten)]
    pub global: GlobalArgs,
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

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
    /// Refuse what would take more memory, such as 4GB; what the machine, its control group and ulimit have left if absent
    #[arg(long, global = true, value_name = "SIZE", value_parser = memory_limit::size, hide_short_help = true)]
    pub memory: Option<u64>,
}

/// The command.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a volume, and measure the picture's error
    Render(Box<RenderArgs>),
    /// Look at a volume in the browser: turn it, edit its transfer function, and see the error shrink
    #[cfg(feature = "view")]
    View(Box<ViewArgs>),
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
    /// Describe a volume: size, orientation, values, histogram, transfer functions worth a try; or a mesh; or the record in a picture
    Info(Box<InfoArgs>),
    /// Write a volume in another format, or a part of it, resampled, or with voxels of another type
    Convert(Box<ConvertArgs>),
    /// Write or print the complete scene file, with comments, of what render would draw with the same flags
    Scene(Box<SceneFileArgs>),
    /// Draw a picture again from the record in it, and compare the two bit for bit
    Rerun(Box<RerunArgs>),
    /// Turn a volume about its axis: an animation, or its frames
    Turntable(Box<TurntableArgs>),
    /// Move camera, transfer function and clip from key to key: an animation, or its frames
    Animate(Box<AnimateArgs>),
    /// Draw a volume under every preset that suits it, on one sheet
    Presets(Box<PresetsArgs>),
    /// Print, draw or convert a transfer function: a preset, a file, or the automatic one
    Tf(Box<TfArgs>),
    /// Explain one pixel: faces and knots along its ray, the renderer's steps, and the reference
    Ray(Box<RayArgs>),
    /// Tell how light goes through a scene, which model of it the scene needs, and what each simpler one would cost
    Physics(Box<PhysicsArgs>),
    /// Explain a command, a renderer and its options, or list names: renderers, features, keys of scene files, presets, phantoms
    Help(HelpArgs),
}

/// `vr help`.
#[derive(Debug, Args)]
pub struct HelpArgs {
    /// A command, a renderer, or one of renderers, features, keys, presets and phantoms
    pub topic: Option<String>,
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
    /// The picture in the terminal.
    #[command(flatten)]
    pub show: ShowArgs,
    /// Annotations.
    #[command(flatten)]
    pub annotations: AnnotateArgs,
    /// Reference pixels that are kept.
    #[command(flatten)]
    pub cache: CacheArgs,
}

/// The renderer and its options.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Renderer")]
pub struct RendererArgs {
    /// Renderer; if absent the scene file's, else raycast (splat for scattered points)
    #[arg(long, value_name = "NAME")]
    pub renderer: Option<String>,
    /// Set an option of the renderer (vr help raycast lists its own); may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = value::key_value)]
    pub set: Vec<(String, String)>,
    /// Quality of the picture: draft, normal, fine or proven
    ///
    /// Draft, normal and fine aim at an RMSE of 0.004 (a level of 8 bits), 0.001 and 0.00025; proven bounds the error of every pixel by 0.004.
    #[arg(long, value_name = "WHICH", conflicts_with = "max_error", hide_possible_values = true)]
    pub quality: Option<Quality>,
    /// Bound the error of every pixel by E; where no renderer is named and the usual one cannot, one that can draws. Exit code 3 where the bound is not proven for every pixel
    #[arg(long, value_name = "E")]
    pub max_error: Option<f64>,
}

impl RendererArgs {
    /// Returns the flags with the quality as what it stands for: an option of the renderer, or an error bound.
    ///
    /// # Errors
    /// A renderer without that option, or the option set beside.
    pub fn with_quality(&self, renderer: &str, has_qualities: bool) -> Result<Self, String> {
        let Some(quality) = self.quality else { return Ok(self.clone()) };
        let mut with = Self { quality: None, ..self.clone() };
        if quality == Quality::Proven {
            with.max_error = Some(PROVEN);
            return Ok(with);
        }
        if !has_qualities {
            return Err(format!(
                "--quality: renderer {renderer} has no setting by error; vr help {renderer} lists those that it has, and --target-rmse E tries them"
            ));
        }
        if self.set.iter().any(|(key, _)| key == QUALITY) {
            return Err("--quality and --set quality say the same: leave one of them out".to_owned());
        }
        // The renderer's names are those of the flag.
        let name = quality.to_possible_value().expect("no quality is skipped");
        with.set.push((QUALITY.to_owned(), name.get_name().to_owned()));
        Ok(with)
    }
}

/// Option of renderers that aim at an error by themselves.
pub const QUALITY: &str = "quality";

/// Largest error of a pixel under `--quality proven`: a level of 8 bits.
const PROVEN: f64 = 4e-3;

/// Quality of a picture, as `--quality` takes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Quality {
    /// RMSE of 0.004 aimed at
    Draft,
    /// RMSE of 0.001 aimed at, the default
    Normal,
    /// RMSE of 0.00025 aimed at
    Fine,
    /// Every pixel within 0.004
    Proven,
}

/// The cheapest picture within an error.
#[derive(Debug, Args)]
#[command(next_help_heading = "Renderer")]
pub struct TargetArgs {
    /// Draw a picture whose RMSE is at most E, with a confidence of 95 %
    ///
    /// Steps aim at it, and a sample of the pixels is checked. Where the renderer cannot aim at an error, as with --search.
    #[arg(long, value_name = "E", conflicts_with_all = ["set", "max_error", "quality"])]
    pub target_rmse: Option<f64>,
    /// With --target-rmse: try all settings of all renderers, or of the named one
    ///
    /// The RMSE is proven on every pixel where that can be done. It takes hundreds of times as long as the picture.
    #[arg(long, requires = "target_rmse", hide_short_help = true)]
    pub search: bool,
}

/// Output of the picture.
#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub struct OutputArgs {
    /// Picture to write: .png or .exr (linear floats, and depth); may be repeated
    #[arg(long = "output", short, value_name = "FILE", default_value = "vr.png")]
    pub outputs: Vec<PathBuf>,
    /// Files that are there.
    #[command(flatten)]
    pub replace: ReplaceArgs,
    /// Encoding of light in a PNG: the sRGB curve, or linear values as they are
    #[arg(long, value_name = "CURVE", default_value = "srgb")]
    pub encode: Curve,
    /// Bits per channel of a PNG
    #[arg(long, value_name = "N", default_value = "8")]
    pub bits: Bits,
    /// Keep opacity in a PNG instead of blending with the background
    #[arg(long)]
    pub alpha: bool,
    /// Leave out the record of scene, settings and hashes that each picture holds (vr info prints it, vr rerun draws from it)
    #[arg(long)]
    pub no_record: bool,
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

    /// True if one of the pictures is a PNG.
    pub fn has_png(&self) -> bool {
        self.outputs.iter().any(|path| output_file::is_png(path))
    }

    /// Refuses options of PNGs where there is none.
    ///
    /// # Errors
    /// [`Failure::Usage`] naming the option.
    pub fn check_png_options(&self) -> Result<(), Failure> {
        if self.has_png() {
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
    /// Show every setting and all figures, not the twelve of most use: defaults, then the fastest whose error is not seen
    #[arg(long, help_heading = "Comparison")]
    pub all: bool,
    /// Contact sheet to write
    #[arg(long, short, value_name = "FILE", default_value = "vr-compare.png", help_heading = "Comparison")]
    pub output: PathBuf,
    /// Files that are there.
    #[command(flatten)]
    pub replace: ReplaceArgs,
    /// Write each picture of the sheet by itself, too, into this folder, with a record from which vr rerun draws it again
    #[arg(long, value_name = "FOLDER", help_heading = "Comparison")]
    pub pictures: Option<PathBuf>,
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
    /// Picture to write: three slices through the middle of a grid, and the histogram (.png)
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,
    /// Files that are there.
    #[command(flatten)]
    pub replace: ReplaceArgs,
    /// Labels: a list of their names, of ITK-SNAP, FreeSurfer or Slicer
    #[arg(long, value_name = "FILE", help_heading = "Volume")]
    pub label_names: Option<PathBuf>,
}

impl Cli {
    /// Reads the command line. Help and the version are printed by clap, which then ends the program.
    ///
    /// # Errors
    /// [`Failure::Usage`] for anything else that is no command.
    pub fn from_command_line() -> Result<Self, Failure> {
        let matches = match Self::command().try_get_matches() {
            // Renderers are asked for their features and options only where help is read.
            Err(e) if e.kind() == ErrorKind::DisplayHelp => help::complete(Self::command()).try_get_matches(),
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
}

/// Returns a message of clap without its usage lines.
fn first_words(message: &str) -> &str {
    let end = message.find("\nUsage:").or_else(|| message.find("\nFor more information")).unwrap_or(message.len());
    message[..end].trim_start_matches("error: ").trim_end()
}
