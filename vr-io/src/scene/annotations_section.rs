//! `[annotations]`: things that are drawn over a finished picture.

use serde::{Deserialize, Serialize};

/// `[annotations]`. Nothing is drawn over a picture where it is absent, nor over an EXR, which is data.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AnnotationsSection {
    /// Title in the upper left corner.
    pub title: Option<String>,
    /// True for axes that turn with the camera.
    pub marker: bool,
    /// True for a bar of a round length.
    pub scale: bool,
    /// True for the colours and opacities of the values.
    pub legend: bool,
}

impl AnnotationsSection {
    /// True if nothing is to be drawn.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
