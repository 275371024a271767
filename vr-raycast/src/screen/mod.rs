//! Choice of the rays that a picture is made of. One small file each.

mod adaptive;
mod blocks;
mod every_pixel;

#[cfg(feature = "classics")]
pub(crate) use every_pixel::{by_tiles, spots_of_pixel};

use vr_core::{Control, Layer, RenderError, Rendered, View};

use crate::caster::ImageSampling;
use crate::tracer::Tracer;
use adaptive::adaptive;
use every_pixel::every_pixel;

/// Draws a view by the rays that an image sampling chooses, whatever traces them.
pub(crate) fn draw(
    screen: ImageSampling,
    tracer: &dyn Tracer,
    (view, layer): (&View, Option<&Layer>),
    control: &Control,
) -> Result<Rendered, RenderError> {
    match screen {
        ImageSampling::Adaptive { threshold } => adaptive(tracer, (view, layer), threshold, control),
        _ => every_pixel(tracer, view, control),
    }
}
