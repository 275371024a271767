//! Which rays a picture is made of. One small file each.

mod adaptive;
mod blocks;
mod coherent;
mod every_pixel;
mod template;

pub(crate) use coherent::{CoherenceBuffer, Sides, Sight};
pub(crate) use template::Template;

use vr_core::{Control, RenderError, Rendered, UniformVolume, View};

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
    pub(crate) volume: &'a UniformVolume,
    /// World length of the steps of the tracer's lattice.
    pub(crate) step: f64,
    pub(crate) view: &'a View,
    pub(crate) control: &'a Control,
}

impl Stage<'_> {
    /// Draws the view.
    pub(crate) fn draw(self, tracer: &dyn Tracer) -> Result<Rendered, RenderError> {
        let Self { screen, coherence, volume, step, view, control } = self;
        match (screen, coherence) {
            (Screen::Coherent, Some(buffer)) => coherent(tracer, buffer, volume, step, view, control),
            (Screen::Adaptive { threshold }, _) => adaptive(tracer, view, threshold, control),
            _ => every_pixel(tracer, view, control),
        }
    }
}
