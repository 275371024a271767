//! Stub.
pub mod cases;
#[cfg(feature = "proptest")]
pub mod check;
pub mod metrics;
mod reference;
pub use metrics::Metrics;
pub use reference::{Certainty, Pixel, Reference, Solution};
