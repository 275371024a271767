//! Descriptions of a scene for a page: one when it is opened, and its state after each change.

use glam::DVec3;
use serde::Serialize;
use vr_core::transfer::Preset;
use vr_core::{Clip, Field, Scene, Volume};
use vr_io::{FileInfo, RenderSection, ShadingSection, TransferSection};
use vr_look::{Hints, Histogram, Survey};

use super::document::{Document, refusal};
use super::edit::Quality;
use super::picture::ClientId;
use super::subject::Subject;

/// Bars of the histogram.
const BINS: usize = 256;

/// All of a subject that edits do not change.
#[derive(Clone, Debug, Serialize)]
pub struct Opened {
    /// Number of volumes that were opened before.
    pub volume: u64,
    /// The volume in a few words.
    pub title: String,
    /// Notes on everything assumed, one line each.
    pub notes: Vec<String>,
    /// Corners of the world box around the volume.
    pub bounds: [DVec3; 2],
    /// True if the world is a patient's: x to the right side, y to the front, z to the head (RAS).
    pub patient: bool,
    /// Unit of lengths, if the file names one.
    pub unit: Option<String>,
    /// Smallest and largest value.
    pub range: [f64; 2],
    /// Voxels in bins of equal width over the range, or shares of what a survey has sampled.
    pub histogram: Vec<u64>,
    /// Names and titles of presets, those that suit the volume first.
    pub presets: Vec<PresetName>,
    /// World length between voxels, the usual unit of opacities.
    pub spacing: f64,
    /// World lengths along x, y and z between voxels: the steps from slice to slice.
    pub steps: DVec3,
    /// True if the volume has gradients, so that opacity can follow their magnitude.
    pub has_gradient: bool,
}

/// A preset.
#[derive(Clone, Debug, Serialize)]
pub struct PresetName {
    /// Name in scene files.
    pub name: &'static str,
    /// Title for people.
    pub title: &'static str,
    /// True if it suits the volume.
    pub suits: bool,
}

impl Opened {
    /// Describes a subject; `scene` is the one around it.
    pub(super) fn of(subject: &Subject, scene: &Scene, revision: u64) -> Self {
        let volume = &scene.volume;
        let info = subject.volume.info.as_ref();
        let (low, high) = volume.value_range().unwrap_or((0.0, 1.0));
        let survey = Survey::of(volume);
        let histogram = match volume.value_grid() {
            Some(grid) => Histogram::of(grid, BINS),
            None => Some(survey.histogram((low, high), BINS)),
        };
        let (low_corner, high_corner) = volume.bounds();
        let hints = info.map(FileInfo::hints).unwrap_or_default();
        let hints = Hints { compositing: scene.compositing, ..hints };
        let modality = info.and_then(|info| info.modality.as_deref());
        let suitable = survey.suitable_presets((low, high), modality, &hints);
        let others = Preset::ALL.iter().filter(|preset| !suitable.contains(preset));
        let named = |preset: &Preset, suits| PresetName { name: preset.name(), title: preset.title(), suits };
        Self {
            volume: revision,
            title: subject.title.clone(),
            notes: subject.notes.clone(),
            bounds: [low_corner, high_corner],
            patient: subject.is_patient(),
            unit: info.and_then(|info| info.units.clone()),
            range: [low, high],
            histogram: histogram.map(|histogram| histogram.counts).unwrap_or_default(),
            presets: suitable.iter().map(|p| named(p, true)).chain(others.map(|p| named(p, false))).collect(),
            spacing: volume.mean_spacing(),
            steps: steps(volume),
            has_gradient: volume.field().is_none_or(Field::has_gradient),
        }
    }
}

/// World lengths between slices: of a grid, the edges of a voxel that go most nearly along each axis; of other kinds, their spacing.
fn steps(volume: &Volume) -> DVec3 {
    let Some(grid) = volume.value_grid() else { return DVec3::splat(volume.mean_spacing()) };
    let axes = grid.placement().axes();
    let along = |world: usize| {
        let edges = [axes.x_axis, axes.y_axis, axes.z_axis].map(|edge| (edge.normalize()[world].abs(), edge.length()));
        edges.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, length)| length)
    };
    DVec3::new(along(0), along(1), along(2))
}

/// The scene after a change, but for the camera, which comes with each picture.
#[derive(Clone, Debug, Serialize)]
pub struct State {
    /// The client that made the change, and its number.
    pub by: Option<(ClientId, u64)>,
    /// The transfer function.
    pub transfer: Option<TransferSection>,
    /// The shading.
    pub shading: Option<ShadingSection>,
    /// The crop box and the planes.
    pub clip: Clip,
    /// Linear RGB behind everything.
    pub background: [f32; 3],
    /// The renderer, its options, its bound, and the compositing operator.
    pub render: RenderSection,
    /// Quality of the picture at rest, where it has a name.
    pub quality: Option<Quality>,
    /// Qualities that can be chosen.
    pub qualities: Vec<Quality>,
    /// The renderers, and why some do not draw this scene.
    pub renderers: Vec<RendererName>,
    /// True if there is a change to take back.
    pub can_undo: bool,
    /// True if there is a change to make again.
    pub can_redo: bool,
}

/// A renderer, as it can be chosen or not.
#[derive(Clone, Debug, Serialize)]
pub struct RendererName {
    /// Its name.
    pub name: &'static str,
    /// The reason why it does not draw the scene; `None` if it does.
    pub refusal: Option<String>,
}

impl State {
    pub(super) fn of(document: &Document, by: Option<(ClientId, u64)>) -> Self {
        let file = document.file();
        let [can_undo, can_redo] = document.history();
        let named = |r: &dyn vr_core::StudiedRenderer| RendererName { name: r.name(), refusal: refusal(document, r) };
        Self {
            by,
            transfer: file.transfer,
            shading: file.shading,
            clip: file.clip,
            background: file.image.background,
            render: file.render,
            quality: document.quality(),
            qualities: document.qualities(),
            renderers: document.renderers().all.iter().map(|r| named(&**r)).collect(),
            can_undo,
            can_redo,
        }
    }
}
