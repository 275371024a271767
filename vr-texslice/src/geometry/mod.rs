//! Proxy geometry: the polygons in which slices cut a volume, the faces of slabs between them, and their pixels, triangle by triangle.
//!
//! All of it is set-up, and needs no texture: what a host program does before fragments are drawn, by this crate or by a graphics card; and what the card's
//! rasteriser does.

mod body;
mod polygon;
mod raster;
#[cfg(test)]
mod tests;

pub use body::{Body, box_corners, half_spaces};
pub use polygon::{HalfSpace, Polygon, crossing};
pub use raster::{SUBPIXELS, Span, polygon_spans, snapped, triangle_spans};
