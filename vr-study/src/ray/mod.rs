//! Account of one ray: what a renderer does along it, step by step, beside the reference.
//!
//! # Examples
//! ```
//! use vr_core::Control;
//! use vr_raycast::RayCaster;
//! use vr_study::ray::RayAccount;
//! use vr_study::subject::phantom_subject;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let subject = phantom_subject("fog", 8, [16, 16])?;
//! let around = (&subject.scene, &subject.view);
//! let account = RayAccount::of(around, [8, 8], &RayCaster::default(), &Control::default())?;
//! // The sum of the steps is the renderer's pixel.
//! let last = account.rows.last().and_then(|row| row.light).expect("there is fog on the way");
//! assert!((last.running[3] - account.rgba[3]).abs() < 1e-5);
//! assert!(account.error().iter().all(|error| error.abs() < 0.02));
//! # Ok(())
//! # }
//! ```

mod account;
mod profile;
mod rows;

pub use account::{CHANNELS, RayAccount};
pub use profile::RayPart;
pub use rows::{Row, RowLight};
