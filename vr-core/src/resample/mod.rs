//! Resampling: any volume as a uniform grid, with an account of what that costs.
//!
//! Renderers of uniform grids draw a mesh, scattered points or a function once it is resampled ([`resample`]). Voxels lie on a lattice over the
//! volume's box, from its first to its last corner; what the volume does not cover is vacuum (NaN). The filter decides on the value of a voxel:
//!
//! * [`ResampleFilter::Point`] takes the volume's value at the voxel: exact there, but detail finer than the lattice is missed or aliased, and
//!   half a voxel of a curved boundary is lost in the mean, because a cell of the grid with a missing corner is vacuum;
//! * [`ResampleFilter::Box`] takes the mean over the voxel's box, by 27 samples, as far as the volume covers it: fine detail is smoothed, and a
//!   boundary lies, in the mean, where it was.
//!
//! Linear functions pass both unchanged where the volume covers the boxes. The account compares the integral of the field, ∫ f dV, before and
//! after: exact for grids, meshes of cells and points; an estimate for other fields. [`Resampling::conserve`] puts it right by one factor or one shift.

mod cell_raster;
mod error;
mod integral;
mod lattice;
mod notes;
mod options;
mod run;
mod source;

pub use error::ResampleError;
pub use integral::Integral;
pub use options::{ResampleFilter, Resampling, Resolution};
pub use run::{Correction, Resampled, resample};
