//! Combination of the values of scattered points into a field.

/// Combination of what scattered points carry where their supports overlap.
///
/// | mixing | field | of |
/// |---|---|---|
/// | sum | Σ wₖ vₖ Wₖ | densities, and values where weights are the volumes that points stand for |
/// | mean | Σ wₖ vₖ Wₖ / Σ wₖ Wₖ | values: between those of the points near by, however dense they lie (Shepard 1968, "A two-dimensional interpolation function for irregularly-spaced data"); in smoothed particle hydrodynamics the normalised sum |
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{PointKernel, PointMixing, PointSet};
///
/// let positions = vec![DVec3::ZERO, DVec3::X];
/// let points = PointSet::new(positions, vec![2.0; 2], vec![1.0; 2], vec![3.0, 5.0], PointKernel::Cone)?;
/// let mean = points.with_mixing(PointMixing::Mean)?;
/// assert_eq!(mean.field(0.5 * DVec3::X), Some(4.0), "half-way");
/// assert_eq!(mean.field(-1.5 * DVec3::X), Some(3.0), "where one point reaches, its value");
/// # Ok::<(), vr_core::PointError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum PointMixing {
    /// Sum of the contributions.
    #[default]
    Sum,
    /// Weighted mean of the values.
    Mean,
}

impl PointMixing {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Sum, Self::Mean];

    /// Name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sum => "sum",
            Self::Mean => "mean",
        }
    }

    /// The mixing of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|m| m.name() == name)
    }
}

impl std::fmt::Display for PointMixing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
