//! Subject: what is looked at, as it was opened.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use vr_core::{Scene, StudiedRenderer, TriangleMesh};
use vr_io::{FileError, LoadedVolume, SceneFile};

use super::label_look::{LabelFiles, ReadLabels};

/// A volume and the scene around it, read and complete.
pub struct Subject {
    /// The scene file, of which nothing is left open, the renderer included; its paths are absolute.
    pub file: SceneFile,
    /// The volume that it names.
    pub volume: LoadedVolume,
    /// The opaque surface that it names, and its colour.
    pub mesh: Option<(Arc<TriangleMesh>, Option<[f64; 3]>)>,
    /// The volume in a few words.
    pub title: String,
    /// Notes on everything assumed, one line each.
    pub notes: Vec<String>,
    /// The labels beside the volume, if there are any; read when a slice shows them.
    pub labels: Labels,
}

/// Labels of a subject, read once and when they are first asked for.
#[derive(Default)]
pub struct Labels {
    files: Option<LabelFiles>,
    read: OnceLock<ReadLabels>,
}

impl From<LabelFiles> for Labels {
    fn from(files: LabelFiles) -> Self {
        Self { files: Some(files), read: OnceLock::new() }
    }
}

impl Subject {
    /// Path that messages call the scene file by. Paths in it are absolute, so that no folder is needed.
    pub(super) fn path(&self) -> PathBuf {
        PathBuf::from("the scene")
    }

    /// True if the world is a patient's: x to the right side, y to the front, z to the head.
    pub(super) fn is_patient(&self) -> bool {
        self.volume.info.as_ref().is_some_and(|info| info.space.is_patient())
    }

    /// The labels; `None` where there are none.
    ///
    /// # Errors
    /// Files that can no longer be read.
    pub(super) fn read_labels(&self) -> Result<Option<&ReadLabels>, FileError> {
        let Some(files) = &self.labels.files else { return Ok(None) };
        if let Some(read) = self.labels.read.get() {
            return Ok(Some(read));
        }
        let read = ReadLabels::read(files)?;
        Ok(Some(self.labels.read.get_or_init(|| read)))
    }
}

/// Renderers of a session, known through their traits alone.
pub struct RendererList {
    /// All of them.
    pub all: Vec<Box<dyn StudiedRenderer>>,
    /// Name of the one that draws a scene where no other is named.
    pub usual: fn(&Scene) -> &'static str,
}

impl RendererList {
    /// The renderer of a name.
    pub(super) fn named(&self, name: &str) -> Option<&dyn StudiedRenderer> {
        self.all.iter().find(|renderer| renderer.name() == name).map(|renderer| &**renderer)
    }
}
