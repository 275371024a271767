//! Flags for what is written over a picture.

use clap::{Args, ValueEnum};
use vr_io::RecordSection;

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
    /// Writes what is drawn over a picture into its record.
    pub fn record(&self, record: &mut RecordSection) {
        let name = |what: &Annotation| what.to_possible_value().map(|value| value.get_name().to_owned());
        record.annotations = self.annotate.iter().filter_map(name).collect();
        record.title.clone_from(&self.title);
    }

    /// Returns what is drawn over the picture of a record.
    ///
    /// # Errors
    /// The name of an annotation that this version does not know.
    pub fn of_record(record: &RecordSection) -> Result<Self, String> {
        let known = |name: &String| {
            Annotation::from_str(name, false)
                .map_err(|_| format!("annotation {name:?}, which this version does not know"))
        };
        let annotate = record.annotations.iter().map(known).collect::<Result<_, _>>()?;
        Ok(Self { annotate, title: record.title.clone() })
    }

    /// True if nothing is to be drawn.
    pub fn is_empty(&self) -> bool {
        self.annotate.is_empty() && self.title.is_none()
    }

    /// Returns the flag that asks for something to be drawn.
    pub fn flag(&self) -> &'static str {
        if self.annotate.is_empty() { "--title" } else { "--annotate" }
    }
}
