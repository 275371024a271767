//! A first picture of a volume: what to show of it, in which colours, and from how far, found from the volume itself.
//!
//! A [`Survey`] samples the volume once. [`Survey::look`] tells what kind of data it is and gives a transfer function that shows structure
//! at first sight, with shading where there are surfaces; [`Survey::visible`] gives the places that a transfer function makes visible, and
//! [`fit()`] a camera that they fill, or [`fit_together()`] all cameras of an animation.
//!
//! ```
//! use vr_core::{OpacityRule, Scene, TransferFunction, Volume, phantom};
//! use vr_look::{Hints, Survey, fit};
//!
//! let blobs = phantom::by_name("blobs").expect("a phantom of that name");
//! let volume = Volume::from(phantom::sample::<f32>(blobs.as_ref(), [32; 3])?);
//!
//! let survey = Survey::of(&volume);
//! let look = survey.look(&Hints::default());
//! println!("{}", look.reason);
//! let transfer = TransferFunction::new(look.points, OpacityRule::Power, volume.mean_spacing())?;
//!
//! // What can be seen fills the picture, whatever the size of the box around it.
//! let whole = vr_core::Camera::framing(volume.bounds(), 30.0, 20.0, None);
//! let visible = survey.visible(&transfer, vr_core::Compositing::Over, &vr_core::Clip::default());
//! let camera = fit(&whole, &visible, 1.0);
//! let scene = Scene::new(volume, transfer);
//! assert!(scene.validate().is_ok() && camera.frame().is_ok());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # How the transfer function is found
//!
//! 1. **Kind.** Few values that jump from voxel to voxel are labels; air and tissue in their places are CT in Hounsfield units; values of
//!    both signs about zero are signed; a median far below the largest values is a heavy tail, shown on a logarithmic scale.
//!    Voxels with colours of their own keep them: the transfer function is white.
//! 2. **Background.** The most common value, and the threshold that best divides the histogram in two (Otsu 1979, "A threshold selection
//!    method from gray-level histograms"); what lies below half-way between the two is clear.
//! 3. **Boundaries.** Above, opacity follows the mean gradient magnitude at each value, which is large where materials meet, and the
//!    value (Kindlmann and Durkin 1998, "Semi-automatic generation of transfer functions for direct volume rendering").
//! 4. **Exposure.** All opacities are scaled so that rays through what is visible have a given mean opacity: neither black nor white
//!    fills the picture. The scale is solved for, with rays through the samples.

mod exposure;
mod fit;
mod fit_together;
mod histogram;
mod kind;
mod lattice;
mod number;
mod opacity;
mod palette;
mod polyline;
mod preset;
mod scale;
mod survey;

pub use fit::fit;
pub use fit_together::{centre_of, fit_together, pivot_of};
pub use histogram::Histogram;
pub use kind::Kind;
pub use palette::label_color;
pub use preset::FittedPreset;
pub use survey::{Hints, Look, Survey};
