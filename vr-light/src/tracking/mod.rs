//! Flights of light through media whose extinction is known at points alone: null-collision tracking.
//!
//! A medium is filled up with matter that changes nothing, until its extinction is a bound that is easy to invert: collisions are drawn from that bound,
//! and those with the matter that is not there are forgotten (Woodcock 1965). The bounds are those of the cells of a
//! [`MajorantGrid`], so that a flight through thin parts looks up few points.

mod flight;
mod majorant_grid;
mod transmittance;
mod walk;

pub use flight::{Flight, FlightEnd};
pub use majorant_grid::{MajorantCell, MajorantGrid};
pub use transmittance::TransmittanceEstimator;
pub use walk::{Stretch, Walk};

use std::sync::Arc;

use crate::medium::Medium;

/// A medium and the bounds of its extinction, cell by cell.
///
/// # Examples
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use vr_core::Ray;
/// use vr_core::scattering::PhaseFunction;
/// use vr_light::{Coefficients, Homogeneous, RandomStream, TrackedMedium, TransmittanceEstimator};
///
/// let smoke = Coefficients { absorption: 2.0, ..Coefficients::default() };
/// let cube = Homogeneous::new((DVec3::ZERO, DVec3::ONE), vec![smoke], PhaseFunction::Isotropic)?;
/// let medium = TrackedMedium::new(Arc::new(cube));
/// let ray = Ray { origin: DVec3::new(-1.0, 0.5, 0.5), direction: DVec3::X };
/// let mut random = RandomStream::new(0, 0, 0);
/// let through = medium.transmittance(&ray, f64::INFINITY, 0, TransmittanceEstimator::ResidualRatio, &mut random);
/// assert!((through - (-2f64).exp()).abs() < 1e-15, "no chance where nothing varies");
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct TrackedMedium {
    medium: Arc<dyn Medium>,
    grid: MajorantGrid,
    emits: bool,
}

impl TrackedMedium {
    /// A medium with the bounds that it gives itself, in as many cells as it finds worth telling apart.
    pub fn new(medium: Arc<dyn Medium>) -> Self {
        let grid = MajorantGrid::new(&*medium);
        let emits = medium.has_emission();
        Self { medium, grid, emits }
    }

    /// The medium.
    pub fn medium(&self) -> &dyn Medium {
        &*self.medium
    }

    /// True if any place emits.
    pub fn emits(&self) -> bool {
        self.emits
    }

    /// Bounds of the extinction.
    pub fn grid(&self) -> &MajorantGrid {
        &self.grid
    }
}
