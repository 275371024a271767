//! News from a session.

use std::sync::Arc;

use super::describe::State;
use super::picture::{Picture, PictureError};

/// News from a session, for one client or for all.
#[derive(Clone)]
pub enum Output {
    /// A new picture.
    Picture(Arc<Picture>),
    /// The error of a picture that was given before.
    Error {
        /// Number of the picture.
        picture: u64,
        /// Its error, as it is known now.
        error: PictureError,
    },
    /// The scene after a change.
    State(Arc<State>),
    /// Another volume is shown: [`Session::opened`](super::Session::opened) describes it.
    Volume,
    /// The reason why there is no picture.
    Problem(String),
}
