//! Errors of a rectilinear grid.

use crate::error::GridError;
use crate::memory::MemoryError;

/// An error of a rectilinear grid.
///
/// # Examples
/// ```
/// use vr_core::rectilinear::{Centering, RectilinearError, RectilinearGrid};
///
/// let axes = [vec![0.0, 1.0, 1.0], vec![0.0, 1.0], vec![0.0, 1.0]];
/// let error = RectilinearGrid::new(axes, vec![0.0; 12], Centering::Points).unwrap_err();
/// assert_eq!(error, RectilinearError::Order { axis: 0, place: 2, found: [1.0, 1.0], ascending: true });
/// assert_eq!(error.to_string(), "axis 0: place 2 is 1 after 1; places must rise or fall all the way");
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RectilinearError {
    /// Too few places on an axis.
    #[error("axis {axis}: found {found} places; there must be {least} at least, for two values")]
    Places {
        /// 0, 1 or 2.
        axis: usize,
        /// Number of places found.
        found: usize,
        /// 2 for values at points, 3 for those of cells.
        least: usize,
    },
    /// A place that is not finite.
    #[error("axis {axis}: place {place} is {found}; places must be finite")]
    NotFinite {
        /// 0, 1 or 2.
        axis: usize,
        /// Number of the place, from 0.
        place: usize,
        /// The coordinate found.
        found: f64,
    },
    /// Places that do not go one way.
    #[error("axis {axis}: place {place} is {} after {}; places must rise or fall all the way", found[1], found[0])]
    Order {
        /// 0, 1 or 2.
        axis: usize,
        /// Number of the place at fault, from 0.
        place: usize,
        /// The coordinate before it, and its own.
        found: [f64; 2],
        /// True if the axis rises at its beginning.
        ascending: bool,
    },
    /// Steps beyond what arithmetic can keep.
    #[error(
        "axis {axis}: the step after place {place} is {found}; steps must be 1e-24 to 1e24, and coordinates at most 1e12 steps from 0"
    )]
    Step {
        /// 0, 1 or 2.
        axis: usize,
        /// Number of the place before the step, from 0, in ascending order.
        place: usize,
        /// The step found.
        found: f64,
    },
    /// Values that do not fill the grid.
    #[error("{dims:?} values along the axes: found {found} values, must be {expected}, their product")]
    Length {
        /// Values along x, y, z.
        dims: [usize; 3],
        /// Their product.
        expected: usize,
        /// Number of values given.
        found: usize,
    },
    /// Numbers of values that no grid can have.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// An axis that does not fit into the memory that is left.
    #[error(transparent)]
    Memory(#[from] MemoryError),
}
