//! Flags for what is written over a picture.

use clap::{Args, ValueEnum};

/// Something to be drawn over a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Annotation {
    /// All of these.
    All,
    /// Axes that turn with the camera.
    Marker,
    /// Bar of a round length.
    Scale,
    /// Colours and opacities of the values.
    Legend,
}

/// Annotations.
#[derive(Debug, Args)]
#[command(next_help_heading = "Annotations")]
pub struct AnnotateArgs {
    /// Draw over the PNG, apart by commas: marker (axes that turn with the camera: R L A P S I of a patient), scale (bar), legend (of
    /// values), or all
    #[arg(long, value_name = "WHAT", value_delimiter = ',', hide_possible_values = true)]
    pub annotate: Vec<Annotation>,
    /// Write a title over the PNG
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
}

impl AnnotateArgs {
    /// True if nothing is to be drawn.
    pub fn is_empty(&self) -> bool {
        self.annotate.is_empty() && self.title.is_none()
    }

    /// Returns the flag that asks for something to be drawn.
    pub fn flag(&self) -> &'static str {
        if self.annotate.is_empty() { "--title" } else { "--annotate" }
    }
}
