//! Object-order volume rendering on the CPU by a shear and a warp: slices of a run-length encoded volume are sheared so that all rays are
//! parallel to one axis, composited scan line by scan line, and the picture of that is warped onto the screen (Lacroute & Levoy 1994, *Fast
//! volume rendering using a shear-warp factorization of the viewing transformation*; Lacroute 1995, thesis of the same name).
//!
//! Steps for each view:
//!
//! 1. **Factor** the view into a permutation of axes, a shear (in perspective with a scale for each slice), and a two-dimensional warp.
//! 2. **Encode**, once for each principal axis that a view needs: runs of cells in which something can be visible, and the voxels that
//!    they touch, packed ([`EmptySpace`]). Blocks in which nothing is visible are found by a min/max octree and a table of the ranges of values
//!    that can be seen, which a new transfer function needs no look at voxels for.
//! 3. **Composite** slices front to back onto the intermediate image, which lies on the volume's far face: where runs of cells
//!    meet runs of texels that are not opaque yet, sixteen at a time. Opaque texels are leaped over by links.
//! 4. **Warp** that image onto the screen ([`WarpFilter`]), and the depths of what its texels see.
//!
//! The classic ([`ShearWarp::classic`]) classifies voxels and interpolates their colours. The default interpolates values, classifies them
//! then, and takes a slice between every two layers: at about the same speed a sample it has a fraction of the error
//! ([`Classification`](vr_core::Classification)).
//!
//! # Example
//! A homogeneous slab, two units thick, of opacity ½ a unit: the pixel is known.
//! ```
//! use vr_core::*;
//! use vr_shearwarp::ShearWarp;
//!
//! let grid = UniformGrid::new([3; 3], vec![100u8; 27], Placement::from_spacing([1.0; 3])?, Calibration::default())?;
//! let half_red = ControlPoint::new(0.0, [1.0, 0.0, 0.0], 0.5);
//! let transfer = TransferFunction::new(vec![half_red], OpacityRule::Power, 1.0)?;
//! let scene = Scene::new(grid.into(), transfer);
//!
//! let control = Control::default();
//! let mut prepared = ShearWarp::default().prepare(&scene, &control)?;
//! let camera = Camera::framing(scene.volume.bounds(), 0.0, 0.0, None);
//! let picture = prepared.render(&View::new(camera, [5, 5]), &control)?;
//!
//! // What shines through two units is a half of a half. Straight along an axis nothing is sheared, and a constant field leaves no error.
//! let expected = [0.75, 0.0, 0.0, 0.75];
//! for (got, want) in picture.frame.pixel(2, 2).into_iter().zip(expected) {
//!     assert!((got - want).abs() < 1e-6);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What it integrates
//! Samples in slices, each for its share of the ray: half of the distance to the next slice on either side, or all to where the ray enters
//! or leaves the volume; corrected for how far apart slices are along the ray. That is its model
//! ([`Prepared::model`](vr_core::Prepared::model)); what is added by texels and warp, by tables (the nearest of 8 entries to a byte, of 4096 otherwise)
//! and by rounding is the algorithm's own.
//!
//! # Accuracy
//! Errors fall with [`ShearWarp::texel`], to which the distance of slices is relative, by the order 2 of two linear resamplings where picture and
//! field are smooth. From texels of a voxel to those of an eighth 1.7 was measured, for the kinks that a field linear between voxels has there; 1.3
//! where the transfer function jumps; 1.8 as the grid is refined at a texel of half a voxel; 2.0 in the size of pixels. Rounding to the nearest entry of tables leaves some
//! 10⁻⁵.
//!
//! At the default, a texel as large as a voxel, what bends within a voxel is lost: thin shells, steep transfer functions, the outline of a
//! volume that fills its box, which is as soft as a texel is wide. The largest errors on the hard cases of `vr-physics`, most of them small
//! volumes: opaque wall 0.93 (RMSE 0.08), thin shell 0.73 (0.04), the full range of u16 0.62 (0.2), Marschner-Lobb 33³ 0.22 (0.03), a layer far from
//! the origin 0.21 (0.02); 0.13 where outlines decide (0.02), 0.05 elsewhere (0.01); 7·10⁻⁶ in many faint steps.
//! No error can be promised.
//!
//! # Shading and gradients
//! Normals are encoded, half a degree off on average, and what they reflect is interpolated: between the voxels of a smooth field that is off by the square of a voxel, in
//! texels of any size. Parallel rays share a table of that. In perspective
//! lights at the eye and highlights change from ray to ray: each texel's own ray decides what the normals around its samples reflect.
//!
//! If opacity follows the gradient, by a factor or by the rows of a transfer function, each voxel keeps its gradient as three numbers. Values take
//! their opacity and their reflection from gradients that are interpolated to the sample; voxels that are classified first, from their own. The
//! trilinear filter's own gradient is available for values in slices between the layers of voxels. It jumps at the layers and at voxels, so
//! slices that are layers, and voxels that are classified first, are refused.
//!
//! # Depths
//! A texel's depth is along its own ray: where opacity reaches a half, the medium homogeneous around each slice (order 2 in the distance of slices);
//! of an extreme, the slice whose sample it is (order 1); of `first`, the surface itself. A pixel has a depth where the coverage between
//! its four texels is a half at least (the opacity of light, else that a texel has a depth). It is the mean of those texels' depths
//! that lie on the sheet of the nearest, no more than four texels' width from it: order 2 on a surface, and never a mean across an edge.
//!
//! # First surfaces
//! A texel's ray meets the surface between the first sample that reaches the threshold and the one before, or the point where the ray enters; values
//! between are taken to be linear (order 2). There it is shaded, by central differences or by the filter's gradient. Runs hold the cells alone that reach the threshold.
//!
//! # Opaque surfaces
//! The layer of a view tells where the rays of pixels end. The ray of a texel ends at a depth that is linear between the four pixels around it, as far as they see
//! the same surface as the nearest: samples behind that are none, and the last before it stands for all the way to it (order 2). A pixel beside an
//! outline is interpolated from those of its texels that end at its own surface (Kopf et al. 2007, *Joint bilateral upsampling*), and the layer's own
//! colour is added behind it: so outlines are as sharp as the layer's. Within a texel of an outline the medium is off by as much as it changes
//! from one texel to the next (order 1).
//!
//! # Views
//! * Parallel rays shear along the axis that they go most along, so that no slice moves by more than a voxel.
//! * In perspective each ray has its own such axis. The picture is split by it, and each part is composited along its own, from inside the
//!   volume, too. Texels are as large as voxels in the volume's middle; no slice has more than 1¼ voxels to one, so that none is missed.
//! * Crop boxes, clip planes and, of parallel rays, the plane through the eye cut each texel's ray where they meet it.
//!
//! # The nearest voxels
//! Under the filter nearest, slices hold values of the nearest voxels, or these as they are classified: the light is the same. Slices and texels lie where no
//! voxel ends: half way between layers an even number of slices to a voxel has none, and texels a voxel wide stand on voxels. Where the field jumps, pictures are off
//! over a texel's width: the RMSE falls by the order 1 of that. Gradients are those of the voxels, interpolated as under every filter. Normals of labels and of noise turn
//! by any angle from voxel to voxel: values reflect by interpolated gradients, not by a mean of what voxels reflect. Voxels that are classified first reflect by their
//! own, which keeps an error in texels of any size.
//!
//! # Colours of voxels
//! Values in slices have the colour of their place, interpolated as values are, and voxels that are classified first their own; light is multiplied by it before it reflects.
//! An extreme and a surface have the colour of the place, a mean has that of the ray, which takes the slices a second time.
//!
//! # What it does not do
//! It answers [`vr_core::RenderError::Unsupported`] to: volumes that are no uniform grids; reconstruction filters other than the trilinear one and the nearest;
//! media that scatter; the filter's own gradients where they jump (voxels that are classified, and slices that are layers of voxels).
//! `maximum`, `minimum` and `average` are of the samples in slices.

mod axis;
mod capabilities;
mod classified;
mod codes;
mod composite;
mod encode;
mod factorization;
mod hard_cases;
mod image;
mod isosurface;
mod jobs;
mod lengths;
mod links;
mod memory;
mod model;
#[cfg(test)]
mod naive;
mod optics;
mod options;
mod passes;
mod prepared;
mod ray_distances;
mod reflections;
mod region;
mod renderer;
mod shear_warp;
mod sheet;
mod shown;
mod slices;
mod steepness;
mod study;
mod surface_depths;
mod warp;

pub use memory::EncodedSize;
pub use shear_warp::{EmptySpace, ShearWarp};
pub use warp::WarpFilter;
