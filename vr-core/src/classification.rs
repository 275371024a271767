//! Order of interpolation and classification.

/// Order of interpolation and classification in a renderer that reconstructs the field from voxels.
///
/// # Examples
/// ```
/// use vr_core::{Classification, ControlPoint, OpacityRule, TransferFunction};
///
/// // Half way between two clear voxels lies an opaque value: only one order sees it.
/// let point = |(value, opacity)| ControlPoint::new(value, [1.0; 3], opacity);
/// let points = [(0.0, 0.0), (1.0, 0.8), (2.0, 0.0)].map(point).to_vec();
/// let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0)?;
/// let half_way = |order| match order {
///     Classification::Post => transfer.at(0.5 * (0.0 + 2.0)).opacity,
///     Classification::Pre => 0.5 * (transfer.at(0.0).opacity + transfer.at(2.0).opacity),
/// };
/// assert_eq!((half_way(Classification::Post), half_way(Classification::Pre)), (0.8, 0.0));
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Classification {
    /// Values are interpolated, then classified.
    #[default]
    Post,
    /// Voxels or points are classified, then their optical properties are interpolated.
    Pre,
}
