//! The errors of a study.

use std::io;

use vr_core::{GridError, OptionError, RenderError};
use vr_io::WriteError;

/// Reason for which a study ended without a result.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A scene, a view or a renderer failed, or the caller cancelled.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A setting that the renderer itself does not take.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// A grid that cannot be.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// A result that could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The journal.
    #[error("journal: {0}")]
    Io(#[from] io::Error),
    /// A plot.
    #[error("plot: {0}")]
    Plot(String),
}
