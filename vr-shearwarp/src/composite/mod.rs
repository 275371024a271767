//! Slices composited onto the intermediate image, scan line by scan line.
//!
//! Rows of texels go together in bands, small enough for the cache; a band takes all slices, front to back. In each row the runs of cells
//! that may be visible are met with the runs of texels that are not opaque yet ([`crate::links`]), and where both are, sixteen
//! texels at a time are sampled and composited by a [`kernel::Kernel`]. All weights across rows are the same for a slice, and so are those along
//! them where a texel is as wide as a voxel.

mod band;
pub(crate) mod by_gradient;
pub(crate) mod cells;
pub(crate) mod first;
pub(crate) mod gradients;
mod half;
pub(crate) mod kernel;
pub(crate) mod mean_color;
pub(crate) mod over;
pub(crate) mod pick;
pub(crate) mod ray_lights;
mod short_run;

pub(crate) use band::{Band, Line, Scratch, Work};
