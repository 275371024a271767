//! Subjects that renderers are measured on: a scene and a view of it.

use std::sync::Arc;

use vr_core::phantom::{self, Phantom};
use vr_core::scattering::{Albedo, PhaseFunction, Scattering};
use vr_core::{Camera, GridError, Light, Scene, View};

use crate::origin::Origin;

/// Scene, a view of it, and the name that results go by.
#[derive(Clone)]
pub struct Subject {
    /// Name, unique within a study.
    pub name: String,
    /// Description in a few words: `64×64×64 f32, oblique`.
    pub title: String,
    /// The scene.
    pub scene: Scene,
    /// View of the scene, from which frames turn.
    pub view: View,
    /// The field as a function, where it is known as one.
    pub phantom: Option<Arc<dyn Phantom>>,
    /// Flags and record by which `vr` draws it again.
    pub origin: Origin,
}

impl Subject {
    /// Returns the subject under another view.
    pub fn seen(&self, word: &str, view: View) -> Self {
        let origin = self.origin.seen(&view.camera);
        Self { name: format!("{} {word}", self.name), view, origin, ..self.clone() }
    }
}

/// Returns the subject in about so many pixels, if its view has more.
pub fn reduced(view: &View, pixels: f64) -> View {
    let [w, h] = view.size.map(f64::from);
    let factor = (pixels / (w * h)).sqrt().min(1.0);
    let size = [w, h].map(|side| ((side * factor).round() as u32).max(1));
    View { size, ..view.clone() }
}

/// Degrees to the right of a phantom and above it from which it is seen.
const ANGLES: [f64; 2] = [30.0, 20.0];

/// Returns a phantom on a grid of `samples`³ voxels under its own transfer function, in pictures of the given size, seen from an oblique direction, all of it.
///
/// # Errors
/// Fewer than two voxels along a side.
///
/// # Panics
/// Panics if there is no phantom of this name: a bug in the caller.
pub fn phantom_subject(name: &str, samples: usize, size: [u32; 2]) -> Result<Subject, GridError> {
    let phantom = phantom::by_name(name).expect("the name of a phantom");
    let scene = phantom::sampled_scene::<f32>(&*phantom, samples, 1.0)?;
    let [azimuth, elevation] = ANGLES;
    let view = View::new(Camera::framing(scene.volume.bounds(), azimuth, elevation, None), size);
    Ok(Subject {
        name: name.to_owned(),
        title: format!("phantom {name}, {samples}³ f32"),
        origin: Origin::phantom(name, samples, ANGLES, (&scene, &view)),
        view,
        scene,
        phantom: Some(phantom.into()),
    })
}

/// Returns every phantom, as [`phantom_subject`] makes it.
///
/// # Errors
/// Fewer than two voxels along a side.
pub fn phantom_subjects(samples: usize, size: [u32; 2]) -> Result<Vec<Subject>, GridError> {
    phantom::NAMES.iter().map(|name| phantom_subject(name, samples, size)).collect()
}

/// Returns the phantom fog, as [`phantom_subject`] makes it, in which light is scattered: nine tenths of what it stops, mostly forwards, of a headlight.
///
/// # Errors
/// Fewer than two voxels along a side.
pub fn lit_fog(samples: usize, size: [u32; 2]) -> Result<Subject, GridError> {
    let mut subject = phantom_subject("fog", samples, size)?;
    let phase = PhaseFunction::henyey_greenstein(0.5).expect("a mean cosine below 1");
    let scattering = Scattering { albedo: Albedo::Constant([0.9; 3]), phase, ..Scattering::default() };
    subject.scene.scattering = Some(Arc::new(scattering));
    subject.scene.lights = vec![Light { direction: None, color: [2.0; 3] }];
    let mut origin = Origin::phantom("fog", samples, ANGLES, (&subject.scene, &subject.view));
    origin.scene.extend(["--albedo", "0.9", "--anisotropy", "0.5"].map(str::to_owned));
    let title = format!("{}, scattering", subject.title);
    // As a function it is drawn without scattering.
    Ok(Subject { name: "lit fog".to_owned(), title, phantom: None, origin, ..subject })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_phantom_makes_a_subject() {
        let subjects = phantom_subjects(3, [7, 5]).unwrap();
        assert_eq!(subjects.len(), phantom::NAMES.len());
        for Subject { name, scene, view, .. } in subjects {
            assert!(scene.validate().is_ok() && view.validate().is_ok() && view.camera.frame().is_ok(), "{name}");
        }
        assert!(phantom_subjects(1, [2, 2]).is_err());
        let lit = lit_fog(3, [7, 5]).unwrap();
        let record = lit.origin.record.unwrap();
        assert!(lit.scene.validate().is_ok() && record.scene.scattering.is_some(), "{}", lit.title);
    }
}
