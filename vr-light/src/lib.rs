//! The whole equation of transfer for light, and only as much of it as a scene needs.
//!
//! Along a ray, s being the distance behind its front, radiance I obeys dI/ds = χ I − q − j: the total extinction χ = κ + σ takes away what is
//! absorbed (κ) and what is scattered into other directions (σ); the thermal source q adds what the medium emits, and the scattered source
//! j = σ/4π ∫ p I dω what comes from all other directions by the phase function p.
//! All lengths are world units, coefficients are per world unit, radiance is linear.

mod ladder;
pub mod marched;
pub mod medium;
mod random;
pub mod slab;
pub mod tracking;

pub use ladder::{Ladder, LightModel, SceneFacts, thickness_along, thickness_bound};
pub use medium::{BandMatrix, Coefficients, FunctionMedium, Homogeneous, Medium, SceneMedium};
pub use random::RandomStream;
pub use tracking::{MajorantGrid, TrackedMedium, TransmittanceEstimator, Walk};
