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

/// Labels, each with its look.
pub struct LabelLooks {
    map: LabelMap,
    /// Every label but the background.
    looks: BTreeMap<i32, PlaceLabel>,
}

impl LabelLooks {
    /// Reads the files; colours are those of the picture where the section states them, then the file's own.
    ///
    /// # Errors
    /// Errors of [`read_labels`].
    pub fn read(files: &LabelFiles, section: Option<&LabelsSection>) -> Result<Self, FileError> {
        let LoadedLabels { map, entries, .. } = read_labels(&files.file, files.names.as_deref())?;
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
        let looks = looks.collect();
        Ok(Self { map, looks })
    }

    /// The label of a world position; `None` for the background.
    pub fn at(&self, at: DVec3) -> Option<&PlaceLabel> {
        self.looks.get(&self.map.label_at(at))
    }
}
