//! Image-order volume rendering on the CPU: a ray through every pixel, sampled where it matters.
//!
//! For each ray:
//!
//! 1. **Cut**: the part of the ray inside the box, the clip and before an opaque layer, in f64, in index space.
//! 2. **Walk**: that part is cut into steps ([`Step`]): as long as the medium in each place allows (the default), all of one length, as
//!    long as a bound of the error permits, or from cell to cell ([`Traversal`]). What cannot be seen is leaped over ([`EmptySpace`]).
//! 3. **Sample**: the field in each step, by the reconstruction filter.
//! 4. **Classify**: values, looked up in the transfer function *after* reconstruction, become the light and the opacity of the step, by one
//!    of the integration rules ([`Rule`]), with the light that the step absorbs itself taken off.
//!    Voxels that have colours of their own ([`vr_core::ColorGrid`]), and points, multiply that light by the colour at the sample.
//! 5. **Shade**, where the scene is shaded, by the gradient at the sample, followed along its tangent over steps in which the normal turns
//!    ([`vr_core::turning`]).
//! 6. **Composite** with the scene's operator.
//!
//! The rays are a choice, too ([`ImageSampling`]): those of every pixel, or fewer where the picture bends little. Steps, rays and rule are chosen by the scene
//! unless they are set, for the error of a [`Quality`].
//!
//! Two engines do this. The *plain* one takes every scene and setting but an error bound: samples go through the passes in runs of 32, each pass generic
//! code, instantiated for what it depends on and chosen once a run. The *vector* one ([`Vector`]) takes rays in packets of sixteen with
//! AVX-512, AVX2, SSE2 or NEON, and draws the common scenes: grids under every filter, with colours or without, adaptive meshes, rectilinear grids and scattered points, over and accumulate, front to back, shaded or not. In grids, its rays begin where the
//! outermost visible blocks, projected once a view, say that something can be seen. It is tested against the plain one, which is tested
//! against `vr-physics`.
//!
//! # Example
//! A homogeneous slab, two units thick, of opacity ½ a unit: the pixel is known.
//! ```
//! use vr_core::*;
//! use vr_raycast::RayCaster;
//!
//! let grid = UniformGrid::new([3; 3], vec![100u8; 27], Placement::from_spacing([1.0; 3])?, Calibration::default())?;
//! let half_red = ControlPoint::new(0.0, [1.0, 0.0, 0.0], 0.5);
//! let transfer = TransferFunction::new(vec![half_red], OpacityRule::Power, 1.0)?;
//! let scene = Scene::new(grid.into(), transfer);
//!
//! let control = Control::default();
//! let mut prepared = RayCaster::default().prepare(&scene, &control)?;
//! let camera = Camera::framing(scene.volume.bounds(), 0.0, 0.0, None);
//! let picture = prepared.render(&View::new(camera, [5, 5]), &control)?;
//!
//! // What shines through two units is a half of a half. A constant field leaves no error but rounding.
//! let expected = [0.75, 0.0, 0.0, 0.75];
//! for (got, want) in picture.frame.pixel(2, 2).into_iter().zip(expected) {
//!     assert!((got - want).abs() < 1e-6);
//! }
//! // The picture's height is the diagonal of the box: its corners see past it.
//! assert_eq!(picture.frame.pixel(0, 0), [0.0; 4]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Accuracy
//! | what | order in the step |
//! |---|---|
//! | [`Rule::Midpoint`] under over and accumulate: continuous filter, transfer function without jumps | 2 |
//! | [`Rule::Left`] | 1 |
//! | either with the nearest filter, or where the transfer function jumps or an opaque wall begins | 1: the place is known to one step |
//! | [`Rule::Linear`] | 2, at jumps and walls, too |
//! | [`Rule::Quadratic`], smooth field | 4; at kinks of the transfer function 3.6, at jumps 2 |
//! | [`Rule::Quadratic`], trilinear field | 2, for its kinks at cell faces, with a quarter to a fifteenth of midpoint's error at the same step; from one step a cell on 10⁻⁶ to 10⁻⁴ with [`Traversal::Cells`] |
//! | [`Rule::Exact`], [`Traversal::Cells`] | no error but rounding, unless shaded (one gradient a cell) |
//! | average, midpoint | 2 |
//! | maximum, minimum: samples and chord ends | 2 inside a smooth piece; 1 at a kink of the field |
//! | first | as exact as f32 depth, where the field crosses the threshold once between two samples |
//!
//! The kinks that a trilinear field has at cell faces, and a transfer function at its points, leave order 2 as it is, for the error
//! of a step with a kink in it is of order 2, too.
//!
//! No step goes below the floor: rounding in f32 (about 10⁻⁵ of the largest pixel, positions included), the table
//! ([`vr_kernels::tables::TableError`]) and early termination (10⁻⁴ by default). [`RayCaster::exact`] has none of
//! them; its floor is that of a frame, which holds f32.
//!
//! A feature between two samples is missed: a shell thinner than a step, a crossing there and back. The largest errors on the hard
//! cases of `vr-physics`, by default ([`Step::Local`], aimed at an RMSE of [`Step::ERROR`], by [`Rule::Quadratic`] where the transfer function is sharp) and in uniform steps of ⅕:
//!
//! | case | default | steps of ⅕ | why |
//! |---|---|---|---|
//! | opaque wall | 1·10⁻⁶ | 0.42 (RMSE 0.023) | a wall's place is known to one step; parabolas find it |
//! | thin shell | 0.031 (RMSE 9·10⁻⁴) | 0.31 (0.022) | a hundredth of a step wide |
//! | full u16 | 0.066 (0.003) | 0.04 | ten or so ramps in a cell |
//! | missing voxels | 6·10⁻⁴ | 0.019 | vacuum begins within a step; local steps end there |
//! | two samples | 0.010 | 0.007 | shading turns fast where the gradient is small |
//! | Marschner-Lobb 33³ | 0.004 | 0.006 | a ramp crossed in half a voxel |
//! | emission 10⁶ | 0.006 | 0.005 | |
//! | grazing, axis-aligned, inside, far, 1:1:50 | 3·10⁻³ | 2·10⁻⁴ | the square of the step |
//! | κ = 10⁻¹² | 9·10⁻⁴ | 4·10⁻⁵ | |
//! | 4096 steps of α = 10⁻⁷ | 2·10⁻⁴ | 8·10⁻⁹ | the field alternates faster than long steps see |
//! | constant | 2·10⁻⁷ | 2·10⁻⁷ | |
//!
//! # Empty space
//! Under over, accumulate and first, steps in which nothing can be visible are not sampled. [`EmptySpace`] says how rays find them; no way
//! changes a picture by a bit, its depths included.
//!
//! # Classics
//! The feature `classics` adds the accelerations of the literature that lost to these: other structures over empty space, coarse steps that
//! look at a flag, long steps where the medium is nearly the same, walks from voxel to voxel, ray templates and two coherence buffers. The
//! README in `src/classics` tells what each was for and what beat it.
//!
//! # Error bound
//! [`Step::ErrorBound`] takes steps as long as a largest error allows: no component of a pixel is further from the
//! correct one than asked for, or else its ray is counted ([`vr_core::Counts::unbounded`]). Every step comes with a bound; the README in
//! `src/error_bound` derives them. It is the choice where an error must not be exceeded, and for thin shells, walls and noise, which
//! samples at distances miss. On smooth scenes it takes some two to four times as long as plain steps of ⅕.
//!
//! # What it does not do yet
//! Its vector kernels ([`Vector`] says what they draw) know grids, adaptive meshes, rectilinear grids and scattered points: meshes of cells and functions go
//! ray by ray. Local steps beside voxels with colours are a sixth of a voxel at most. Volumes that are no uniform grids it draws by the rules midpoint and left alone, or within an error bound, and those that
//! are neither adaptive meshes nor rectilinear grids, whose ranges of values are known part by part, in uniform steps. A scene that it cannot draw is [`vr_core::RenderError::Unsupported`].

// What the modules hold for classics alone; the check for dead code is that with all features.
#![cfg_attr(not(feature = "classics"), allow(dead_code))]

mod capabilities;
mod caster;
mod chord;
#[cfg(feature = "classics")]
mod classics;
mod classify;
mod engine;
mod error_bound;
mod hard_cases;
mod leap;
mod near_depths;
mod operator;
mod options;
mod pace;
mod packet;
mod pipeline;
mod place_colors;
mod polled_tracer;
mod prepared;
mod projection;
mod ray_value;
mod render_tables;
mod renderer;
mod root;
mod rule;
mod run;
mod screen;
mod shade;
mod silhouette;
mod source;
mod step_map;
mod study;
mod table_range;
mod thin_parts;
mod tracer;
mod walk;

pub use caster::{
    CompositingOrder, EmptySpace, ImageSampling, Precision, Quality, RayCaster, Rule, Step, TransferLookup, Traversal,
    Vector,
};
#[cfg(feature = "classics")]
pub use classics::Connectivity;
