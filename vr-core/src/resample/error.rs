//! Errors of a resampling.

use crate::error::{GridError, RenderError};

/// An error of a resampling.
///
/// # Examples
/// ```
/// use vr_core::resample::{ResampleError, Resampling, Resolution, resample};
/// use vr_core::{Control, Volume, phantom};
///
/// let fog = phantom::sample::<f32>(phantom::by_name("fog").unwrap().as_ref(), [5; 3])?;
/// let options = Resampling { resolution: Resolution::Dims([4096; 3]), ..Resampling::default() };
/// let error = resample(&Volume::from(fog), &options, &Control::default()).unwrap_err();
/// assert!(error.to_string().starts_with("[4096, 4096, 4096] are 68719476736 voxels; there may be 536870912 at most"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResampleError {
    /// A kind of volume whose values cannot be interpolated.
    #[error("a {kind} cannot be resampled: {why}")]
    Kind {
        /// Kind of the volume.
        kind: &'static str,
        /// Reason, and a way out.
        why: &'static str,
    },
    /// A spacing that is not a positive length.
    #[error("spacing {found}: must be positive and finite")]
    Spacing {
        /// The spacing found.
        found: f64,
    },
    /// More voxels than allowed.
    #[error("{dims:?} are {voxels} voxels; there may be {most} at most: choose a coarser resolution")]
    TooLarge {
        /// Voxels along x, y, z.
        dims: [usize; 3],
        /// Their product, as far as it can be told.
        voxels: u128,
        /// Largest product.
        most: usize,
    },
    /// No voxel in the volume.
    #[error("{dims:?} voxels all fall into vacuum: choose a finer resolution, or the filter box")]
    Empty {
        /// Voxels along x, y, z.
        dims: [usize; 3],
    },
    /// Dims or a placement that make no grid.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// Cancelled by the caller.
    #[error("cancelled")]
    Cancelled,
}

impl From<RenderError> for ResampleError {
    /// Nothing but a cancelled control fails in the loops.
    fn from(_: RenderError) -> Self {
        Self::Cancelled
    }
}
