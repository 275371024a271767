//! Subjects of the session: a phantom, or the files that were chosen.

use std::path::Path;

use vr_io::{FileSource, MemoryFolder, SceneFile, SceneFileError, VolumeSource};
use vr_study::stated::StatedRenderer;
use vr_view::session::{EditError, Labels, PROVEN, Subject};
use vr_view::upload::without_folder;

use crate::renderers::renderers;

/// Reason why there is no scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BeginError {
    /// A file that cannot be read, or a scene that cannot be made.
    #[error(transparent)]
    Scene(#[from] SceneFileError),
    /// A scene that none of the renderers draws.
    #[error(transparent)]
    Edit(#[from] EditError),
}

/// The phantom that the page begins with.
pub fn phantom(name: &str, size: usize) -> Result<Subject, BeginError> {
    let mut file = SceneFile::default();
    file.volume.source = Some(VolumeSource::Phantom { name: name.to_owned(), size: Some(size) });
    Ok(complete(file, format!("{name}, a phantom of {size}³ voxels"))?)
}

/// A file of a folder in memory, or all of them as a series where no name is given.
pub fn opened(folder: &MemoryFolder, name: &str) -> Result<Subject, String> {
    let path = if name.is_empty() { folder.path().to_owned() } else { folder.path().join(name) };
    let mut file = SceneFile::default();
    file.volume.source = Some(VolumeSource::File(FileSource { path: path.into(), ..FileSource::default() }));
    let in_words = |e: &dyn std::fmt::Display| without_folder(folder.path(), &e.to_string());
    let mut subject = complete(file, name.to_owned()).map_err(|e| in_words(&e))?;
    subject.notes.iter_mut().for_each(|note| *note = in_words(note));
    // The scene file that is saved names the file as the user knows it: beside it, it is drawn again.
    if let Some(VolumeSource::File(source)) = &mut subject.file.volume.source {
        source.path = if name.is_empty() { ".".into() } else { name.into() };
    }
    let dims = subject.volume.volume.value_grid().map(|grid| grid.dims());
    let name = if name.is_empty() { "series" } else { name };
    subject.title = match dims {
        Some([x, y, z]) => format!("{name}, {x} × {y} × {z}"),
        None => name.to_owned(),
    };
    Ok(subject)
}

/// The scene around a volume, with nothing left open; its picture at rest is proven by renderers that can.
fn complete(file: SceneFile, title: String) -> Result<Subject, SceneFileError> {
    let volume = vr_io::load_volume(&file.volume, Path::new(""))?;
    let loaded = vr_io::resolve_scene_around(&file, Path::new(""), volume.clone())?;
    let list = renderers();
    let usual = (list.usual)(&loaded.scene);
    let renderer = list.all.iter().find(|renderer| renderer.name() == usual).expect("the usual one is among them");
    let stated = StatedRenderer::of(&**renderer, Some(PROVEN));
    let completed = file.completed(&loaded.unlabelled, None, &loaded.view, loaded.info.as_ref());
    let file = completed.drawn_by(&stated.name, stated.options, stated.max_error);
    Ok(Subject { file, volume, mesh: None, title, notes: loaded.notes, labels: Labels::default() })
}
