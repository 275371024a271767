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
pub(crate) use every_pixel::some_pixels;

/// Adaptive rays of a picture.
#[derive(Clone, Copy)]
pub(crate) struct AdaptiveRays<'a> {
    /// Bend of the picture above which rays are added.
    pub(crate) threshold: f64,
    /// Parts of the volume that may be thinner than the distance of the first rays, where they are known.
    pub(crate) thin_parts: Option<&'a ThinParts>,
    /// True if it is known that most rays can be left out, however many cells of the first grid are refined.
    pub(crate) are_few: bool,
}

/// Draws a view by adaptive rays; without, by those of every pixel, whatever traces them.
pub(crate) fn draw(
    adaptive_rays: Option<AdaptiveRays<'_>>,
    tracer: &dyn Tracer,
    (view, layer): (&View, Option<&Layer>),
    control: &Control,
) -> Result<Rendered, RenderError> {
    match adaptive_rays {
        Some(rays) => adaptive(tracer, (view, layer), rays, control),
        None => every_pixel(tracer, view, control),
    }
}
