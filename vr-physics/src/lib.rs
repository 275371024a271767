//! Stub.
#![allow(missing_docs)]
mod analytic_line;
mod crossings;
mod grid_line;
mod leaf;
mod line;
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
pub use model_solvers::{integrate_continuous, sum_segments};
pub use optics::Optics;
pub use poly::Poly;
pub use reference::{DEFAULT_TOLERANCE, LEAST_TOLERANCE, Pixel, Reference, Solution};
pub use transport::{Certainty, Transport, transport};
