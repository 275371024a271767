//! Splatting.

mod bins;
mod finish;
mod hard_cases;
mod kernel;
mod model;
mod options;
mod prepared;
mod projection;
mod renderer;
mod section_table;
mod settings;
mod sheets;
mod source;
mod splat;
mod splatting;
mod support;
mod tile;
mod visible;
mod voxel_optics;

pub use kernel::{Shape, SplatKernel};
pub use splatting::{Buffers, Classification, SheetOrder, Splatting};
