//! `vr report` and `vr verify`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::SceneArgs;

/// Set of measurements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SuiteName {
    /// Speed against error in small pictures, and orders of convergence: less than a minute on two cores.
    Quick,
    /// Everything, on larger volumes, in larger pictures, from three sides.
    Full,
    /// Every renderer on every hard case.
    Hard,
    /// Growth of times with threads, volumes and pictures.
    Scaling,
}

/// `vr report`.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Set of measurements
    #[arg(long, value_name = "SUITE", default_value = "quick", help_heading = "Report")]
    pub suite: SuiteName,
    /// Folder of the report: index.html, points.csv, report.json, errors.json, the headline for a front page, and scene.toml of a scene of one's own
    #[arg(long, short, value_name = "FOLDER", default_value = "vr-report", help_heading = "Report")]
    pub output: PathBuf,
    /// Measure only this renderer; may be repeated
    #[arg(long = "renderer", value_name = "NAME", help_heading = "Report")]
    pub renderers: Vec<String>,
    /// Time nothing: errors and counts alone, which are the same in every run
    #[arg(long, help_heading = "Report")]
    pub untimed: bool,
    /// Replace files in the folder that are no earlier report
    #[arg(long, help_heading = "Report")]
    pub force: bool,
    /// Print the whole table of times and the names of all files, not a summary
    #[arg(long, help_heading = "Report")]
    pub all: bool,
    /// Fail if errors or counts are worse than in this errors.json
    #[arg(long, value_name = "FILE", help_heading = "Report")]
    pub baseline: Option<PathBuf>,
    /// Reference pixels that are kept.
    #[command(flatten)]
    pub cache: CacheArgs,
}

/// Reference pixels that are kept.
#[derive(Debug, Args)]
#[command(next_help_heading = "Reference pixels")]
pub struct CacheArgs {
    /// Folder in which reference pixels are kept; the user's own folder for caches if absent
    #[arg(long, value_name = "FOLDER")]
    pub cache: Option<PathBuf>,
    /// Keep no reference pixels, and use none that were kept
    #[arg(long, conflicts_with = "cache")]
    pub no_cache: bool,
}

/// `vr verify`.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Verify only this renderer; may be repeated
    #[arg(long = "renderer", value_name = "NAME", help_heading = "Verification")]
    pub renderers: Vec<String>,
    /// Reference pixels that are kept.
    #[command(flatten)]
    pub cache: CacheArgs,
}
