//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

mod adaptive;
mod beyond_f32;
mod cancelled;
mod cells;
mod colors;
mod hdf5_grids;
mod labels;
mod large_files;
mod meshes;
mod netcdf;
mod pictures;
mod points;
mod rectilinear;
mod scene_files;
mod shared;
mod shared_data;
mod small_amr;
mod small_images;
mod small_meshes;
mod small_points;
mod tiny;
mod transfer_rows;
mod volumes;
mod vtk_images;
mod written;
