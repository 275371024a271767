//! Volume rendering by slices through textures, as graphics cards made it fast (Cabral, Cam & Foran 1994, *Accelerated volume rendering and
//! tomographic reconstruction using texture mapping hardware*; Engel, Kraus & Ertl 2001, *High-quality pre-integrated volume rendering using
//! hardware-accelerated pixel shading*), in software: a pipeline of small exact stages, of which a graphics card could take over those of fragments.
//!
//! 1. **Set-up**, in f64: where slices are ([`Proxy`]), and what of each pixel's ray lies between the middles of two neighbours: a slab. Slabs are cut by the
//!    box, the clip and an opaque layer, so the first and the last of a ray are as short as they are, and nothing of the ray is left out.
//! 2. **Proxy geometry** ([`geometry`]), where the picture is made slice by slice ([`DrawOrder::Slices`]): the polygon in which a slab's near face cuts what is left
//!    of the box under the clip (of a stack's layer a quad), and the strips of the box's own faces beside the slab, as far as they are turned to the eye; for a ray at the box's rim
//!    may meet a slab, and not the slice in its middle. They are cut into fans of triangles, and these rasterised by the top-left rule, corners on a grid of 2⁻⁸ pixels.
//!    Slabs are drawn four of these parts larger than they are, and a fragment is discarded where its ray has no part of the slab: so rounding loses none. Tile by tile,
//!    each pixel's own chord says the same.
//! 3. **Fetch**: sixteen pixels at a time, from a texture of values, of light, of palette indices, or of compressed blocks ([`Format`]).
//! 4. **Classification**, by tables that are off by less than rounding or not used at all; **shading**; and **blending** ([`Blend`], or the scene's own
//!    compositing) of each pixel's fragments in their order.
//!
//! The picture depends on the order of fragments on each pixel alone; [`DrawOrder::Slices`] draws all fragments of a slice, whatever the texture, the operator and the
//! blend, before those of the next, through the same stages, and counts the same. So the default takes all slices of sixteen pixels, then the next sixteen: the
//! same bits as slice after slice across the picture, without the picture going through the caches once a slice.
//!
//! # Example
//! A homogeneous slab, two units thick, of opacity ½ a unit: the pixel is known.
//! ```
//! use vr_core::*;
//! use vr_texslice::TextureSlicer;
//!
//! let grid = UniformGrid::new([3; 3], vec![100u8; 27], Placement::from_spacing([1.0; 3])?, Calibration::default())?;
//! let half_red = ControlPoint::new(0.0, [1.0, 0.0, 0.0], 0.5);
//! let transfer = TransferFunction::new(vec![half_red], OpacityRule::Power, 1.0)?;
//! let scene = Scene::new(grid.into(), transfer);
//!
//! let control = Control::default();
//! let mut prepared = TextureSlicer { slice_spacing: 0.7, ..TextureSlicer::default() }.prepare(&scene, &control)?;
//! let camera = Camera::framing(scene.volume.bounds(), 0.0, 0.0, None);
//! let picture = prepared.render(&View::new(camera, [5, 5]), &control)?;
//!
//! // What shines through two units is a half of a half, whatever the distance of slices: the last slab counts as what it is.
//! let expected = [0.75, 0.0, 0.0, 0.75];
//! for (got, want) in picture.frame.pixel(2, 2).into_iter().zip(expected) {
//!     assert!((got - want).abs() < 1e-6);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What it integrates
//! A fragment for each slab: whole ones are sampled on their slices, the first and the last of a ray in the middle of what there is of them; or, pre-integrated,
//! on the faces between slabs, where a ray enters and where it leaves. That is its model ([`Prepared::model`](vr_core::Prepared::model)); tables and rounding add
//! 10⁻⁷ to 10⁻⁵ to it, 10⁻⁴ where a transfer function bends within a hundredth of a texture's range.
//!
//! A stack's slice on a layer belongs to the cells on both sides of it: beside missing voxels it is vacuum where either of them is.
//!
//! Shaded, a fragment of values reflects what a surface across the gradient at its sample does; a segment, at its middle, so that both ends have their share.
//! Light (`rgba`, `luminance-alpha`, palettes) is shaded at the voxels before it is interpolated, each voxel by the ray on which it is seen: in perspective from the eye to
//! it. Beside each index a palette keeps what its voxel reflects, three factors and three lights: it has one colour for a value, not one for each way that
//! a surface may face. Compressed textures are shaded by gradients of what their blocks hold, and are as rough as these. Beside missing voxels central differences are
//! those of the field in which missing ones have the nearest value that is there.
//!
//! Opacity follows the gradient, by a factor or by the rows of a transfer function, where the same gradients say: a fragment of values is classified by its value and by
//! the magnitude at its sample. A segment has the magnitude of its middle all along: a factor makes it so much longer, as far as it absorbs; of rows, their means over
//! the segment are mixed. Light is classified by the gradients at the voxels, and a palette keeps one of 256 levels of the magnitude beside each index (Kniss, Kindlmann
//! & Hansen 2001, *Interactive volume rendering using multi-dimensional transfer functions and direct manipulation widgets*): it has 256 colours for each of them.
//!
//! Analytic gradients are the derivative of the trilinear interpolant in a sample's cell, on a face between two of the one with the larger index, and none in vacuum, where the
//! middle of a segment may lie. Textures of light have no such gradients: at a voxel, eight cells meet.
//!
//! Depths are world distances along the ray: to where opacity reaches a half under `over` and `accumulate`, whatever the order of blending, to the point of `first`, to the sample that
//! `maximum` and `minimum` pick. A mean is nowhere: +∞.
//!
//! | slices | slabs | equally long |
//! |---|---|---|
//! | planes | between planes parallel to the image, counted from the middle of the box | in parallel projection |
//! | shells | between spheres about the eye (slice by slice, the box between two planes around each is rasterised: no sphere is tessellated) | always |
//! | stacks | between the volume's own layers (or parts of one), along the axis that the view crosses most of | in parallel projection, but of light |
//!
//! If they are not, opacity is corrected fragment by fragment; [`TextureSlicer::correction`] turns that off, to show what then becomes of brightness.
//!
//! # What a change forces
//! | format | bytes a voxel | a new transfer function | a new view |
//! |---|--:|---|---|
//! | scalar | as stored (a stack along x or y: once more) | a table | a table, where slabs' length changes |
//! | pre-integrated | as stored | a table | nothing |
//! | compressed | 0.41 (bytes), 0.56 (16 bits), 0.63 (floats) | a table | as scalar |
//! | rgba | 16 | every voxel | every voxel, if shaded |
//! | luminance-alpha | 8 | every voxel | every voxel, if shaded |
//! | paletted | 1; shaded 24 more; by gradient 1 more | 256 entries; by gradient 256² | what every voxel reflects, if shaded |
//!
//! Stacks of light and of compressed blocks lie as the volume does, once for all three axes: coordinates are turned when a texel is fetched. Their light is that of slabs
//! met at a right angle, corrected fragment by fragment, so that views along the same axis share it.
//!
//! [`RenderStats::stages`](vr_core::RenderStats::stages) of the next picture tells what had to be made, and how long it took: `table`, `palette`, `classify`,
//! `reflect`, `compress`, `stack`, `brick`; what was there already is not listed. Textures, tables apart, stay within [`TextureSlicer::budget`], or there is a typed error.
//!
//! # Bricks
//! [`TextureSlicer::brick`] cuts the volume's texture into bricks, each a texture of its own: its cells' texels, of which neighbours share a layer, and where
//! fragments look at central differences one more on all sides, and beside missing voxels the values that these are taken from. Bricks are drawn in an
//! order in which none hides one before it, or back to front, and each takes all fragments that lie in it; the picture is that through one texture, bit for bit, in
//! every format, under every operator and blend, shaded or not. Bricks of a stack of values have their texels with its axis last, as the stack has; a sample belongs to the brick in
//! which its slice lies, and beside missing voxels they have one more layer, for what lies on a layer belongs to the cells on both sides.
//!
//! A brick is made when rays first meet something visible in it: copied, classified, or decoded from compressed blocks, whose texels are then fetched as those of
//! plain values. It stays for later pictures until the budget has no room for another, and the least recently used ones go first. Compressed blocks
//! themselves stay, and count. A budget in which the largest brick has no room is refused, with the bytes that it needs.
//!
//! A pre-integrated segment may begin in one brick and end in another: it is drawn in that of its end, with the value kept from its begin, and the gradient of its middle, if
//! that is looked at, from the brick of the middle. A brick is left out where nothing is visible as far around it as a segment reaches.
//!
//! # Accuracy
//! Against the canonical pixel, errors fall with the distance of slices by the order 2 where field and transfer function are continuous, of planes, shells and
//! pre-integrated segments; where the transfer function jumps, by 1, but by 1.4 to 1.6 of segments; by 1 where analytic gradients are looked at, which jump from cell to
//! cell. Stacks, compression and light that is interpolated after
//! classification have an error of their own that no distance takes away. `docs/figures/vr-texslice.md` has the figures; the bounds on the hard cases of
//! `vr-physics` are those of [`Documented::hard_case_errors`](vr_core::Documented::hard_case_errors). No error can be promised.
//!
//! # What it does not do
//! It answers [`vr_core::RenderError::Unsupported`] to: volumes that are no uniform grids; filters other than the trilinear one and the nearest; segments and analytic gradients under the nearest, whose field jumps; analytic gradients in textures of light;
//! colours, and lights of a colour, on luminance alone; values picked from textures of light, back to front, by segments or without correction; and
//! bricks slice by slice: a brick's slices are drawn while it is there. `maximum` and `minimum` are of samples.

mod bricks;
mod capabilities;
mod classified;
mod compression;
mod draw;
mod finish;
mod fragments;
pub mod geometry;
mod gradients;
mod hard_cases;
mod layout;
mod medium;
mod model;
mod occupancy;
mod options;
mod palette;
mod prepared;
mod projection;
mod proxy;
mod region;
mod renderer;
mod slices;
mod store;
mod study;
mod tables;
mod texel_cell;
mod texture;
mod texture_slicer;
mod textures;
mod tint;

pub use texture_slicer::{Blend, DrawOrder, Format, Proxy, TextureSlicer};
