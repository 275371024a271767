//! Conversion of a `[labels]` section and a scene of a volume to the scene of the labelled volume.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use vr_core::labels::{LabelError, LabelMap, LabelStyle, LabelledGrid};
use vr_core::{GridVolume, ParameterError, Scene, Volume};
use vr_look::label_color;

use super::error::SceneFileError;
use super::file_name::FileName;
use super::labels_section::{LabelLook, LabelName, LabelSection, LabelsSection};
use crate::error::{FileError, shown_path};
use crate::labels::{LabelEntry, LoadedLabels, read_labels};
use crate::read::FileInfo;
use crate::world::Space;

/// Factor on the opacities of what has no label, where the transfer function is automatic: labels show through it.
const FAINT: f64 = 0.12;

/// Labels of a scene, read and ready to be laid over its volume.
pub(super) struct SceneLabels<'a> {
    section: &'a LabelsSection,
    path: PathBuf,
    loaded: LoadedLabels,
}

impl<'a> SceneLabels<'a> {
    /// Reads the files of a section, relative to a folder.
    ///
    /// # Errors
    /// Errors of [`read_labels`].
    pub(super) fn read(section: &'a LabelsSection, folder: &Path) -> Result<Self, SceneFileError> {
        let path = folder.join(&section.file);
        let list = section.names.as_ref().map(|names| folder.join(names));
        let loaded = read_labels(&path, list.as_deref())?;
        Ok(Self { section, path, loaded })
    }

    /// Every file that was read.
    pub(super) fn files(&self) -> &[PathBuf] {
        &self.loaded.files
    }

    /// Lays the labels over the volume of a scene; returns that scene, and a section in which the style of every label is stated. `automatic` tells that the transfer function was found from the volume; `info` is what its
    /// file says.
    ///
    /// # Errors
    /// A volume that is no grid, labels of another place, and choices that mean nothing.
    pub(super) fn over(
        &self,
        scene: Scene,
        automatic: bool,
        info: Option<&FileInfo>,
        notes: &mut Vec<String>,
        in_file: impl Fn(ParameterError) -> SceneFileError,
    ) -> Result<(Scene, LabelsSection), SceneFileError> {
        let volume = match &scene.volume {
            Volume::Grid(grid) => Arc::clone(grid),
            other => {
                let allowed = "only a grid can have labels";
                let error = ParameterError { field: "labels.file".into(), found: other.kind().to_owned(), allowed };
                return Err(in_file(error));
            }
        };
        notes.extend(self.loaded.notes.iter().map(|note| format!("{}: {note}", shown_path(&self.path))));
        self.note_place(&volume, info, notes);
        let styles = Styles::new(self, automatic).map_err(&in_file)?;
        let map = Arc::new(self.loaded.map.clone());
        let labelled = LabelledGrid::new(volume, map, |label| styles.of(label));
        let labelled = labelled.map_err(|e| self.failure(e, &in_file))?;
        let labelled = match &scene.shading {
            Some(shading) => labelled.with_gradient(shading.gradient),
            None => labelled,
        };
        notes.push(styles.note());
        let transfer = labelled.transfer(&scene.transfer).map_err(&in_file)?;
        let scene = Scene { volume: Volume::Field(Arc::new(labelled)), transfer: Arc::new(transfer), ..scene };
        scene.validate().map_err(in_file)?;
        Ok((scene, styles.stated(&self.section.file)))
    }

    /// True if a label is drawn as a solid, which wants shading.
    pub(super) fn has_solids(&self) -> bool {
        let others = self.section.look.is_none_or(|look| look == LabelLook::Solid) && !self.section.mask;
        others || self.section.label.iter().any(|l| l.look == Some(LabelLook::Solid))
    }

