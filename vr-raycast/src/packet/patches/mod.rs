//! Packets through volumes that are regular lattices patch by patch: adaptive meshes, whose blocks are such, and rectilinear grids, where segments of the axes are.
//!
//! Each ray of a packet walks by itself, in f64, from part to part of its own course ([`steps`]): a part lies in one patch and has a pace, and the steps
//! of the parts of one pace that touch are one lattice, as the plain engine has it. What comes of that are batches of steps of one length in one
//! patch. Sixteen lanes work them off at once ([`march`]), in f32 relative to the patch; a lane whose batch is done takes the next one of its ray while
//! the others wait, which is rare: lanes are full until rays end.
//!
//! In a patch the field is trilinear between the patch's own samples and a layer of those beside it ([`mesh_lattices`]), which are loaded as those of uniform
//! grids are. A sample that the level does not have is NaN there, so that a value that is NaN tells a lane which is at the rim of a
//! level: it gets its value from the samples of both levels ([`mesh_rim`]).
//!
//! In a patch of a rectilinear grid ([`rectilinear`]) cells are of similar widths along each axis. Places are counted in bins no wider than a cell, and a
//! table leads from the bin to the cell ([`axis_table`]); where all cells are of one width, bins are cells, and nothing is looked up. Samples and gradients
//! are gathered from the whole grid, as in a uniform one.
//!
//! Operators that pick a value take the same steps, and the ends of rays ([`pick_march`]).

mod axis_table;
mod engine;
mod lanes;
mod march;
mod merged;
mod mesh;
mod mesh_lanes;
mod mesh_lattices;
mod mesh_paces;
mod mesh_rim;
mod pick_engine;
mod pick_march;
mod rays;
mod rectilinear;
mod rectilinear_paces;
mod steps;
mod volume;

pub(crate) use engine::{PatchEngine, PatchFrame};
pub(crate) use pick_engine::{PatchPickEngine, PatchPickFrame};

#[cfg(test)]
mod tests;
