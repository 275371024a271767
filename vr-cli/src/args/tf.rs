//! Flags of `vr tf` and `vr presets`.

use std::path::PathBuf;

use clap::Args;

use super::{RendererArgs, ReplaceArgs, SceneArgs, VolumeArgs, value};

/// `vr tf`.
#[derive(Debug, Args)]
pub struct TfArgs {
    /// A preset; a file of ParaView (.json, .xml), 3D Slicer (.vp, .vp.json), VTK (.xml), ImageJ (.lut), a table (.csv, .tsv) or TOML; or auto,
    /// the look that is found from the volume
    #[arg(value_name = "PRESET|FILE|auto")]
    pub source: PathBuf,
    /// The volume that it is for; without one, a preset that has no values of its own is spread over 0 to 1.
    #[command(flatten)]
    pub volume: VolumeArgs,
    /// Values that it is stretched over
    #[arg(long, value_name = "LOW,HIGH", value_parser = value::pair, allow_hyphen_values = true, help_heading = "Transfer function")]
    pub range: Option<[f64; 2]>,
    /// Write it: .png draws it, over the volume's histogram (one with rows by gradient over that of value and gradient); .json (ParaView), .vp (3D Slicer), .csv, .tsv, .toml or .lut (ImageJ) convert it;
    /// may be repeated
    #[arg(long = "output", short, value_name = "FILE", help_heading = "Output")]
    pub outputs: Vec<PathBuf>,
    /// Files that are there.
    #[command(flatten)]
    pub replace: ReplaceArgs,
}

/// `vr presets`.
#[derive(Debug, Args)]
pub struct PresetsArgs {
    /// The scene; its transfer function gives way to each preset.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The renderer and its options.
    #[command(flatten)]
    pub renderer: RendererArgs,
    /// Draw all presets, also those that are made for other data
    #[arg(long, help_heading = "Contact sheet")]
    pub all: bool,
    /// Contact sheet to write
    #[arg(long, short, value_name = "FILE", default_value = "vr-presets.png", help_heading = "Contact sheet")]
    pub output: PathBuf,
    /// Files that are there.
    #[command(flatten)]
    pub replace: ReplaceArgs,
    /// Write each picture by itself, too, into this folder, with a record from which vr rerun draws it again
    #[arg(long, value_name = "FOLDER", help_heading = "Contact sheet")]
    pub pictures: Option<PathBuf>,
}
