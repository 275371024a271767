//! Plane-parallel slabs, solved without random numbers: an independent check of random walks, and a tool in itself.
//!
//! A [`Slab`] is a stack of homogeneous [`Layer`]s, over a black or Lambertian [`Ground`]. Light comes from above, as a beam or from all directions
//! alike ([`Illumination`]), and from sources in the layers and in the ground. The solution has fluxes, fluence and radiance at any depth.
//!
//! # How
//! Radiance is followed in directions at Gauss's points of each hemisphere. A very thin layer's reflection and transmission come from the series of
//! the exponential of its generator; two equal layers make one twice as thick, and different ones are added (van de Hulst, "Multiple Light
//! Scattering", 1980; Grant & Hunt, "Discrete space theory of radiative transfer", 1969). A beam and the directions in which radiance is asked for
//! are directions without weight. Light that passes unscattered is kept apart throughout, so that neither a thin slab nor a conservative one of
//! optical thickness 10⁴ loses its digits. The number of points is doubled until two solutions agree; their difference is the error that is
//! told. Only the mean of radiance over azimuth is solved: all that fluxes need, and all of the radiance where the light is symmetric
//! about the normal.
//!
//! # Examples
//! A cloud that absorbs nothing, of optical thickness 8, under a sun at 60° from the zenith:
//! ```
//! use vr_core::scattering::PhaseFunction;
//! use vr_light::slab::{Illumination, Layer, Probes, Slab};
//!
//! let cloud = Layer::new(8.0, 1.0, PhaseFunction::henyey_greenstein(0.85)?);
//! let sun = Illumination::Beam { cosine: 0.5, flux: 1.0 };
//! let solution = Slab::new(vec![cloud])?.solve(&sun, &Probes::default(), 1e-6)?;
//! let (reflected, passed) = (solution.reflected(), solution.transmitted());
//! assert!((reflected.value + passed.value - 1.0).abs() < 1e-9);
//! assert!(reflected.value > 0.5 && reflected.error < 1e-6);
//! # Ok::<(), vr_core::ParameterError>(())
//! ```

mod directions;
mod gauss;
mod illumination;
mod layer;
mod matrix;
mod moments;
mod operators;
mod solution;
mod solver;
mod thin_layer;

pub use illumination::Illumination;
pub use layer::{Ground, Layer, Slab};
pub use solution::{Estimated, Level, Probes, SlabSolution};
