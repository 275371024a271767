//! Monte Carlo: radiance as the mean over random paths of light, followed from the eye to where the light comes from.

mod direct_light;
mod film;
mod path;
mod tracer;

pub use film::Film;
pub use path::PathSampler;
pub use tracer::{PathTracer, Until};
