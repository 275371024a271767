//! Which rays a picture is made of. One small file each.

mod adaptive;
mod blocks;
mod coherent;
mod every_pixel;
mod template;

pub(crate) use coherent::{CoherenceBuffer, Sides, Sight};
pub(crate) use template::Template;

use vr_core::{Control, GridVolume, Layer, RenderError, Rendered, View};

use crate::caster::Screen;
use crate::tracer::Tracer;
use adaptive::adaptive;
use coherent::coherent;
use every_pixel::every_pixel;

/// What decides which rays of a view are traced, whatever traces them.
pub(crate) struct Stage<'a> {
    pub(crate) screen: Screen,
    /// For the coherent screen.
    pub(crate) coherence: Option<&'a mut CoherenceBuffer>,
    pub(crate) volume: &'a GridVolume,
    /// World length of the steps of the tracer's lattice.
    pub(crate) step: f64,
    pub(crate) view: &'a View,
    /// The surfaces in it.
    pub(crate) layer: Option<&'a Layer>,
    pub(crate) control: &'a Control,
}

impl Stage<'_> {
    /// Draws the view.
    pub(crate) fn draw(self, tracer: &impl Tracer) -> Result<Rendered, RenderError> {
        let Self { screen, coherence, volume, step, view, layer, control } = self;
        match (screen, coherence) {
            (Screen::Coherent, Some(buffer)) => coherent(tracer, buffer, volume, step, (view, layer), control),
            (Screen::Adaptive { threshold }, _) => adaptive(tracer, (view, layer), threshold, control),
            _ => every_pixel(tracer, view, control),
        }
    }
}
