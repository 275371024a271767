//! Random parts of scenes, and whole scenes, for [`proptest`]. They shrink towards small, empty, plain scenes.
//!
//! Three kinds of whole scenes:
//!
//! - [`scene`]: everything that is valid, the unkind included: missing voxels, jumps, opaque plateaus, rays in cell faces.
//!   The rounding of a renderer may decide on which side of a jump or of a face a sample falls, so that two correct pictures
//!   of such a scene can differ by much; what must hold bit for bit is tested here.
//! - [`tame_scene`]: pictures that depend continuously on every number: no missing voxels, no jumps, no opacity near 1, no
//!   rays that lie in faces. Here errors have bounds.
//! - [`smooth_scene`]: also free of kinks, as far as a filter allows: here errors have orders.
//!
//! [`Kind`] names what can be hard about a scene, and [`scene_of`] draws any of it: what [`errors_fall`](super::errors_fall) and
//! the long runs of `vr-benches` look at.
//!
//! The three are uniform grids. The first two are there of other volumes, too:
//!
//! | volume | any | tame |
//! |---|---|---|
//! | scattered points | [`point_scene`] | [`tame_point_scene`] |
//! | meshes of cells | [`mesh_scene`] | [`tame_mesh_scene`] |
//! | adaptive meshes | [`adaptive_scene`] | [`tame_adaptive_scene`] |
//! | rectilinear grids | [`rectilinear_scene`] | [`tame_rectilinear_scene`] |
//!
//! [`gradient_row_scene`]: any grid, the transfer function of which has rows by the gradient. [`colored_grid_scene`]: grids whose voxels have colours. [`shaded_point_scene`]: tame, and shaded. [`tame_mixed_point_scene`]: tame, of weighted means or with colours.

mod adaptive;
mod assembly;
mod cameras;
mod colored;
#[cfg(test)]
pub(super) mod drawn;
mod grids;
mod hashed;
mod kinds;
mod looks;
mod meshes;
mod points;
mod rectilinear;
mod rows;
mod scenes;
mod transfers;

pub use adaptive::{adaptive_mesh, adaptive_scene, tame_adaptive_mesh, tame_adaptive_scene};
pub use cameras::{camera, clip, generic_camera};
pub use colored::colored_grid_scene;
pub use grids::{grid, smooth_grid, tame_grid};
pub use kinds::{Kind, scene_of};
pub use looks::{compositing, filter, shading, tame_compositing};
pub use meshes::{cell_mesh, mesh_scene, tame_mesh_scene, uneven_cubes};
pub use points::{
    mixed_point_set, point_scene, point_set, shaded_point_scene, tame_mixed_point_scene, tame_point_scene,
};
pub use rectilinear::{rectilinear_grid, rectilinear_scene, tame_rectilinear_grid, tame_rectilinear_scene};
pub use rows::gradient_row_scene;
pub use scenes::{scene, smooth_scene, tame_scene};
pub use transfers::{smooth_transfer, tame_transfer, transfer};
