//! Stub.
#![allow(missing_docs)]
mod analytic_line;
pub mod cases;
#[cfg(feature = "proptest")]
pub mod check;
mod crossings;
mod grid_line;
mod leaf;
mod line;
pub mod metrics;
mod model_solvers;
mod nodes;
mod optics;
pub mod picks;
mod poly;
mod reference;
mod transport;
pub use analytic_line::AnalyticLine;
pub use grid_line::{GradientSource, GridLine, SampleGradients};
pub use line::{LineField, LineModel};
pub use metrics::{Channels, Metrics};
pub use model_solvers::{integrate_continuous, sum_segments};
pub use optics::Optics;
pub use poly::Poly;
pub use reference::{DEFAULT_TOLERANCE, LEAST_TOLERANCE, Pixel, Reference, Solution};
pub use transport::{Certainty, Transport, transport};
