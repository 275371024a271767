//! Radiative quantities besides the radiance of a ray: fluence, flux through a face, and the balance of energy.

mod energy;
mod estimate;
mod fluence;
mod forward;

pub use energy::EnergyBalance;
pub use estimate::Estimate;
pub use fluence::{fluence, flux};
