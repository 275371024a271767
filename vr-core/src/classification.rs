//! Order of interpolation and classification.

/// Order of interpolation and classification in a renderer that reconstructs the field from voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Classification {
    /// Values are interpolated, then classified.
    #[default]
    Post,
    /// Voxels or points are classified, then their optical properties are interpolated.
    Pre,
}
