//! Block-structured adaptive meshes: lattices of several levels, each finer than the one before, where it has blocks.
//!
//! An [`AmrGrid`] holds blocks of values ([`AmrBlock`]). All blocks of a level lie on one lattice; a cell of a level is divided into whole cells of the
//! next one. The finest cell that covers a place is its *leaf*, and the field there is made of the values around it.
//!
//! # The field
//! A coarse cell that finer ones cover has their mean as its value, so that every level is known wherever it has blocks. (Values of points are copied
//! from the finer level where both have the point.) That mean is exact for linear data. Each leaf is divided into its *elements*: the eight octants of a cell with
//! a value in its middle, or the whole cell between points. In an element the field is trilinear between the element's corners:
//!
//! * a corner that only leaves of this level and finer ones touch has the mean of the 2, 4 or 8 cells of this level around it (or the value of the
//!   point). In a region of one level this is trilinear interpolation between the middles of the cells, as a uniform grid has it;
//! * a corner that a coarser leaf touches has the value that the coarsest of them has there.
//!
//! So both sides of a face between two levels agree on it: the field is continuous. Every step is exact for linear data, weights are never negative, and
//! they sum to 1: the field keeps within the values around.
//!
//! Vacuum is where a corner lacks one of the cells around it: in the outermost half cell of the whole mesh, as a uniform grid
//! ends at its first and last sample, and around cells without a value.
//!
//! Gradients are central differences at the values, on the level's own lattice (beyond its edge: of the field), and between them the same interpolation.

mod bin_index;
mod block;
mod bricks;
mod check;
mod element;
mod error;
mod field;
mod grid;
mod inner_gradient;
mod inner_value;
mod lattice;
mod level;
mod line;
mod marked;
mod neighbors;
mod nodes;
mod refining;
mod region;
mod restriction;
mod rim;
mod rim_samples;
mod samples;
mod solid_elements;
mod stretches;
mod traversal;

pub use block::{AmrBlock, AmrCentring};
pub use error::AmrError;
pub use grid::AmrGrid;
pub use lattice::AmrLattice;
pub use refining::AmrSampling;
pub use samples::{AmrSamples, AmrStencil};
pub use traversal::{AmrPart, AmrTraversal};
