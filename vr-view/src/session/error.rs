//! Errors of edits, and of questions.

use vr_core::{OptionError, ParameterError, RenderError};
use vr_io::{FileError, SceneFileError};

/// Reason why an edit was refused; the scene stays as it was.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EditError {
    /// A number that makes no sense.
    #[error(transparent)]
    Parameter(#[from] ParameterError),
    /// A scene that cannot be made.
    #[error(transparent)]
    Scene(#[from] SceneFileError),
    /// An option that the renderer does not take.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// A scene that the renderer does not draw.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// No renderer of this name.
    #[error("renderer: found {0:?}; no renderer here has this name")]
    UnknownRenderer(String),
    /// A renderer that bounds no error, or none of this scene.
    #[error("quality: found proven; {0} cannot prove the error of this scene")]
    NoProof(String),
    /// A renderer without settings by error.
    #[error("quality: found {quality}; {renderer} has no setting of this name")]
    NoQuality {
        /// The quality.
        quality: &'static str,
        /// The renderer.
        renderer: String,
    },
    /// A transfer function that points by value cannot describe.
    #[error("the transfer function has rows by gradient: it is edited in a scene file")]
    Rows,
    /// No change to take back or to make again.
    #[error("nothing to {0}")]
    NoHistory(&'static str),
    /// A picture of more pixels than a screen has.
    #[error("size: found {}x{}; must be 1 to 8192 pixels on a side, {} together at most", .0[0], .0[1], super::MAX_PIXELS)]
    Size([u32; 2]),
}

/// Reason why a question about the picture at rest has no answer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TruthError {
    /// The renderer does not take its options.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// The picture has no such pixel or cannot be drawn, the scene has no reference, or an edit has made the question stale.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Labels that can no longer be read.
    #[error(transparent)]
    Labels(Box<FileError>),
}

impl From<FileError> for TruthError {
    fn from(error: FileError) -> Self {
        Self::Labels(Box::new(error))
    }
}
