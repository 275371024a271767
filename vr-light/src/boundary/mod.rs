//! Boundaries: what light comes from, and what it meets besides the medium.
//!
//! At a surface radiance is I = E + ∫ k I_inc cos θ dω: explicit emission E, and the implicit part that a kernel k reflects. Behind everything is the
//! [`Environment`]; [`LightSource`]s have no size.

mod environment;
mod light_source;
mod map;
mod reflection;
mod surface;
mod traced;

pub use environment::Environment;
pub use light_source::LightSource;
pub use map::EnvironmentMap;
pub use reflection::Reflection;
pub use surface::Surface;
pub use traced::TracedSurfaces;
pub use vr_core::scattering::Shape;

pub(crate) use surface::{SurfaceHit, SurfacePlace, nearest};
