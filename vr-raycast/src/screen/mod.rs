//! Choice of the rays that a picture is made of. One small file each.

mod adaptive;
mod blocks;
mod every_pixel;

#[cfg(feature = "classics")]
pub(crate) use every_pixel::{by_tiles, spots_of_pixel};

use vr_core::{Control, Layer, RenderError, Rendered, View};

use crate::thin_parts::ThinParts;
use crate::tracer::Tracer;
pub(crate) use adaptive::COARSE;
use adaptive::adaptive;
use every_pixel::every_pixel;

/// Draws a view by adaptive rays of a threshold, with what is thinner than their distance; without, by those of every pixel, whatever traces them.
pub(crate) fn draw(
    adaptive_rays: Option<(f64, Option<&ThinParts>)>,
    tracer: &dyn Tracer,
    (view, layer): (&View, Option<&Layer>),
    control: &Control,
) -> Result<Rendered, RenderError> {
    match adaptive_rays {
        Some(rays) => adaptive(tracer, (view, layer), rays, control),
        None => every_pixel(tracer, view, control),
    }
}
