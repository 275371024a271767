//! From which end rays are composited.

/// From which end the samples of a ray are composited under `over`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CompositingOrder {
    /// From the eye into the depth; can stop early.
    FrontToBack {
        /// Opacity in (0, 1] at which a ray ends; 1: where nothing behind can be seen at all.
        ///
        /// No pixel changes by more than `1 − termination`: that holds as it stands where no point of the medium shines brighter
        /// than 1, and where one can, rays go on correspondingly longer.
        termination: f64,
    },
    /// From the depth to the eye: the same sum, rounded otherwise. It cannot stop early, and it is defined for `over` alone.
    BackToFront,
}

impl CompositingOrder {
    /// The opacity at which rays end by default: the 10⁻⁴ that this can cost is a fortieth of what an 8-bit picture can show.
    pub const TERMINATION: f64 = 0.9999;

    /// Front to back, ended only by what is opaque in all bits.
    pub const WHOLE_RAY: Self = Self::FrontToBack { termination: 1.0 };
}

impl Default for CompositingOrder {
    fn default() -> Self {
        Self::FrontToBack { termination: Self::TERMINATION }
    }
}
