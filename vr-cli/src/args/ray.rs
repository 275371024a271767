//! `vr ray`.

use std::path::PathBuf;

use clap::Args;

use super::{RendererArgs, ReplaceArgs, SceneArgs};

/// `vr ray`.
#[derive(Debug, Args)]
pub struct RayArgs {
    /// Column of the pixel, from 0 at the left
    #[arg(value_name = "X", allow_negative_numbers = true)]
    pub x: i64,
    /// Row of the pixel, from 0 at the top
    #[arg(value_name = "Y", allow_negative_numbers = true)]
    pub y: i64,
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The renderer and its options.
    #[command(flatten)]
    pub renderer: RendererArgs,
    /// Write every row of the table to a file: one per step or, of a renderer that cannot list them, per part of the reference
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub csv: Option<PathBuf>,
    /// Files that are there.
    #[command(flatten)]
    pub replace: ReplaceArgs,
    /// Print all rows of a long table, not only those that matter most
    #[arg(long, help_heading = "Output")]
    pub all: bool,
}
