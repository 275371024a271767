//! Choice of replacing files that are in the place of an output.

use clap::Args;

/// Choice of replacing files that are in the place of an output.
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct ReplaceArgs {
    /// Replace files that are there, too, which are no pictures of vr's
    #[arg(long, help_heading = "Output", hide_short_help = true)]
    pub force: bool,
}
