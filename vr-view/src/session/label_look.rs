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

/// Labels as their files have them.
pub struct ReadLabels(LoadedLabels);

/// Labels, each with its look.
pub struct LabelLooks<'a> {
    map: &'a LabelMap,
    /// Every label but the background.
    looks: BTreeMap<i32, PlaceLabel>,
}

impl ReadLabels {
    /// Reads the files.
    ///
    /// # Errors
    /// Errors of [`read_labels`].
    pub fn read(files: &LabelFiles) -> Result<Self, FileError> {
        read_labels(&files.file, files.names.as_deref()).map(Self)
    }

    /// Returns the looks: colours are those of the picture where the section states them, then the file's own.
    pub fn looks(&self, section: Option<&LabelsSection>) -> LabelLooks<'_> {
        let LoadedLabels { map, entries, .. } = &self.0;
        let chosen = |label: i32| {
            let of_label = section?.label.iter().rev().filter(|choice| choice.label == LabelName::Number(label));
            of_label.into_iter().find_map(|choice| choice.color)
        };
        let all = map.labels().iter().copied().filter(|&label| label != 0).enumerate();
        let looks = all.map(|(rank, number)| {
            let entry = entries.iter().find(|entry| entry.label == number);
            let own = entry.and_then(|entry| entry.color);
            let color = chosen(number).or(own).unwrap_or_else(|| label_color(rank));
            (number, PlaceLabel { number, name: entry.and_then(|entry| entry.name.clone()), color })
        });
        LabelLooks { map, looks: looks.collect() }
    }
}

impl LabelLooks<'_> {
    /// The label of a world position; `None` for the background.
    pub fn at(&self, at: DVec3) -> Option<&PlaceLabel> {
        self.looks.get(&self.map.label_at(at))
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
            let looks = read.looks(Some(&section));
            let found: Vec<_> = looks.looks.values().map(|look| look.color).collect();
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
