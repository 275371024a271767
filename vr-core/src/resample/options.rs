//! Choices of a resampling.

/// Number of voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Resolution {
    /// The spacing of the finest cells, as far as [`Resampling::max_finest`] allows; the default.
    #[default]
    Finest,
    /// So many voxels along x, y and z.
    Dims([usize; 3]),
    /// So many world units between voxels at most, along each axis.
    Spacing(f64),
}

/// Way from the volume's values to that of a voxel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum ResampleFilter {
    /// The value at the voxel; the default.
    #[default]
    Point,
    /// The mean over the voxel's box, as far as it is not vacuum.
    Box,
}

impl ResampleFilter {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Point, Self::Box];

    /// Name in options and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Box => "box",
        }
    }

    /// The filter of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.name() == name)
    }

    /// Samples of a voxel along each axis. An odd number has one at the voxel itself.
    pub(super) fn samples(self) -> usize {
        match self {
            Self::Point => 1,
            Self::Box => 3,
        }
    }
}

impl std::fmt::Display for ResampleFilter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Choices of a resampling, with those that suit most volumes as the default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resampling {
    /// Number of voxels.
    pub resolution: Resolution,
    /// Way from the volume's values to that of a voxel.
    pub filter: ResampleFilter,
    /// True if voxels are corrected so that the integral of the field stays what it was.
    pub conserve: bool,
    /// Largest number of voxels that may be asked for; 4 bytes each.
    pub max_voxels: usize,
    /// Largest number of voxels that [`Resolution::Finest`] takes: beyond it, all axes are coarsened alike.
    pub max_finest: usize,
}

impl Default for Resampling {
    fn default() -> Self {
        Self {
            resolution: Resolution::Finest,
            filter: ResampleFilter::Point,
            conserve: false,
            max_voxels: 1 << 29,
            max_finest: 1 << 24,
        }
    }
}
