//! The whole equation of transfer for light, and only as much of it as a scene needs.
//!
//! Along a ray, s being the distance behind its front, radiance I obeys dI/ds = χ I − q − j: the total extinction χ = κ + σ takes away what is
//! absorbed (κ) and what is scattered into other directions (σ); the thermal source q adds what the medium emits, and the scattered source
//! j = σ/4π ∫ p I dω what comes from all other directions by the phase function p.
//! All lengths are world units, coefficients are per world unit, radiance is linear.

pub mod boundary;
mod ladder;
mod light_scene;
pub mod marched;
pub mod medium;
pub mod paths;
pub mod quantities;
mod random;
mod renderer;
pub mod single;
pub mod slab;
mod spectrum;
pub mod tracking;

pub use boundary::{Environment, EnvironmentMap, LightSource, Reflection, Shape, Surface, TracedSurfaces};
pub use ladder::{Ladder, LightModel, SceneFacts, thickness_along, thickness_bound};
pub use light_scene::LightScene;
pub use medium::{BandMatrix, Coefficients, FunctionMedium, Homogeneous, Medium, SceneMedium};
pub use paths::{Film, PathSampler, PathTracer, Until};
pub use random::RandomStream;
pub use renderer::{LightRenderer, Method};
pub use spectrum::Spectrum;
pub use tracking::{MajorantGrid, TrackedMedium, TransmittanceEstimator, Walk};

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
