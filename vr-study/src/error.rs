//! Errors of a study.

use std::io;

use vr_core::cancel::Stopped;
use vr_core::{GridError, OptionError, RenderError};
use vr_io::WriteError;

/// Reason for which a study ended without a result.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// Failure of a scene, a view or a renderer, or cancellation by the caller.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Setting that the renderer itself refuses.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// Invalid grid.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// Result that could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Failure of the journal.
    #[error("journal: {0}")]
    Io(#[from] io::Error),
    /// Failure of a plot.
    #[error("plot: {0}")]
    Plot(String),
}

impl From<Stopped> for StudyError {
    fn from(stopped: Stopped) -> Self {
        RenderError::from(stopped).into()
    }
}
