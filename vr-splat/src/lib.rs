//! Object-order volume rendering by splatting: every voxel, or every point of a cloud, throws its kernel's footprint onto the picture.
//!
//! The integral of Σ fₖ w(x − xₖ) along a ray is Σ fₖ ∫ w(x − xₖ) ds: sum and integral may change places (Westover 1990, "Footprint evaluation for volume
//! rendering"; 1991, "Splatting: a parallel, feed-forward volume rendering algorithm"). So a volume is drawn splat by splat, and where it has no grid,
//! that is the natural way. What the classic got wrong came later, and is here: sheets parallel to the image (Mueller & Crawfis 1998, "Eliminating popping
//! artifacts in sheet buffer-based splatting"), classification after splatting (Mueller, Möller & Crawfis 1999, "Splatting without the blur"),
//! elliptical footprints (Zwicker, Pfister, van Baar & Gross 2001, "EWA volume splatting"), and an early end behind what is opaque.
//!
//! # How
//! 1. **What matters.** Air is never touched: voxels are kept, row by row, only where the transfer function may show something that depends on them.
//! 2. **Kernel space.** An affine map makes a kernel of any grid and width a unit ball or cube. A ray stays a line there, in perspective, too:
//!    how near it passes is exact, where the classic takes an affine approximation of the view about each splat.
//! 3. **Footprints.** What a ray takes of a radial kernel between two depths comes from one table of partial line integrals, whatever the view. Products
//!    of linear weights and of B-splines are integrated by rules that are exact for their pieces, or next to it. Where values of a grid are classified in sheets
//!    parallel to the image, weights are divided out, and each kernel is taken in the middle of a sheet: radial ones by their formula.
//!    Of scattered points with cubic splines or Gaussians, a ray's chord is looked up once, and each sheet costs a polynomial in its place on the chord.
//!    Where rays are parallel, sections of cubic splines are sums of products: powers of the ray's distance times factors of the sheet's place.
//! 4. **Tiles** of 32² pixels, in parallel: splats are binned, sorted by sheet (radix), and added to a ring of sheets, four by four pixels to a vector.
//!    Blocks of 16 pixels that are opaque take no more. No bit depends on the number of threads.
//!
//! | [`Buffers`] | what is composited | faults |
//! |---|---|---|
//! | image | sheets parallel to the image, each with the sections of kernels that lie in it | none as sheets become thin |
//! | axis | the volume's layers along the axis that the view goes most along | pops when that axis changes |
//! | samples | every splat on its own, nearest first | overlapping kernels hide each other, as if they lay one behind the other |
//!
//! By [`Classification`](vr_core::Classification) values are splatted and each sheet's values are classified (with bilinear weights, the canonical
//! field: the picture converges to the canonical pixel with the square of the distance of sheets), or voxels are classified and light is splatted, which blurs it by the kernel.
//!
//! # Example
//! ```
//! use vr_core::*;
//! use vr_splat::Splatter;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Two points of gas, and a radius for each.
//! let places = vec![glam::DVec3::ZERO, glam::DVec3::new(0.5, 0.0, 0.0)];
//! let points = PointSet::new(places, vec![1.0, 0.5], vec![1.0, 0.2], vec![1.0, 1.0], PointKernel::CubicSpline)?;
//! let fog = [0.0, 4.0].map(|v| ControlPoint::new(v, [1.0, 0.8, 0.5], 0.2 * v));
//! let scene = Scene::new(points.into(), TransferFunction::new(fog.to_vec(), OpacityRule::Power, 1.0)?);
//!
//! let view = View::new(Camera::framing(scene.volume.bounds(), 20.0, 10.0, None), [64, 64]);
//! let control = Control::default();
//! let frame = Splatter::default().prepare(&scene, &control)?.render(&view, &control)?.frame;
//! assert!(frame.pixels()[32 * 64 + 32][3] > 0.1);
//! # Ok(())
//! # }
//! ```
//!
//! # Scattered points
//! A [`vr_core::PointSet`] brings kernels and radii of its own. Values are summed and classified sheet by sheet, or, with
//! [`Classification::Pre`](vr_core::Classification::Pre), each point is classified by its value and what it emits and absorbs is spread: κ(x) = Σ wₖ κ(vₖ) Wₖ(x).
//!
//! For a weighted mean ([`vr_core::PointMixing::Mean`]), and for points with colours, each sheet also sums the weights. Its value is then
//! Σ wₖ vₖ ∫Wₖ / Σ wₖ ∫Wₖ over what supports cover, its colour likewise, its gradient by the quotient rule: of the order 2 in the distance of sheets within
//! the supports, of the order 1 where a mean begins with a jump. At the rim of supports, where all kernels are below 10⁻⁶ of their integral, they count as that.
//!
//! # What it integrates
//! [`vr_core::Prepared::model`] gives θ and b of every sheet or splat along a ray, computed in f64: `Discrete` under `over`. Under every other operator it is
//! `Canonical`, the pixel that bilinear weights converge to; the other kernels smooth, and have a value of their own.
//!
//! - `average`: ∫ Σ fₖ wₖ ds / ∫ Σ wₖ ds over what box, clip and opaque layer leave of the ray. A constant's mean is the constant, with any kernel; with bilinear
//!   weights Σ wₖ = 1, and the mean is exact but for rounding, on chords of any length.
//! - `maximum`, `minimum`: of values in the middle of sheets. `first`: colour at the threshold, or that of the sheet in which the ray enters. The volume's
//!   own sheets have the value Σ wₖ fₖ / Σ wₖ of their whole kernels, and a sample on its own has its own value wherever the ray meets its kernel: both come
//!   to the canonical pixel with the distance of voxels. Means are the same in every buffer.
//! - Depth: of light, where opacity reaches a half, each sheet being homogeneous; of `first`, where the line between the values in the middle of two sheets
//!   passes the threshold; of a maximum or minimum, the middle of its sheet; of a mean there is none (+∞), and back to front nothing is known.
//! - A first hit is shaded by the gradient of the grid, or of the sum of points, where the ray meets it.
//!
//! # Gradients
//! What is classified sheet by sheet reflects by the gradient in the middle of the sheet, central differences or the filter's own, and its opacity follows
//! that gradient's magnitude. What is classified before is shaded at the voxel or point, by the direction in which the eye sees it, and its light is splatted.
//! Scattered points have the gradient of their sum, Σ wₖ vₖ ∇Wₖ: in a sheet its mean over what supports cover, in closed form, as the value is a mean; at a
//! point classified before, and at a first hit, the gradient there. Errors fall with the square of the distance of sheets, and by the order 1 where supports end.
//! Emission given on its own reflects nothing, and factors on opacity leave it as it is.
//!
//! # Filters
//! A grid's [`Filter`](vr_core::Filter) is the kernel that spreads its voxels, unless another one was asked for ([`Shape::of_filter`]): weights are divided
//! out, so that the sum is the filter's field. Voxels beyond the box are splatted as the filter has them, and of the B-spline its coefficients.
//!
//! # Missing voxels
//! Vacuum is known to a sheet, and errors at its faces fall with the distance of sheets by the order 1; so with `average` there.
//!
//! # What cannot be drawn
//! Answered by [`vr_core::RenderError::Unsupported`]: the volume's own sheets of points, which have no layers; means and colours of points but of values in
//! sheets parallel to the image, and colours of points under operators that pick a value; another kernel for points than their own, or
//! beside a filter of the scene that is not trilinear, for a voxel is spread by one of them; the B-spline but of values in sheets parallel to the image, for its coefficients are a field only all together; analytic gradients of voxels on their own
//! under linear weights or cones, which have a kink there, and in the volume's own sheets, which have no slope across their layer; of
//! what is classified before it is splatted, maximum, minimum, average and first: light has no value to compare; back to front but of the volume's own
//! sheets under `over`, where frames have no depth. Options that have no effect beside the others (`sigma` of what is no Gaussian,
//! `slice-distance` where sheets are not parallel to the image, `termination` back to front) are errors where they are set.

mod bins;
mod bit_rows;
mod capabilities;
mod cell_range;
mod chord_table;
mod classified;
mod finish;
mod ghosts;
mod gradient_optics;
mod grid_gradients;
mod hard_cases;
mod input;
mod kernel;
mod kernel_sum;
mod model;
mod options;
mod point_gradients;
mod point_lights;
mod point_mixture;
mod prepared;
mod projection;
mod ramps;
mod renderer;
mod rim_section;
mod sample_shader;
mod section_factors;
mod section_table;
mod shading;
mod sheets;
mod sight;
mod source;
mod splat;
mod splatter;
mod study;
mod tile;
mod visible;
mod voxel_lights;
mod voxel_optics;

pub use kernel::{Shape, SplatKernel};
pub use splatter::{Buffers, CompositingOrder, Splatter};
