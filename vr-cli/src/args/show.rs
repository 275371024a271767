//! Flag for a picture in the terminal.

use clap::{Args, ValueEnum};

/// Protocol by which a terminal is shown a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Protocol {
    /// The one that the terminal's variables tell, else half blocks.
    Auto,
    /// Kitty's graphics: kitty, Ghostty.
    Kitty,
    /// Inline images: iTerm2, WezTerm.
    Iterm,
    /// Sixel: foot, mlterm, xterm with that support.
    Sixel,
    /// Characters in two colours each: every terminal.
    Blocks,
}

/// The picture in the terminal.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Output")]
pub struct ShowArgs {
    /// Show the picture on stdout, too: by what the terminal understands, or by kitty, iterm, sixel or blocks. As wide as the terminal at
    /// most; 80 columns where stdout is none
    #[arg(long, value_name = "HOW", num_args = 0..=1, require_equals = true, default_missing_value = "auto",
          hide_possible_values = true)]
    pub show: Option<Protocol>,
}
