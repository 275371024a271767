//! A whole scene file, and how it becomes a scene and a view, and back.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use vr_core::{Camera, Clip, ParameterError, Scene, View, Volume};

use crate::framing::default_angles;

use super::annotations_section::AnnotationsSection;
use super::inline::inline_volume;
use super::labels_section::LabelsSection;
use super::scattering_section::ScatteringSection;
use super::sections::{CameraSection, ImageSection, MeshSection, RenderSection, ShadingSection, TransferSection};
use super::transfer_points::TransferPoints;
use super::volume_section::VolumeSection;

/// A whole scene file.
///
/// Unknown keys are errors. The default of what is absent: trilinear, power rule, unit distance = mean spacing, linear colours,
/// no shading, no clipping, a picture of 512×512 pixels, filled by what is visible, before black. Without points, preset or file in
/// `[transfer]` the look is automatic: transfer function, shading and filter are found from the volume ([`vr_look`]).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SceneFile {
    /// The volume and its filter.
    pub volume: VolumeSection,
    /// Map from value to light; absent: found from the volume.
    pub transfer: Option<TransferSection>,
    /// Absent: unshaded, or as the automatic look has it.
    pub shading: Option<ShadingSection>,
    /// Absent: the medium absorbs and emits alone.
    pub scattering: Option<ScatteringSection>,
    /// Absent: what is visible, from slightly above and to the right; a patient from the front.
    pub camera: Option<CameraSection>,
    /// Absent: no opaque surface.
    pub mesh: Option<MeshSection>,
    /// Absent: no labels beside the volume.
    pub labels: Option<LabelsSection>,
    /// Crop box and clip planes.
    #[serde(skip_serializing_if = "cuts_nothing")]
    pub clip: Clip,
    /// Size, supersampling, background.
    pub image: ImageSection,
    /// Things that are drawn over the picture.
    #[serde(skip_serializing_if = "AnnotationsSection::is_empty")]
    pub annotations: AnnotationsSection,
    /// Renderer, compositing, and the renderer's own options.
    pub render: RenderSection,
}

fn cuts_nothing(clip: &Clip) -> bool {
    *clip == Clip::default()
}

impl SceneFile {
    /// Describes a scene whose volume is small enough to stand in the file; its surfaces and an environment map, which no such file can hold, are left out.
    ///
    /// # Errors
    /// A volume of more than 64³ voxels or 4096 points.
    pub fn describe(scene: &Scene, view: &View) -> Result<Self, ParameterError> {
        Ok(Self {
            volume: VolumeSection {
                source: Some(inline_volume(&scene.volume)?),
                filter: scene.volume.filter(),
                resample: None,
            },
            transfer: Some(TransferSection::describe(&scene.transfer)),
            shading: scene.shading.as_deref().map(|shading| ShadingSection::describe(shading, &scene.lights)),
            scattering: scene
                .scattering
                .as_deref()
                .map(|scattering| ScatteringSection::describe(scattering, &scene.lights)),
            camera: Some(CameraSection::from(&view.camera)),
            mesh: None,
            labels: None,
            clip: view.clip.clone(),
            image: ImageSection { size: view.size, samples: view.supersampling, background: scene.background },
            annotations: AnnotationsSection::default(),
            render: RenderSection::describe(scene.compositing),
        })
    }

    /// Makes the scene and the view, given the volume that `[volume]` names and the points that `[transfer]` comes to.
    ///
    /// # Errors
    /// A [`ParameterError`] naming the field.
    pub fn assemble(&self, volume: Volume, points: impl Into<TransferPoints>) -> Result<(Scene, View), ParameterError> {
        let default = TransferSection::default();
        let t = self.transfer.as_ref().unwrap_or(&default);
        let unit_distance = t.unit_distance.unwrap_or_else(|| volume.mean_spacing());
        let transfer = points.into().function(t.opacity_rule, unit_distance)?;
        let section = self.camera.unwrap_or_default();
        let (azimuth, elevation) = section.angles(default_angles(None));
        let camera = section.camera(|fov| Camera::framing(volume.bounds(), azimuth, elevation, fov))?;
        let view =
            View { supersampling: self.image.samples, clip: self.clip.clone(), ..View::new(camera, self.image.size) };
        view.validate()?;
        let mut scene = Scene {
            compositing: self.render.compositing()?,
            background: self.image.background,
            ..Scene::new(volume.with_filter(self.volume.filter.unwrap_or_default()), transfer)
        };
        if let Some(section) = self.shading.as_ref().filter(|section| section.enabled) {
            let shading = section.shading();
            scene.volume = scene.volume.with_gradient(shading.gradient);
            scene.shading = Some(Arc::new(shading));
            scene.lights = section.lights()?;
        }
        if let Some(section) = &self.scattering {
            scene.scattering = Some(Arc::new(section.scattering()?));
            scene.lights = section.lights()?;
        }
        scene.validate()?;
        Ok((scene, view))
    }
}
