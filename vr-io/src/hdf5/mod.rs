//! HDF5 through `hdf5-reader`: grids of voxels, among them those of NetCDF-4, and the file itself for [`crate::points`].

mod file;
mod grid;

pub(crate) use file::{damaged, open, scalar_of};
pub(crate) use grid::describe;
