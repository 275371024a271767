//! Errors of labels and their styles.

use crate::memory::MemoryError;

/// The reason why voxels are no labels, or why labels cannot be drawn beside a volume.
///
/// # Examples
/// ```
/// use vr_core::labels::{LabelError, LabelMap};
/// use vr_core::{Calibration, Placement, UniformGrid};
///
/// let voxels = vec![0.0f32, 1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0];
/// let grid = UniformGrid::new([2; 3], voxels, Placement::from_spacing([1.0; 3])?, Calibration::default())?;
/// let error = LabelMap::new(&grid.into()).unwrap_err();
/// assert_eq!(error.to_string(), "voxel (0, 1, 0) has the value 0.5: labels are whole numbers from -2147483648 to 2147483647");
/// # Ok::<(), vr_core::GridError>(())
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LabelError {
    /// Too little memory for the ranks of labels.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// A value that is no whole number.
    #[error(
        "voxel ({}, {}, {}) has the value {found}: labels are whole numbers from -2147483648 to 2147483647",
        index[0], index[1], index[2]
    )]
    Value {
        /// The voxel.
        index: [usize; 3],
        /// Its value.
        found: f64,
    },
    /// More labels than there are numbers for.
    #[error("there are more than {limit} different values: this is no label volume")]
    TooMany {
        /// Largest number of labels.
        limit: usize,
    },
    /// Labels of another part of the world than the volume's.
    #[error(
        "the labels lie from {:?} to {:?} and the volume from {:?} to {:?}: they do not overlap, so one is in another place or patient space (units, \
         LPS and RAS)", labels[0], labels[1], volume[0], volume[1]
    )]
    Apart {
        /// Lower and upper corner of the labels' world box.
        labels: Box<[[f64; 3]; 2]>,
        /// Lower and upper corner of the volume's world box.
        volume: Box<[[f64; 3]; 2]>,
    },
    /// A style with an opacity or a colour out of range.
    #[error("label {label}: {what} is {found}, must be {allowed}")]
    Style {
        /// The label.
        label: i32,
        /// `opacity` or `colour`.
        what: &'static str,
        /// The value found.
        found: String,
        /// Values that would be right.
        allowed: &'static str,
    },
}
