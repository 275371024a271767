//! Labels of a scene with their names and colours, as slices show them.

use std::collections::BTreeMap;
use std::path::PathBuf;

use glam::DVec3;
use vr_core::labels::LabelMap;
use vr_io::{FileError, LabelName, LabelsSection, LoadedLabels, read_labels};
use vr_look::label_color;

use super::slice::PlaceLabel;

/// Files of a scene's labels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LabelFiles {
    /// The labels.
    pub file: PathBuf,
    /// A list of their names and colours.
    pub names: Option<PathBuf>,
}

/// Labels of a file.
pub struct ReadLabels {
    map: LabelMap,
    /// Look of every label but the background, in the file's own colours.
    looks: BTreeMap<i32, PlaceLabel>,
}

/// Labels of a file in the colours of a scene.
#[derive(Clone, Copy)]
pub struct LabelLooks<'a> {
    read: &'a ReadLabels,
    section: Option<&'a LabelsSection>,
}

impl ReadLabels {
    /// Reads the files.
    ///
    /// # Errors
    /// Errors of [`read_labels`].
    pub fn read(files: &LabelFiles) -> Result<Self, FileError> {
        let LoadedLabels { map, entries, .. } = read_labels(&files.file, files.names.as_deref())?;
        let all = map.labels().iter().copied().filter(|&label| label != 0).enumerate();
        let looks = all.map(|(rank, number)| {
            let entry = entries.iter().find(|entry| entry.label == number);
            let color = entry.and_then(|entry| entry.color).unwrap_or_else(|| label_color(rank));
            (number, PlaceLabel { number, name: entry.and_then(|entry| entry.name.clone()), color })
        });
        let looks = looks.collect();
        Ok(Self { map, looks })
    }

    /// Returns the labels in the colours that a scene's section states, and in the file's own where it states none.
    pub fn under<'a>(&'a self, section: Option<&'a LabelsSection>) -> LabelLooks<'a> {
        LabelLooks { read: self, section }
    }
}

impl LabelLooks<'_> {
    /// Number of the label at a world position; `None` for the background.
    pub fn number_at(&self, at: DVec3) -> Option<i32> {
        Some(self.read.map.label_at(at)).filter(|number| self.read.looks.contains_key(number))
    }

    /// Returns the look of a label; `None` for the background, and for numbers that no label has.
    pub fn look(&self, number: i32) -> Option<PlaceLabel> {
        let mut look = self.read.looks.get(&number)?.clone();
        let choices = self.section.iter().flat_map(|section| section.label.iter().rev());
        let mut of_label = choices.filter(|choice| choice.label == LabelName::Number(number));
        if let Some(color) = of_label.find_map(|choice| choice.color) {
            look.color = color;
        }
        Some(look)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_io::LabelSection;

    #[test]
    fn one_file_shows_the_colours_of_each_section() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("labels.nrrd");
        let head = "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: raw\n\n";
        std::fs::write(&file, [head.as_bytes(), &[0, 3, 0, 3, 0, 3, 0, 3]].concat()).unwrap();
        let read = ReadLabels::read(&LabelFiles { file, names: None }).unwrap();
        let color_under = |choices: &[[f64; 3]]| {
            let label = choices.iter().map(|&color| LabelSection {
                label: LabelName::Number(3),
                color: Some(color),
                ..Default::default()
            });
            let section = LabelsSection { label: label.collect(), ..LabelsSection::default() };
            let looks = read.under(Some(&section));
            let found: Vec<_> = read.looks.keys().map(|&number| looks.look(number).unwrap().color).collect();
            assert_eq!(found.len(), 1);
            found[0]
        };
        let [blue, red] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
        assert_eq!(color_under(&[blue]), blue);
        // The later of two choices comes first.
        assert_eq!(color_under(&[blue, red]), red);
        assert_eq!(color_under(&[]), label_color(0));
    }
}
