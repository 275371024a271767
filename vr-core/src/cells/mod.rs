//! Unstructured meshes: volumes of tetrahedra.
//!
//! A [`CellMesh`] holds vertices, tetrahedra and one value for each vertex or each cell. The field is linear in each cell between the values of its
//! vertices, or constant in it; between cells there is vacuum. Hexahedra, wedges and pyramids are split into tetrahedra by [`split`], so that cells that
//! share a face share the triangles of it, too.
//!
//! A mesh is a [`Field`](crate::Field): every renderer of fields draws it, and the reference solves it exactly. Along a ray it is a polynomial of
//! degree 1 between the faces.

mod adjacency;
mod crossing;
mod error;
mod field;
mod line;
mod mesh;
mod of_grid;
mod repair;
pub mod split;
mod vertex_gradients;

pub use adjacency::NO_CELL;
pub use error::CellError;
pub(crate) use field::ON_FACE;
pub use mesh::{CellMesh, CellValues};
pub use repair::CellRepairs;

/// Vertices of the face across from each vertex of a cell, seen from outside counterclockwise.
pub const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
