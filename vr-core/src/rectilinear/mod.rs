//! Rectilinear grids: values where three families of axis-parallel planes meet, at uneven distances.
//!
//! Each cell is a box, and the field in it is trilinear: in world coordinates as well as in index coordinates, between which a map that is
//! linear in each cell ([`Axis`]) leads. So a rectilinear grid is a uniform one behind three such maps, and shares its kernels, its vacuum
//! and its polynomials along rays; only the planes and the gradients have places of their own.
//!
//! Rays are walked through its [`Bricks`], whose ranges are known, and through the [`Segment`]s of its axes, in which cells are of about one width.

mod axis;
mod bricks;
mod error;
mod field;
mod gradients;
mod grid;
mod line;
mod parts;
mod plane_walk;
mod ray;
mod segment;
mod stretches;

pub use axis::Axis;
pub use bricks::Bricks;
pub use error::RectilinearError;
pub use grid::{Centering, RectilinearGrid};
pub use parts::{RectilinearPart, RectilinearParts};
pub use segment::Segment;
