//! Proxy geometry: the polygons in which slices cut a volume, the footprints of slabs, and their pixels.
//!
//! All of it is set-up, in f64, and needs no texture: what a host program does before fragments are drawn, by this crate or by a graphics card.

mod body;
mod polygon;
mod raster;
#[cfg(test)]
mod tests;

pub use body::{Body, box_corners, hull, slice_of_box};
pub use polygon::{HalfSpace, Polygon, crossing};
pub use raster::{Span, spans};
