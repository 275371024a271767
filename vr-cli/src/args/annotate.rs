//! Flags for what is written over a picture.

use clap::{Args, ValueEnum};
use vr_io::AnnotationsSection;

/// Something to be drawn over a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Annotation {
    /// All of these.
    All,
    /// Nothing of these, whatever the scene file says.
    None,
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
    /// values), or all; none takes away what the scene file asks for
    #[arg(long, value_name = "WHAT", value_delimiter = ',', hide_possible_values = true)]
    pub annotate: Vec<Annotation>,
    /// Write a title over the PNG; '' takes that of the scene file away
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
}

impl AnnotateArgs {
    /// Returns what is drawn over a picture: what the scene file asks for, with the flags in place of what they override.
    pub fn over(&self, file: &AnnotationsSection) -> AnnotationsSection {
        let mut section = file.clone();
        if !self.annotate.is_empty() {
            let wants = |what| self.annotate.contains(&what) || self.annotate.contains(&Annotation::All);
            section.marker = wants(Annotation::Marker);
            section.scale = wants(Annotation::Scale);
            section.legend = wants(Annotation::Legend);
        }
        if let Some(title) = &self.title {
            section.title = Some(title.clone()).filter(|title| !title.is_empty());
        }
        section
    }

    /// Returns the flag that asks for something to be drawn, if there is one.
    pub fn flag(&self) -> Option<&'static str> {
        let asked = self.over(&AnnotationsSection::default());
        let drawn = [("--annotate", asked.marker || asked.scale || asked.legend), ("--title", asked.title.is_some())];
        drawn.iter().find(|(_, asked)| *asked).map(|(flag, _)| *flag)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_take_the_place_of_what_they_name() {
        let file = AnnotationsSection { title: Some("File".to_owned()), marker: true, ..AnnotationsSection::default() };
        let flags = |annotate: &[Annotation], title: Option<&str>| AnnotateArgs {
            annotate: annotate.to_vec(),
            title: title.map(str::to_owned),
        };
        assert_eq!(flags(&[], None).over(&file), file);
        let scale = flags(&[Annotation::Scale], None);
        assert_eq!(scale.over(&file), AnnotationsSection { marker: false, scale: true, ..file.clone() });
        assert_eq!((scale.flag(), flags(&[Annotation::None], Some("")).flag()), (Some("--annotate"), None));
        assert_eq!(flags(&[Annotation::None], Some("")).over(&file), AnnotationsSection::default());
        let titled = flags(&[Annotation::All], Some("Flag"));
        let all = AnnotationsSection { title: Some("Flag".to_owned()), marker: true, scale: true, legend: true };
        assert_eq!(titled.over(&file), all);
    }
}
