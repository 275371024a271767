//! Files of a scene and its picture, to be saved.

use std::fs;
use std::path::Path;

use vr_core::{Control, RenderError, Renderer, Scene, View};
use vr_io::{PngOptions, SceneFile, SceneFileError, TransferSource, WriteError};

use super::document::MAX_PIXELS;
use super::error::EditError;

/// A file to be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Export {
    /// The scene as TOML, from which `vr render --scene` draws the picture at rest, and which `vr view --scene` opens.
    Scene,
    /// The picture at rest as PNG.
    Png {
        /// Width and height; those of the picture on the screen if absent.
        size: Option<[u32; 2]>,
    },
    /// The picture at rest as OpenEXR.
    Exr {
        /// Width and height; those of the picture on the screen if absent.
        size: Option<[u32; 2]>,
    },
    /// The transfer function as a colour map of ParaView.
    Transfer,
}

/// Reason why there is no file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The scene cannot be written.
    #[error(transparent)]
    Scene(#[from] SceneFileError),
    /// The picture cannot be drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The format does not hold it.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The renderer takes no such option.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// No folder to write in.
    #[error("temporary file: {0}")]
    Folder(#[from] std::io::Error),
}

impl Export {
    /// Name of the file.
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Scene => "scene.toml",
            Self::Png { .. } => "picture.png",
            Self::Exr { .. } => "picture.exr",
            Self::Transfer => "transfer.json",
        }
    }

    /// Media type of the file.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Scene => "application/toml",
            Self::Png { .. } => "image/png",
            Self::Exr { .. } => "image/x-exr",
            Self::Transfer => "application/json",
        }
    }

    /// Makes the file's bytes.
    pub(super) fn make(
        self,
        file: &SceneFile,
        title: &str,
        (scene, view): (&Scene, &View),
        renderer: &dyn Renderer,
    ) -> Result<Vec<u8>, ExportError> {
        let frame = |size: Option<[u32; 2]>| {
            let size = size.unwrap_or(view.size);
            if u64::from(size[0]) * u64::from(size[1]) > u64::from(MAX_PIXELS) {
                return Err(ExportError::Edit(EditError::Size(size)));
            }
            let (view, control) = (View { size, ..view.clone() }, Control::default());
            view.validate().map_err(RenderError::from)?;
            Ok(renderer.prepare(scene, &control)?.render(&view, &control)?.frame)
        };
        match self {
            Self::Scene => Ok(vr_io::scene_text(file)?.into_bytes()),
            Self::Png { size } => {
                let options = PngOptions { background: scene.background, ..PngOptions::default() };
                Ok(vr_io::encode_png(&frame(size)?, &options))
            }
            Self::Exr { size } => {
                let frame = frame(size)?;
                written(self, |path| vr_io::write_exr(path, &frame))
            }
            Self::Transfer => {
                let (transfer, shading) = (&scene.transfer, scene.shading.as_deref());
                let source = TransferSource { name: title, transfer, shading, gradient_per_voxel: &[] };
                written(self, |path| vr_io::write_transfer(path, &source).map(|_| ()))
            }
        }
    }
}

/// Bytes of a file that is written into a folder of its own, and gone afterwards.
fn written(export: Export, write: impl FnOnce(&Path) -> Result<(), WriteError>) -> Result<Vec<u8>, ExportError> {
    // A browser gives a module no disk.
    if cfg!(target_family = "wasm") {
        return Err(ExportError::Folder(std::io::ErrorKind::Unsupported.into()));
    }
    let folder = tempfile::tempdir()?;
    let path = folder.path().join(export.file_name());
    write(&path)?;
    Ok(fs::read(path)?)
}
