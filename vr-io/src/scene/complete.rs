//! Scene files of which nothing is left open, and such as name no folder.

use std::path::Path;

use vr_core::{Options, Scene, View, Volume};

use crate::read::FileInfo;

use super::file_name::FileName;
use super::labels_section::LabelsSection;
use super::scattering_section::ScatteringSection;
use super::scene_file::SceneFile;
use super::sections::{CameraSection, RenderSection, ShadingSection, TransferSection};
use super::volume_section::{FileSource, VolumeSource};

/// Name that stands for a DICOM series, whose files and folders may be named after the patient.
const DICOM_NAME: &str = "DICOM series";

/// Largest number of digits of a DICOM series' number; UIDs have dots.
const MAX_SERIES_DIGITS: usize = 9;

impl SceneFile {
    /// The same scene with everything stated that this file leaves open, as it came to be in `scene` and `view`: the camera as eye, target
    /// and up, the transfer function as points, the shading that an automatic look has chosen. Of a scene with labels `scene` is the one before they are
    /// laid over its volume, and `labels` states their styles. `info` is what the volume's file says.
    /// The renderer is left as it is ([`Self::drawn_by`]).
    #[must_use]
    pub fn completed(
        &self,
        scene: &Scene,
        labels: Option<LabelsSection>,
        view: &View,
        info: Option<&FileInfo>,
    ) -> Self {
        let mut file = Self { labels, ..self.clone() };
        match &mut file.volume.source {
            Some(VolumeSource::File(source)) => complete_raw(source, &scene.volume, info),
            Some(VolumeSource::Phantom { size, .. }) => *size = scene.volume.grid().map(|grid| grid.dims()[0]),
            Some(VolumeSource::PhantomPoints { count, .. }) => {
                *count = scene.volume.points().map(|p| p.count()).or(*count);
            }
            _ => {}
        }
        file.volume.filter = scene.volume.filter();
        file.transfer = Some(TransferSection::describe(&scene.transfer));
        file.shading = Some(match &scene.shading {
            Some(shading) => ShadingSection::describe(shading, &scene.lights),
            None => ShadingSection { enabled: false, ..ShadingSection::default() },
        });
        let environment_map = file.scattering.take().and_then(|section| section.environment_map);
        file.scattering = scene.scattering.as_deref().map(|scattering| ScatteringSection {
            environment_map,
            ..ScatteringSection::describe(scattering, &scene.lights)
        });
        file.camera = Some(CameraSection::from(&view.camera));
        file.clip = view.clip.clone();
        file.image.size = view.size;
        file.image.samples = view.supersampling;
        file.image.background = scene.background;
        let RenderSection { compositing, threshold, level, .. } = RenderSection::describe(scene.compositing);
        (file.render.compositing, file.render.threshold, file.render.level) = (compositing, threshold, level);
        file
    }

    /// The same scene, drawn by a renderer of this name with these options and error bound.
    #[must_use]
    pub fn drawn_by(mut self, renderer: &str, options: Options, max_error: Option<f64>) -> Self {
        let renderer = Some(renderer.to_owned());
        self.render = RenderSection { renderer, options, max_error, ..self.render };
        self
    }

    /// The same scene with other paths in place of those of the files that are read for it.
    #[must_use]
    pub fn with_paths(mut self, change: impl Fn(&Path) -> FileName) -> Self {
        if let Some(VolumeSource::File(source)) = &mut self.volume.source {
            source.path = change(&source.path);
        }
        if let Some(labels) = &mut self.labels {
            labels.file = change(&labels.file);
        }
        if let Some(map) = self.scattering.as_mut().and_then(|scattering| scattering.environment_map.as_mut()) {
            *map = change(map);
        }
        if let Some(mesh) = &mut self.mesh {
            mesh.path = change(&mesh.path);
        }
        self
    }

    /// The same scene without folders: files by their names alone, and a DICOM series, as `info` tells it, without even one.
    #[must_use]
    pub fn without_folders(mut self, info: Option<&FileInfo>) -> Self {
        if let Some(VolumeSource::File(source)) = &mut self.volume.source
            && info.is_some_and(|info| info.format == "DICOM")
        {
            source.path = DICOM_NAME.into();
            // A number tells series of one scan apart; a UID is found in the patient's records.
            let is_number =
                |series: &String| series.len() <= MAX_SERIES_DIGITS && series.bytes().all(|c| c.is_ascii_digit());
            source.series = source.series.take().filter(is_number);
        }
        if let Some(labels) = &mut self.labels {
            labels.names = labels.names.as_deref().map(name_of);
        }
        if let Some(file) = self.transfer.as_mut().and_then(|transfer| transfer.file.as_mut()) {
            *file = name_of(file);
        }
        self.with_paths(name_of)
    }
}

/// Returns a file's name without its folder.
fn name_of(path: &Path) -> FileName {
    // A folder such as `..` has no name.
    path.file_name().unwrap_or("unnamed".as_ref()).into()
}

/// States size and type of a raw file, which its name may not tell where it is renamed.
fn complete_raw(source: &mut FileSource, volume: &Volume, info: Option<&FileInfo>) {
    if let (Some(info), Volume::Grid(grid)) = (info.filter(|info| info.format == "raw"), volume) {
        source.grid.dims.get_or_insert(grid.dims());
        source.grid.scalar.get_or_insert(info.scalar);
        source.endian.get_or_insert(info.endian);
    }
}
