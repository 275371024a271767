//! Rules that integrate the light of a step.

use vr_core::Filter;

/// Rule that integrates the light of a step. The rules differ where light is integrated (over, accumulate); other operators
/// look at one sample a step, in its middle (or its begin, by [`Rule::Left`]).
///
/// The orders hold for smooth fields. A trilinear field has kinks at cell faces, and a step that has one inside is off by the
/// square of its length under any rule: [`Traversal::Cells`](super::Traversal::Cells) ends steps there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rule {
    /// Default for the scene: [`Rule::Quadratic`] in local steps through grids with a continuous filter where the transfer function jumps, or rises and falls within
    /// a 64th of the volume's range of values; [`Rule::Midpoint`] elsewhere.
    #[default]
    Auto,
    /// Midpoint rule, by the value in the middle of the step: order 2, and 1 at jumps of the transfer function.
    Midpoint,
    /// Left rectangles, by the value where the ray enters the step: order 1. For study, not for use.
    Left,
    /// Pre-integration of a value that goes linearly from the begin of the step to its end: over all values between, by a table
    /// ([`vr_kernels::tables::PreIntegrated`]): order 2, at kinks and jumps of the transfer function, too. One sample a step.
    Linear,
    /// Pre-integration of the parabola through the values at begin, middle and end of the step: order 4, at kinks of the transfer
    /// function, too, where Simpson's rule has 2. Two samples a step.
    Quadratic,
    /// Integration to rounding of the cubic that a trilinear field is along a ray in each cell: needs [`Traversal::Cells`](super::Traversal::Cells), whose
    /// steps it does not cut further, and the trilinear filter. Four samples a cell, each step integrated in f64: for study.
    Exact,
}

impl Rule {
    /// Returns the name that options use.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Midpoint => "midpoint",
            Self::Left => "left",
            Self::Linear => "linear",
            Self::Quadratic => "quadratic",
            Self::Exact => "exact",
        }
    }

    /// True if the rule makes sense for a filter's field: where the field jumps, the values between two samples are not on the ray.
    pub(crate) fn goes_with(self, filter: Filter) -> bool {
        match self {
            Self::Auto | Self::Midpoint | Self::Left => true,
            Self::Linear | Self::Quadratic => filter.is_continuous(),
            Self::Exact => filter == Filter::Trilinear,
        }
    }
}