    /// Says what may have gone wrong where labels and volume were made apart from each other.
    fn note_place(&self, volume: &GridVolume, info: Option<&FileInfo>, notes: &mut Vec<String>) {
        let (labels, path) = (&self.loaded.info, shown_path(&self.path));
        let own = |space: Space| space == Space::Own;
        if let Some(volume) = info.filter(|info| own(info.space) != own(labels.space)) {
            notes.push(format!(
                "{path}: its positions are in the space {}, and those of the volume in {}: they may not fit",
                labels.space.name(),
                volume.space.name()
            ));
        }
        let map = &self.loaded.map;
        if map.dims() == volume.dims() && map.placement() != volume.placement() && labels.placed_by == "assumed" {
            notes.push(format!("{path}: has as many voxels as the volume and no placement of its own"));
        }
        if map.labels() == [0] {
            notes.push(format!("{path}: all voxels are 0, the background"));
        } else if !is_any_inside(map, volume) {
            notes.push(format!("{path}: no labelled voxel lies in the volume: one of the two is in another place or patient space (LPS, RAS)"));
        }
    }

    /// The failure of labels beside a volume: of the file, or of a choice about a label.
    fn failure(&self, error: LabelError, in_file: &impl Fn(ParameterError) -> SceneFileError) -> SceneFileError {
        match error {
            LabelError::Style { label, what, found, allowed } => {
                in_file(ParameterError { field: format!("labels.label {label}: {what}"), found, allowed })
            }
            other => FileError::new(&self.path, other).into(),
        }
    }
}

/// True if a label other than the background lies in a volume's box, of a million voxels at most that are looked at.
fn is_any_inside(map: &LabelMap, volume: &GridVolume) -> bool {
    const MAX_SIDE: usize = 100;
    let strides = map.dims().map(|n| n.div_ceil(MAX_SIDE));
    let last = DVec3::from_array(volume.dims().map(|n| n as f64 - 1.0));
    let along = |axis: usize| (0..map.dims()[axis]).step_by(strides[axis]).map(|i| i as f64);
    along(2).any(|z| {
        along(1).any(|y| {
            along(0).any(|x| {
                let at = map.placement().to_world(DVec3::new(x, y, z));
                let index = volume.placement().to_index(at);
                index.cmpge(DVec3::ZERO).all() && index.cmple(last).all() && map.label_at(at) != 0
            })
        })
    })
}

/// Style of each label.
struct Styles {
    /// Label, name and style, for every label of the map.
    all: Vec<(i32, Option<String>, LabelStyle)>,
}

impl Styles {
    fn new(labels: &SceneLabels<'_>, automatic: bool) -> Result<Self, ParameterError> {
        let SceneLabels { section, loaded, .. } = labels;
        let map = &loaded.map;
        let mut chosen: Vec<(i32, &LabelSection)> = Vec::new();
        for (i, choice) in section.label.iter().enumerate() {
            chosen.push((number(&choice.label, loaded, i)?, choice));
        }
        // Other things in front, the background is faint.
        let has_labels = map.labels().iter().any(|&l| l != 0);
        let background = if automatic && has_labels { FAINT } else { 1.0 };
        let mut rank = 0;
        let mut all = Vec::with_capacity(map.labels().len());
        for &label in map.labels() {
            let entry = loaded.entries.iter().find(|e| e.label == label).cloned();
            let entry = entry.unwrap_or(LabelEntry { label, ..LabelEntry::default() });
            let color = entry.color.unwrap_or_else(|| label_color(rank));
            rank += usize::from(label != 0);
            // The section's own rule, then what is said of this label, the last word first.
            let of_label = || chosen.iter().rev().filter(|c| c.0 == label).map(|c| c.1);
            let visible = of_label().find_map(|c| c.visible);
            let look = of_label().find_map(|c| c.look);
            let opacity = of_label().find_map(|c| c.opacity);
            let color = of_label().find_map(|c| c.color).unwrap_or(color);
            let by_default =
                if label == 0 || section.mask { LabelLook::Volume } else { section.look.unwrap_or(LabelLook::Solid) };
            let hidden_by_default = if label == 0 { section.mask } else { entry.visible == Some(false) };
            // A choice of look or opacity shows what the file hides.
            let named = look.is_some() || opacity.is_some();
            let style = if !visible.unwrap_or(named || !hidden_by_default) {
                LabelStyle::Hidden
            } else {
                match look.unwrap_or(by_default) {
                    LabelLook::Solid => LabelStyle::Solid { color, opacity: opacity.or(entry.opacity).unwrap_or(1.0) },
                    LabelLook::Tinted => LabelStyle::Tinted { color, opacity: opacity.unwrap_or(1.0) },
                    LabelLook::Volume => {
                        let own = if label == 0 { background } else { 1.0 };
                        LabelStyle::Volume { opacity: opacity.unwrap_or(own) }
                    }
                }
            };
            all.push((label, entry.name, style));
        }
        Ok(Self { all })
    }

