//! Arguments of `vr rerun`.

use std::path::PathBuf;

use clap::Args;

use super::ReplaceArgs;

/// `vr rerun`.
#[derive(Debug, Args)]
#[command(after_help = DETAILS)]
pub struct RerunArgs {
    /// The picture, a PNG or EXR that vr render has written; vr info prints the record in it
    #[arg(value_name = "PICTURE")]
    pub picture: PathBuf,
    /// The volume, if the picture is of a file: the record holds its name and its hash, not its place
    #[arg(value_name = "VOLUME")]
    pub volume: Option<PathBuf>,
    /// The mesh, if the picture shows one
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// The labels, if the picture shows some
    #[arg(long, value_name = "FILE")]
    pub labels: Option<PathBuf>,
    /// The picture of the light from all sides, if there was one
    #[arg(long, value_name = "FILE")]
    pub environment_map: Option<PathBuf>,
    /// DICOM: the series, by its SeriesInstanceUID or its number, where there are several
    #[arg(long, value_name = "UID|NUMBER", requires = "volume")]
    pub series: Option<String>,
    /// Go on with a volume, a mesh, labels or an environment map that is not the recorded one
    #[arg(long)]
    pub anyway: bool,
    /// Picture to write: .png or .exr
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Files that are there.
    #[command(flatten)]
    pub replace: ReplaceArgs,
}

const DETAILS: &str = "\
The picture is drawn again from the record in it and compared with it, bit for bit. Exit code 0: every pixel is the same.
Exit code 1: pixels differ, or the volume is not the one in the record.";
