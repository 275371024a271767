//! Subject: what is looked at, as it was opened.

use std::path::PathBuf;
use std::sync::Arc;

use vr_core::{Scene, StudiedRenderer, TriangleMesh};
use vr_io::{LoadedVolume, SceneFile};

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
}

impl Subject {
    /// Path that messages call the scene file by. Paths in it are absolute, so that no folder is needed.
    pub(super) fn path(&self) -> PathBuf {
        PathBuf::from("the scene")
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