    fn of(&self, label: i32) -> LabelStyle {
        self.all.binary_search_by_key(&label, |l| l.0).map_or(LabelStyle::VOLUME, |i| self.all[i].2)
    }

    /// The section that states every style: it needs no list of names, and leaves nothing to a rule.
    fn stated(&self, file: &FileName) -> LabelsSection {
        let label = |&(label, _, style): &(i32, Option<String>, LabelStyle)| {
            let own = LabelSection { label: LabelName::Number(label), ..LabelSection::default() };
            match style {
                LabelStyle::Hidden => LabelSection { visible: Some(false), ..own },
                LabelStyle::Volume { opacity } => {
                    LabelSection { opacity: Some(opacity), look: Some(LabelLook::Volume), ..own }
                }
                LabelStyle::Tinted { color, opacity } => {
                    LabelSection { color: Some(color), opacity: Some(opacity), look: Some(LabelLook::Tinted), ..own }
                }
                LabelStyle::Solid { color, opacity } => {
                    LabelSection { color: Some(color), opacity: Some(opacity), look: Some(LabelLook::Solid), ..own }
                }
            }
        };
        LabelsSection { file: file.clone(), label: self.all.iter().map(label).collect(), ..LabelsSection::default() }
    }

    /// One line on what is drawn.
    fn note(&self) -> String {
        const MAX_NAMES: usize = 12;
        let count = self.all.iter().filter(|l| l.0 != 0).count();
        let mut names: Vec<String> = Vec::new();
        for (label, name, style) in self.all.iter().filter(|l| l.0 != 0).take(MAX_NAMES) {
            let name = name.as_ref().map_or(String::new(), |name| format!(" {name}"));
            let how = match style {
                LabelStyle::Hidden => " (hidden)",
                LabelStyle::Volume { .. } => " (as the volume)",
                LabelStyle::Tinted { .. } => " (tinted)",
                LabelStyle::Solid { .. } => "",
            };
            names.push(format!("{label}{name}{how}"));
        }
        if count > MAX_NAMES {
            names.push(format!("and {} more", count - MAX_NAMES));
        }
        let rest = match self.of(0) {
            LabelStyle::Hidden => "the rest is hidden".to_owned(),
            LabelStyle::Volume { opacity: 1.0 } => "the rest is the volume".to_owned(),
            LabelStyle::Volume { opacity } => format!("the rest is the volume, its opacities times {opacity}"),
            LabelStyle::Tinted { .. } => "the rest is tinted".to_owned(),
            LabelStyle::Solid { .. } => "the rest is solid".to_owned(),
        };
        format!("labels: {}; {rest}", names.join(", "))
    }
}

/// Number of a label that a choice is about.
fn number(name: &LabelName, loaded: &LoadedLabels, choice: usize) -> Result<i32, ParameterError> {
    let wrong =
        |found: String, allowed| ParameterError { field: format!("labels.label[{choice}].label"), found, allowed };
    match name {
        LabelName::Number(label) if loaded.map.labels().contains(label) => Ok(*label),
        LabelName::Number(label) => {
            let all: Vec<String> = loaded.map.labels().iter().take(40).map(i32::to_string).collect();
            Err(wrong(format!("{label}, among the labels {}", all.join(", ")), "must be a label that a voxel has"))
        }
        LabelName::Name(name) => {
            let same = |e: &&LabelEntry| e.name.as_ref().is_some_and(|n| n.to_lowercase() == name.to_lowercase());
            if let Some(entry) = loaded.entries.iter().find(same) {
                return Ok(entry.label);
            }
            // A number in quotes, as flags have it.
            if let Ok(label) = name.parse() {
                return number(&LabelName::Number(label), loaded, choice);
            }
            let all: Vec<&str> = loaded.entries.iter().filter_map(|e| e.name.as_deref()).take(40).collect();
            let known = if all.is_empty() { "no name".to_owned() } else { all.join(", ") };
            Err(wrong(format!("'{name}', and the files have {known}"), "must be a label's number or its name"))
        }
    }
}
