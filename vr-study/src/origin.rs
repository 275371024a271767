//! Origin of a subject: the flags and the record by which the program `vr` draws it again.

use vr_core::{Camera, OptionValue, Projection, Scene, View};
use vr_io::{CameraSection, ErrorRecord, PictureRecord, SceneFile, VolumeRecord, VolumeSource, volume_hash};

use crate::candidate::Candidate;
use crate::figures::ErrorFigures;
use crate::stated::StatedRenderer;

/// Flags and record by which `vr` draws a subject again. The default knows none.
#[derive(Clone, Debug, Default)]
pub struct Origin {
    /// Flags of `vr render` that name volume and picture; none where no flags do.
    pub scene: Vec<String>,
    /// Flags that name the camera, where those of `scene` leave it open.
    pub camera: Vec<String>,
    /// Record of a picture that no renderer has drawn yet.
    pub record: Option<PictureRecord>,
    /// Sentence on the commands, where there is something to know.
    pub note: Option<String>,
}

impl Origin {
    /// Origin of a phantom on a grid of `samples`³ voxels, seen from so many degrees to the right and above, all of it.
    pub fn phantom(name: &str, samples: usize, [azimuth, elevation]: [f64; 2], (scene, view): (&Scene, &View)) -> Self {
        let [w, h] = view.size;
        let size = format!("{w}x{h}");
        let flags = ["--phantom", name, "--phantom-size", &samples.to_string(), "--size", &size].map(str::to_owned);
        let angles = [azimuth, elevation].map(|angle| angle.to_string());
        let camera = ["--fit", "box", "--azimuth", &angles[0], "--elevation", &angles[1]].map(str::to_owned);
        let mut file = SceneFile::default();
        file.volume.source = Some(VolumeSource::Phantom { name: name.to_owned(), size: Some(samples) });
        let volume = VolumeRecord {
            title: format!("phantom {name}, {samples}×{samples}×{samples} f32"),
            hash: volume_hash(&scene.volume),
        };
        let record = PictureRecord::new(env!("CARGO_PKG_VERSION"), file.completed(scene, None, view, None), volume);
        Self { scene: flags.to_vec(), camera: camera.to_vec(), record: Some(record), note: None }
    }

    /// The origin of the same subject under another camera.
    #[must_use]
    pub fn seen(&self, camera: &Camera) -> Self {
        let point = |p: glam::DVec3| format!("{},{},{}", p.x, p.y, p.z);
        let Camera { eye, target, up, projection } = *camera;
        let (flag, extent) = match projection {
            Projection::Orthographic { height } => ("--height", height),
            Projection::Perspective { fov } => ("--fov", fov),
        };
        let flags =
            [("--eye", point(eye)), ("--target", point(target)), ("--up", point(up)), (flag, extent.to_string())];
        let mut record = self.record.clone();
        if let Some(record) = &mut record {
            record.scene.camera = Some(CameraSection::from(camera));
        }
        let camera = flags.into_iter().flat_map(|(flag, value)| [flag.to_owned(), value]).collect();
        Self { camera, record, ..self.clone() }
    }

    /// Returns the command that draws a subject of this name with a candidate, or a map of its error; `None` where no flags name the scene.
    pub(crate) fn command(&self, name: &str, candidate: &Candidate, is_map: bool) -> Option<String> {
        if self.scene.is_empty() {
            return None;
        }
        let file = file_name(&format!("{name} {}", candidate.name()));
        let mut words: Vec<String> = ["vr", "render"].map(str::to_owned).to_vec();
        words.extend(self.scene.iter().chain(&self.camera).cloned());
        words.extend(setting_flags(candidate));
        if is_map {
            words.extend(["--error", "full", "--error-map"].map(str::to_owned));
            words.push(format!("{file}-error.png"));
        }
        words.extend(["-o".to_owned(), format!("{file}.png")]);
        Some(shell_line(&words))
    }

    /// Returns the record of the picture of a candidate, with the error that was measured.
    pub(crate) fn record_of(
        &self,
        candidate: &Candidate,
        error: &ErrorFigures,
        size: [u32; 2],
    ) -> Option<PictureRecord> {
        let mut record = self.record.clone()?;
        let StatedRenderer { name, options, max_error } = StatedRenderer::of(&*candidate.configured, None);
        record.scene = record.scene.drawn_by(&name, options, max_error);
        let [width, height] = size.map(u64::from);
        record.record.error = Some(ErrorRecord {
            rmse: error.rmse,
            max: error.max,
            pixels: error.pixels as u64,
            of: width * height,
            method: format!(
                "against the reference, which is right to {:.1e} ({})",
                error.reference_error, error.reference_error_is
            ),
        });
        Some(record)
    }
}

/// Returns the flags of `vr` that choose a candidate: its renderer, and the options that are not at their defaults.
pub fn setting_flags(candidate: &Candidate) -> Vec<String> {
    let specs = candidate.configured.option_specs();
    let is_default =
        |key: &str, value: &OptionValue| specs.iter().any(|spec| spec.key == key && spec.default == *value);
    let set = candidate.options.0.iter().filter(|(key, value)| !is_default(key, value));
    let set = set.flat_map(|(key, value)| ["--set".to_owned(), format!("{key}={value}")]);
    ["--renderer".to_owned(), candidate.renderer.clone()].into_iter().chain(set).collect()
}

/// Returns words as a file name without blanks and signs.
fn file_name(words: &str) -> String {
    words.chars().map(|c| if c.is_alphanumeric() || c == '.' || c == '_' { c } else { '-' }).collect()
}

/// Returns words as a line of a shell: those with blanks or signs that mean something to it stand in quotes.
pub fn shell_line(words: &[String]) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    let quoted = |word: &String| {
        if !word.is_empty() && word.chars().all(is_plain) {
            word.clone()
        } else {
            format!("'{}'", word.replace('\'', "'\\''"))
        }
    };
    words.iter().map(quoted).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_with_blanks_are_quoted() {
        let words = ["vr", "--title", "two words", "it's", "", "--point", "1,0.5,-1", "a/b_c.nrrd"].map(str::to_owned);
        assert_eq!(shell_line(&words), "vr --title 'two words' 'it'\\''s' '' --point 1,0.5,-1 a/b_c.nrrd");
    }
}
