//! Second picture: the scene and view at rest, drawn by another setting, to be laid beside the first.

use serde::{Deserialize, Serialize};
use vr_core::clock::Instant;
use vr_core::{Control, RenderError, Renderer, Scene, View};

use super::edit::Quality;
use super::picture::{PictureError, compared};

/// Setting that draws a second picture.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setting {
    /// Name of the renderer. That of the first picture keeps its options, any other has its usual ones.
    pub renderer: String,
    /// Quality; `None` for what the renderer does without one: its bound, if it has one for this scene.
    #[serde(default)]
    pub quality: Option<Quality>,
}

/// Picture of a second setting, with its time and its error.
#[derive(Clone, Debug, Serialize)]
pub struct SecondPicture {
    /// Name of the renderer.
    pub renderer: &'static str,
    /// Width and height in pixels: those of the picture at rest.
    pub size: [u32; 2],
    /// Milliseconds from the call of `render` to its frame.
    pub milliseconds: f64,
    /// Milliseconds of what had to be prepared before.
    pub prepare_milliseconds: f64,
    /// Error of the picture.
    pub error: PictureError,
    /// Red, green, blue and 255 of each pixel, row by row from the top: those of the PNG that `vr render` writes.
    #[serde(skip)]
    pub rgba: Vec<u8>,
}

impl SecondPicture {
    /// Draws it by a renderer, under its bound if it has one, and measures it.
    pub(super) fn of(
        (scene, view): (&Scene, &View),
        (renderer, bound): (&dyn Renderer, Option<f64>),
        control: &Control,
    ) -> Result<Self, RenderError> {
        let start = Instant::now();
        let mut prepared = renderer.prepare(scene, control)?;
        let prepare = start.elapsed();
        let start = Instant::now();
        let rendered = prepared.render(view, control)?;
        let time = start.elapsed();
        let reference = compared((scene, view), control)?;
        let error = match bound {
            Some(bound) => PictureError::under_bound(bound, &rendered, reference.as_ref()),
            None => {
                reference.map_or(PictureError::Unknown, |reference| PictureError::measured(&reference, &rendered.frame))
            }
        };
        Ok(Self {
            renderer: renderer.name(),
            size: view.size,
            milliseconds: 1e3 * time.as_secs_f64(),
            prepare_milliseconds: 1e3 * prepare.as_secs_f64(),
            error,
            rgba: vr_io::screen_rgba(&rendered.frame, scene.background),
        })
    }
}
