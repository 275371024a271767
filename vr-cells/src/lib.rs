//! Volume rendering of meshes of tetrahedra, by two renderers: [`CellMarcher`] goes from cell to cell along each ray, [`CellProjector`] draws cell after cell.
//!
//! # The marcher
//! A ray enters the mesh through a face of its surface, and leaves each cell through the face beyond which the next one lies, which is a neighbour
//! (Garrity 1990, "Raytracing irregular volume data"). Inside a cell the value is linear along the ray, so that a transfer function of straight pieces is
//! integrated piece by piece, without a step length: there is no setting by which the picture could be made better.
//!
//! 1. **Sheared space.** For each ray the vertices are sheared so that the ray becomes the axis. Whether it passes an edge on the left or on
//!    the right is the sign of one product of two vertices, which two cells that share the edge compute alike but for the sign: no ray falls between them,
//!    whether it runs along faces, edges or through vertices (in `f64` that sign is exact, and a ray that meets an edge is taken to pass a little beside it).
//!    Seen from among cells, rays begin in those around the eye.
//! 2. **Entries.** The faces of the surface are sorted into tiles of the picture; a ray tries those of its tile. Meshes may have holes and hollows: there
//!    are as many entries as there are parts of the ray inside.
//! 3. **Walk.** Each step takes one vertex, three products and the choice of a face. Value, gradient and depth at a face come from the same products, as
//!    barycentric coordinates.
//! 4. **Light.** Between two faces the transfer function is cut at its control points; each part is integrated by Gauss's rule of three points, the
//!    depth up to each point by its collocation (order 6), in parts of an optical depth of at most ½.
//!
//! Sixteen rays walk at once, in `f32`, if light is integrated, shaded or not, and the mesh lies in front of the eye. Places are kept relative to each ray to the
//! last bits, and depths and values relative to where it was a few cells ago: a depth among those of the whole mesh is rounded by more than opaque cells forgive.
//! A lane takes the next ray of its tile when it is done. A ray is cut into stretches, whose light does not depend on what lies
//! before; sixteen of any rays are integrated together, by parts, so that one integral by four points serves all colours up to an optical depth of 2½. Walls,
//! logarithms near them and rays that get stuck are left to the plain code in `f64`, which draws everything else.
//!
//! # The projector
//! A cell is drawn as its outline on the screen, from front to back (Shirley & Tuchman 1990, "A polygonal approximation to direct scalar volume rendering"):
//! 1. **Order.** Of two cells that share a face, the one on the eye's side comes first (Williams 1992). Across hollows and between parts of a mesh, the samples of the
//!    picture tell: behind the face by which a ray leaves, the one by which it enters next (after Silva, Mitchell & Williams 1998). Together that is exact for
//!    every sample, convex mesh or not. Cells that lie before one another in a ring are found as strong components (Tarjan 1972); the tiles that they touch are
//!    drawn ray by ray, from cell to cell, and so are tiles of cells around the eye.
//! 2. **Outline.** Vertices are put on a lattice of 2⁻¹⁴ samples, on which the sides of places are exact. A face covers the outline, or two edges cross: the
//!    apex is there. Thickness, depth and value on both sides are minima and sums of a few functions that are linear on the screen, with reciprocal depths in
//!    perspective: right in every sample, not only at the corners.
//!    The samples inside are found row by row, from where each edge crosses it, which both cells beside the edge compute alike; sixteen of them are drawn at once,
//!    wherever they lie.
//! 3. **Light.** The mean of extinction and of the light sent between two values is the difference of two integrals over values, kept in one table, whatever control
//!    points lie between (after Röttger, Kraus & Ertl 2000, without the table's third dimension). The order of colours within a segment counts to the first
//!    order of its optical depth; deep segments, and those with a control point inside, are taken in parts.
//!
//! Every other operator, shading and walls are drawn ray by ray, from cell to cell, by the marcher's integrals in f64. The classic approximation
//! ([`Attenuation::Linear`]) takes opacity and colour at the apex, linear to the rim:
//!
//! | scene, 512² pixels | exact: largest, RMSE | linear: largest, RMSE |
//! |---|---|---|
//! | Marschner-Lobb, 196,608 cells, translucent peaks | 4·10⁻⁴, 2·10⁻⁵ | 0.33, 0.044 |
//! | the same, opaque | 1·10⁻³, 1.1·10⁻⁵ | 0.81, 0.067 |
//! | blobs, 10,368 cells | 1·10⁻⁴, 1·10⁻⁶ | 0.12, 0.006 |
//! | blobs, 196,608 cells | 3·10⁻⁴, 2·10⁻⁶ | 0.13, 0.004 |
//! | blobs, 1,971,054 cells | 7·10⁻⁵, 8·10⁻⁷ | 0.05, 0.002 |
//!
//! (`cargo run --release -p vr-cells --example project_speed`, against the marcher.)
//!
//! Large cells (25 opaque unit distances across) under a transfer function that jumps have an RMSE of up to 8·10⁻⁵ and a pixel off by up to 4·10⁻³. A jump is drawn as a
//! ramp as wide as 1/8192 of all values: a ray that stays that near to it all the way through a deep cell may be off by more.
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
//! The canonical pixel: [`vr_core::Prepared::model`] is `Canonical`. The marcher's error against `vr-physics` is that of rounding and of Gauss's rule, below 10⁻⁵ (10⁻⁴ where shaded
//! normals turn within a cell),
//! and at most 1 − `termination` where a ray ends early. Every compositing operator, shading, clip planes, opaque surfaces, and a camera inside the mesh are drawn.
//!
//! # What cannot be drawn
//! Answered by [`vr_core::RenderError::Unsupported`]: volumes that are no meshes of cells; shading and opacity by the gradient where cells have values of their own, which
//! jump and have no gradient. `attenuation=linear` knows a cell by its apex: it refuses shading, clips, opaque surfaces, emission of its own and operators other than `over`.

mod accumulators;
mod camera_space;
mod capabilities;
mod entries;
mod marcher;
mod medium;
mod options;
mod packet;
mod prepared;
mod projection;
mod screen;
mod single_rays;
mod study;
mod tile_lists;
mod walk;

pub use marcher::CellMarcher;
pub use projection::{Attenuation, CellProjector};
