//! Parts that fast volume renderers share: kernels on sixteen lanes, tables of transfer functions, ranges of fields.
//!
//! * [`vector`]: sixteen rays at once, on whatever vector instructions the machine has: sampling, classification, shading, compositing.
//! * [`tables`]: transfer functions in tables, for a step of one length ([`tables::BakedTransfer`]) or for any two values at its ends
//!   ([`tables::PreIntegrated`]), with a bound of what that costs.
//! * [`ranges`]: smallest and largest value of the field, block by block: for renderers that leap, cull or skip.
//! * [`bits`]: rows of bits and their runs.
//! * [`step_by_gradient`]: steps where opacity follows the gradient, one by one.
//!
//! Everything here is a fast form of a definition in `vr-core`, and tested to equal it.
//!
//! # Example
//! Light and opacity of a step of half a voxel, looked up instead of computed:
//! ```
//! use vr_core::{Calibration, ControlPoint, OpacityRule, TransferFunction};
//! use vr_kernels::tables::BakedTransfer;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let points = vec![ControlPoint::new(0.0, [1.0; 3], 0.0), ControlPoint::new(255.0, [1.0; 3], 0.5)];
//! let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0)?;
//! let table = BakedTransfer::<f64>::new(&transfer, Calibration::default(), (0.0, 255.0), true, 0.5);
//! let [.., alpha] = table.step(51.0);
//! assert!((alpha - transfer.step(51.0, 0.5)[3]).abs() < 1e-12);
//! # Ok(())
//! # }
//! ```

pub mod bits;
mod gradient_step;
pub mod ranges;
pub mod tables;
pub mod vector;

pub use gradient_step::{step_by_gradient, step_with_extinction_times};

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
