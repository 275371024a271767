//! Volume rendering of meshes of tetrahedra, exactly: each ray goes from cell to cell through the faces that they share.
//!
//! A ray enters the mesh through a face of its surface, and leaves each cell through the face beyond which the next one lies, which is a neighbour
//! (Garrity 1990, "Raytracing irregular volume data"). Inside a cell the value is linear along the ray, so that a transfer function of straight pieces is
//! integrated piece by piece, without a step length: there is no setting by which the picture could be made better.
//!
//! # How
//! 1. **Sheared space.** For each ray the vertices are sheared so that the ray becomes the axis. Whether it passes an edge on the left or on
//!    the right is the sign of one product of two vertices, which two cells that share the edge compute alike but for the sign: no ray falls between them,
//!    whether it runs along faces, edges or through vertices.
//! 2. **Entries.** The faces of the surface are sorted into tiles of the picture; a ray tries those of its tile. Meshes may have holes and hollows: there
//!    are as many entries as there are parts of the ray inside.
//! 3. **Walk.** Each step takes one vertex, three products and the choice of a face. Value, gradient and depth at a face come from the same products, as
//!    barycentric coordinates.
//! 4. **Light.** Between two faces the transfer function is cut at its control points; each part is integrated by Gauss's rule of three points, the
//!    depth up to each point by its collocation (order 6), in parts of an optical depth of at most ½.
//!
//! # Example
//! ```
//! use vr_cells::CellMarcher;
//! use vr_core::cells::{CellMesh, CellValues};
//! use vr_core::*;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let corners = vec![glam::DVec3::ZERO, glam::DVec3::X, glam::DVec3::Y, glam::DVec3::Z];
//! let mesh = CellMesh::new(corners, vec![[0, 1, 2, 3]], CellValues::Vertices(vec![0.0, 1.0, 2.0, 3.0]))?;
//! let fog = [0.0, 3.0].map(|v| ControlPoint::new(v, [1.0, 0.8, 0.5], 0.3 * v));
//! let scene = Scene::new(mesh.into(), TransferFunction::new(fog.to_vec(), OpacityRule::Power, 1.0)?);
//!
//! let view = View::new(Camera::framing(scene.volume.bounds(), 20.0, 10.0, None), [64, 64]);
//! let control = Control::default();
//! let frame = CellMarcher::default().prepare(&scene, &control)?.render(&view, &control)?.frame;
//! assert!(frame.pixels().iter().any(|pixel| pixel[3] > 0.05));
//! # Ok(())
//! # }
//! ```
//!
//! # What it integrates
//! The canonical pixel: [`vr_core::Prepared::model`] is `Canonical`. Its error against `vr-physics` is that of rounding and of Gauss's rule, below 10⁻⁵ (10⁻⁴ in single pixels where shaded normals turn within a cell),
//! and at most 1 − `termination` where a ray ends early. Every compositing operator, shading, clip planes, opaque surfaces, and a camera inside the mesh are drawn.
//!
//! # What cannot be drawn
//! Answered by [`vr_core::RenderError::Unsupported`]: volumes that are no meshes of cells; shading and opacity by the gradient where cells have values of their own, which
//! jump and have no gradient.

mod accumulators;
mod camera_space;
mod capabilities;
mod entries;
mod marcher;
mod medium;
mod options;
mod prepared;
mod projection;
mod study;
mod walk;

pub use marcher::CellMarcher;
pub use projection::{Attenuation, CellProjector};
