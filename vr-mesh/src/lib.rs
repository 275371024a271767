//! Opaque surfaces among volumes: a [`Surface`] of triangles is given to a scene, and draws the [`Layer`](vr_core::Layer) of colours and
//! distances that renderers of volumes ask it for and mix in.
//!
//! # Example
//! A square of one colour, two units before the eye, fills a picture:
//! ```
//! use glam::DVec3;
//! use vr_core::{Camera, Control, Light, Projection, Shading, Surfaces, TriangleMesh, View};
//! use vr_mesh::Surface;
//!
//! let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
//! let square = TriangleMesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]])?;
//! let projection = Projection::Orthographic { height: 2.0 };
//! let camera = Camera { eye: DVec3::Z * 2.0, target: DVec3::ZERO, up: DVec3::Y, projection };
//! let view = View::new(camera, [7, 7]);
//!
//! // All of the light comes from the eye, and the square faces it: nothing is lost.
//! let shading = Shading { ambient: 0.0, diffuse: 1.0, specular: 0.0, ..Shading::default() };
//! let surface = Surface { color: Some([0.5, 0.25, 1.0]), shading, ..Surface::new(square) };
//! let layer = surface.layer(&[Light::default()], &view, &Control::default())?;
//! assert!(layer.pixels.iter().all(|&pixel| pixel == ([0.5, 0.25, 1.0], 2.0)));
//!
//! // `scene.surfaces = Some(Arc::new(surface))` puts it into a scene.
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Method
//! 1. **Outlines**: each triangle, projected in f64, may cover some rows and columns of pixels. Outlines are wider than rounding
//!    can be, and most triangles of a fine mesh lie between the centres of pixels: they are dropped here.
//! 2. **Bands**: those that are left are sorted by the bands of rows that they reach into. Bands are what runs in parallel.
//! 3. **Rays**: where an outline covers a pixel, the pixel's ray, the one that [`vr_core::Rays`] gives every renderer, is intersected with
//!    the triangle (Woop, Benthin & Wald, *Watertight Ray/Triangle Intersection*, JCGT 2013), in f64. Nothing shines through the edge
//!    between two triangles. The nearest one inside the clip is kept.
//! 4. **Light**: Blinn-Phong, two-sided, with normals of the mesh interpolated or the triangle's own, by the code that shades volumes.
//!
//! So pixels are those of a ray tracer, at the price of a rasteriser: a tree of boxes over a million triangles would take longer to build
//! than the picture takes to draw.
//!
//! # Limits
//! Edges are not smoothed: a layer has one distance a pixel, whatever [`vr_core::View::supersampling`] says. Surfaces are opaque. Cuts by the
//! clip are not closed.

mod bands;
mod outline;
mod rasterize;
mod sheared_ray;
mod surface;
mod tracer;

pub use surface::Surface;
pub use vr_core::TriangleMesh;

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
