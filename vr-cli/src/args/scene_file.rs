//! Arguments of `vr scene`.

use std::path::PathBuf;

use clap::Args;

use super::{AnnotateArgs, CacheArgs, RendererArgs, ReplaceArgs, SceneArgs, TargetArgs};

/// `vr scene`.
#[derive(Debug, Args)]
pub struct SceneFileArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The renderer and its options.
    #[command(flatten)]
    pub renderer: RendererArgs,
    /// The cheapest picture within an error.
    #[command(flatten)]
    pub target: TargetArgs,
    /// Annotations.
    #[command(flatten)]
    pub annotations: AnnotateArgs,
    /// Scene file to write (TOML); printed if absent
    #[arg(long, short, value_name = "FILE", help_heading = "Output")]
    pub output: Option<PathBuf>,
    /// Files that are there.
    #[command(flatten)]
    pub replace: ReplaceArgs,
    /// Reference pixels that are kept.
    #[command(flatten)]
    pub cache: CacheArgs,
}
